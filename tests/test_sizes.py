"""Sizes of the house: what one function does is read at a glance, and a file holds one idea."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FILES = sorted(
    path
    for path in ROOT.rglob("*.py")
    if not {"build", "dist"} & set(path.parts) and not any(part.startswith(".") for part in path.parts)
)
PRODUCT = sorted({path.relative_to(ROOT).parts[0] for path in FILES} - {"tests"})
MOST_LINES, MOST_STEPS, MOST_LINES_OF_A_FILE = 40, 12, 300
Function = ast.FunctionDef | ast.AsyncFunctionDef


def functions(room: str) -> Iterator[tuple[str, Function]]:
    """Every function of a room with its file and name."""
    for path in FILES:
        place = path.relative_to(ROOT)
        if place.parts[0] == room:
            tree = ast.parse(path.read_text(encoding="utf-8"))
            yield from ((f"{place.as_posix()}: {f.name}", f) for f in ast.walk(tree) if isinstance(f, Function))


def lines(function: Function) -> int:
    """Lines from the first to the last, but for the docstring."""
    first, count = function.body[0], (function.end_lineno or 0) - function.lineno + 1
    if ast.get_docstring(function) is None:
        return count
    return count - ((first.end_lineno or 0) - first.lineno + 1)


def complexity(function: Function) -> int:
    """McCabe's number as radon counts it: one, and one for each fork of the way; inner functions apart."""
    return 1 + sum(map(forks, inside(function)))


def inside(node: ast.AST) -> Iterator[ast.AST]:
    """All of a node but its inner functions."""
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, Function):
            yield child
            yield from inside(child)


def forks(node: ast.AST) -> int:
    """Ways that a node opens beside the straight one."""
    if isinstance(node, ast.BoolOp):
        return len(node.values) - 1
    if isinstance(node, ast.comprehension):
        return 1 + len(node.ifs)
    if isinstance(node, ast.For | ast.AsyncFor | ast.While):
        return 1 + bool(node.orelse)
    if isinstance(node, ast.Try):
        return len(node.handlers) + bool(node.orelse)
    return int(isinstance(node, ast.If | ast.IfExp | ast.Assert | ast.match_case))


@pytest.mark.parametrize("room", PRODUCT)
def test_functions_are_short_and_simple(room: str) -> None:
    large = {
        name: (lines(function), complexity(function))
        for name, function in functions(room)
        if lines(function) > MOST_LINES or complexity(function) > MOST_STEPS
    }
    assert not large


@pytest.mark.parametrize("room", [*PRODUCT, "tests"])
def test_a_file_holds_one_idea(room: str) -> None:
    files = [path for path in FILES if path.relative_to(ROOT).parts[0] == room]
    long = {
        path.name: count
        for path in files
        if (count := path.read_text(encoding="utf-8").count("\n")) > MOST_LINES_OF_A_FILE
    }
    assert not long


def of_text(text: str) -> Function:
    """The function that a text defines."""
    function = ast.parse(text).body[0]
    assert isinstance(function, Function)
    return function


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("pass", 1),
        ("if a and b or c: pass\n elif d: pass", 5),
        ("return [x for x in y if x if z], {k for k in y}", 5),
        ("for x in y: pass\n while x: pass", 3),
        ("try: pass\n except A: pass\n except B: pass", 3),
        ("key = lambda x: x if x else y", 2),
        ("match a:\n  case 1: pass\n  case 2: pass", 3),
        ("def g():\n  if x: pass\n return g", 1),
    ],
)
def test_every_fork_counts(body: str, expected: int) -> None:
    assert complexity(of_text(f"def f():\n {body}")) == expected


def test_a_docstring_is_no_line_of_a_function() -> None:
    assert lines(of_text('def f():\n "one\\\n two"\n return 1')) == 2
