"""What a file takes from a room by its name is declared there, so that it is found whatever was imported before."""

import ast
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[1]
ROOMS = ("model", "estimation", "trajectories", "report", "fleet", "live", "common")
READERS = (*ROOMS, "commands", "benchmarks", "examples", "cli.py")
"""Folders and a file that take names from rooms."""


def rooms_of(tree: ast.Module) -> set[str]:
    """Rooms that a file imports as a whole: ``from .. import model``."""
    imports = (
        node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.level and not node.module
    )
    return {name.name for node in imports for name in node.names} & set(ROOMS)


def chains(tree: ast.Module) -> Iterator[tuple[str, ...]]:
    """Names taken one from the other: ``model.stand_in.rehearsed``."""
    for node in ast.walk(tree):
        names = []
        while isinstance(node, ast.Attribute):
            names.append(node.attr)
            node = node.value
        if isinstance(node, ast.Name) and names:
            yield (node.id, *reversed(names))


def undeclared(chain: tuple[str, ...]) -> str | None:
    """The first name of a chain that its package does not declare."""
    package: ModuleType = import_module(f"dynident.{chain[0]}")
    for name in chain[1:]:
        if hasattr(package, "__path__") and "__getattr__" in vars(package) and name not in dir(package):
            return f"{package.__name__}.{name}"
        inner = getattr(package, name)
        if not isinstance(inner, ModuleType):
            return None
        package = inner
    return None


def test_a_name_that_is_not_declared_is_found_out() -> None:
    assert undeclared(("model", "inertia_of_nothing")) == "dynident.model.inertia_of_nothing"
    assert undeclared(("model", "stand_in", "rehearsed")) is None


@pytest.mark.parametrize("room", READERS)
def test_names_taken_from_rooms_are_declared(room: str) -> None:
    missing = []
    for path in sorted((ROOT / room).rglob("*.py")) or [ROOT / room]:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        rooms = rooms_of(tree)
        missing += [name for chain in chains(tree) if chain[0] in rooms and (name := undeclared(chain))]
    assert not missing
