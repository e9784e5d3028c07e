"""A fault of ours: one line for the user, and a file with what those need who look for it."""

from __future__ import annotations

import platform
import shlex
import sys
import tempfile
import traceback
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version

from .. import __version__
from . import INTERNAL_ERROR

_SOLVERS = ("casadi", "clarabel", "cvxpy", "numpy", "scipy")
"""Packages whose versions decide the numbers."""
_TOLD = 200
"""Letters of a fault that are shown; the file has all."""


def told(fault: Exception, words: Sequence[str]) -> int:
    """Tell of a fault in a command line; returns the exit status."""
    details = [f"dynident {shlex.join(words)}", *versions(), "", *traceback.format_exception(fault)]
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="dynident-fault-", suffix=".txt", delete=False, encoding="utf-8", errors="replace"
        ) as file:
            file.write("\n".join(details))
        where = f"with {file.name}"
    except OSError as error:
        where = f"(its details could not be written: {error.strerror})"
    message = " ".join(f"{type(fault).__name__}: {fault}".split())
    print(f"dynident: internal error, please report {where}: {message[:_TOLD]}", file=sys.stderr)
    return INTERNAL_ERROR


def versions() -> list[str]:
    """What a report of a fault should name."""
    lines = [f"dynident {__version__}"]
    for package in _SOLVERS:
        try:
            lines.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            lines.append(f"{package} not installed")
    return [*lines, f"python {platform.python_version()}"]
