"""Plain words in code: first lines of docstrings stand alone, and names say which quantity they hold."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from dynident.tests.docs.pages import blocks

ROOT = Path(__file__).parents[1]
FILES = sorted(
    path
    for path in ROOT.rglob("*.py")
    if not {"build", "dist"} & set(path.parts) and not any(part.startswith(".") for part in path.parts)
)
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
ROOMS = sorted({path.relative_to(ROOT).parts[0] for path in FILES})
LEANING = re.compile(r"(Of|The same|Same|As|Those|These|Its|Their)\b")
"""How a docstring begins that needs the text before it."""
EMPTY = {
    *("asked", "found", "given", "got", "held", "kept", "made", "seen", "taken", "told", "wanted"),
    *("it", "its", "mine", "one", "other", "that", "these", "this", "those", "what", "larger"),
}
"""Participles and pronouns: as a name each could hold anything."""


@cache
def words(room: str) -> tuple[list[str], list[str]]:
    """Docstrings that lean on others, and names that hold anything, of every file of a room with its path."""
    leaning, empty = list[str](), list[str]()
    for path in FILES:
        if path.relative_to(ROOT).parts[0] == room:
            tree, place = ast.parse(path.read_text(encoding="utf-8")), path.relative_to(ROOT).as_posix()
            leaning += [f"{place}: {text}" for text in docstrings(tree) if LEANING.match(text)]
            empty += [f"{place}:{name}" for name in empty_names(tree)]
    return leaning, empty


def docstrings(tree: ast.Module) -> Iterator[str]:
    """The docstrings of a file, its classes and functions."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            yield ast.get_docstring(node) or ""


def empty_names(tree: ast.Module) -> list[str]:
    """Line and name of each argument, local, loop variable and caught error that says nothing.

    Fields are left out, for many are keys of documents; so is ``other`` as what a method compares itself with,
    as Python calls it.
    """
    fields = {
        id(node.target)
        for scope in ast.walk(tree)
        if isinstance(scope, ast.ClassDef)
        for node in scope.body
        if isinstance(node, ast.AnnAssign)
    }
    partners = {
        id(function.args.args[1])
        for scope in ast.walk(tree)
        if isinstance(scope, ast.ClassDef)
        for function in scope.body
        if isinstance(function, ast.FunctionDef)
        and [arg.arg for arg in function.args.args[:2]] == ["self", "other"]
    }
    named = [
        (node.lineno, bound_name(node))
        for node in ast.walk(tree)
        if isinstance(node, ast.Name | ast.arg | ast.ExceptHandler) and id(node) not in fields | partners
    ]
    return [f"{line}: {name}" for line, name in sorted(named) if name in EMPTY]


def bound_name(node: ast.Name | ast.arg | ast.ExceptHandler) -> str:
    """The name that a node binds, empty if none."""
    if isinstance(node, ast.Name):
        return node.id if isinstance(node.ctx, ast.Store) else ""
    return node.arg if isinstance(node, ast.arg) else node.name or ""


@pytest.mark.parametrize("room", ROOMS)
def test_first_lines_of_docstrings_stand_alone(room: str) -> None:
    """A first line that leans on what was said before cannot be read in a list or in a tooltip."""
    assert not words(room)[0]


@pytest.mark.parametrize("line", ["Of each joint.", "The same, turned.", "As ``fit``.", "Their sum."])
def test_a_leaning_line_is_seen(line: str) -> None:
    assert LEANING.match(next(docstrings(ast.parse(repr(line)))))


@pytest.mark.parametrize("room", ROOMS)
def test_names_say_which_quantity_they_hold(room: str) -> None:
    assert not words(room)[1]


@pytest.mark.parametrize("page", PAGES, ids=[page.relative_to(ROOT).as_posix() for page in PAGES])
def test_names_in_pages_say_it_too(page: Path) -> None:
    code = [block.text for block in blocks(page) if block.language == "python"]
    assert not [name for text in code for name in empty_names(ast.parse(text))]


@pytest.mark.parametrize(
    "code",
    [
        "found = 1",
        "held, rest = pair",
        "for one in masses: pass",
        "[one for one in masses]",
        "def weigh(told): pass",
        "def weigh(*, asked): pass",
        "def weigh(**given): pass",
        "key = lambda one: one.mass",
        "def compare(other): pass",
        "class A:\n    def b(self):\n        taken: int = 1",
        "try: pass\nexcept ValueError as this: pass",
        "with open(path) as it: pass",
        "print(kept := 1)",
    ],
)
def test_an_empty_name_is_seen(code: str) -> None:
    assert empty_names(ast.parse(code))


@pytest.mark.parametrize(
    "code",
    [
        "mass = found",
        "class A:\n    held: float",
        "class A:\n    def __eq__(self, other): pass",
        "f(told=mass)",
        "a.given = 1",
    ],
)
def test_a_name_that_is_no_local_is_left_alone(code: str) -> None:
    assert not empty_names(ast.parse(code))
