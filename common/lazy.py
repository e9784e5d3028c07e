"""Rooms whose names are imported on first use, so that importing a room costs nothing."""

import ast
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any


def attach(package: str, file: str) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Make ``__getattr__``, ``__dir__`` and ``__all__`` of a package whose names stand in its ``__init__.pyi``.

    Type checkers read the stub, and so does this function (SPEC 1 of Scientific Python). Where the stub has an
    ``__all__``, the other names are there for the apps, which load them when they are used, and are not public.

    ``package``: ``__name__`` of the package; ``file``: its ``__file__``.
    """
    homes: dict[str, str | None] = {}  # by name the module that it stands in; None for a module of its own
    public: list[str] = []
    for line in ast.parse(Path(file).with_suffix(".pyi").read_text(encoding="utf-8")).body:
        if isinstance(line, ast.ImportFrom):
            module = "." * line.level + line.module if line.module else None
            homes.update(dict.fromkeys((name.name for name in line.names), module))
        elif isinstance(line, ast.Assign):
            public = sorted(ast.literal_eval(line.value))

    def getter(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        home = homes[name]
        value = getattr(import_module(home, package), name) if home else import_module(f".{name}", package)
        setattr(sys.modules[package], name, value)
        return value

    modules = {name for name, home in homes.items() if home is None}
    public = public or sorted(homes.keys() - modules)
    return getter, lambda: sorted({*public, *modules}), public
