"""Libraries that only some formats need: the extra ``dynident[logs]``."""

from importlib import import_module
from typing import Any

from ...common.errors import InputError


def extra(module: str, what: str) -> Any:
    """Import a library of the extra.

    Raises:
        InputError: if it is not installed.
    """
    try:
        return import_module(module)
    except ImportError:
        package = module.split(".")[0]
        raise InputError(f"reading {what} needs {package}: install dynident[logs]") from None
