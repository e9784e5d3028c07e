"""The plan of the house: rooms, directions of imports, what is packaged, what is imported when."""

import ast
import importlib
import inspect
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from fnmatch import fnmatch
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import dynident
import pytest
from dynident.model import load_robot

ROOT = Path(__file__).parents[1]
ROOMS = ("common", "model", "estimation", "trajectories", "live", "fleet", "report")
HANDS = ("__main__.py", "cli.py", "commands")
"""What hands values from room to room."""
MAY_IMPORT: dict[str, set[str]] = {
    "common": set(),
    "model": {"common"},
    "estimation": {"common", "model"},
    "trajectories": {"common", "model"},
    "live": {"common"},
    "fleet": {"common", "model", "estimation"},
    "report": {"common", "model", "estimation", "trajectories", "fleet"},
    "__init__.py": {"common", "model", "estimation", "trajectories"},
} | {name: set(ROOMS) for name in HANDS}
FILES = sorted(
    [*ROOT.glob("*.py"), *(path for room in (*ROOMS, "commands") for path in (ROOT / room).rglob("*.py"))],
)
PACKAGES = sorted({"dynident", *(".".join(("dynident", *path.parent.relative_to(ROOT).parts)) for path in FILES)})
PUBLIC = [f"dynident.{room}" for room in ("model", "estimation", "trajectories")]


def names(paths: list[Path]) -> list[str]:
    return [path.relative_to(ROOT).as_posix() for path in paths]


def place(path: Path) -> str:
    """The room of a file, or the file itself at the top."""
    return path.relative_to(ROOT).parts[0]


PLACES = sorted({place(path) for path in FILES})


@cache
def imported(path: Path) -> tuple[tuple[int, tuple[str, ...]], ...]:
    """Level (0: absolute) and full module path of every import, in functions and type checks too."""
    return tuple(imports_of(ast.parse(path.read_text(encoding="utf-8")), path))


def imports_of(tree: ast.Module, path: Path) -> Iterator[tuple[int, tuple[str, ...]]]:
    """Level and full module path of every import in the tree of a file."""
    here = path.relative_to(ROOT).parent.parts
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((0, tuple(alias.name.split("."))) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield 0, tuple((node.module or "").split("."))
        elif isinstance(node, ast.ImportFrom):
            assert node.level <= len(here) + 1, f"{path} imports from above the package"
            base = (*here[: len(here) + 1 - node.level], *(node.module.split(".") if node.module else ()))
            yield from ((node.level, (*base, alias.name)) for alias in node.names)


def project() -> dict[str, Any]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("room", PLACES)
def test_imports_go_one_way(room: str) -> None:
    """Model imports no room; estimation and trajectories only model; report is imported by the hands alone."""
    strangers = set(ROOMS) - {room} - MAY_IMPORT[room]
    assert not [
        (path.name, module)
        for path in FILES
        if place(path) == room
        for level, module in imported(path)
        if level and module[0] in strangers
    ]


@pytest.mark.parametrize("room", PLACES)
def test_rooms_import_each_other_relatively(room: str) -> None:
    packages = {"dynident", "tests", *ROOMS}
    assert not [
        (path.name, module)
        for path in FILES
        if place(path) == room
        for level, module in imported(path)
        if level == 0 and module[0] in packages
    ]


def test_nobody_imports_the_hands() -> None:
    users = {
        place(path)
        for path in FILES
        for level, module in imported(path)
        if level and module[0] in ("cli", "commands")
    }
    assert users == set(HANDS)


def test_import_checker_sees_what_it_should() -> None:
    """The two tests above would pass without a word if it saw nothing."""
    rooms = {module[0] for path in FILES for level, module in imported(path) if level}
    assert set(ROOMS) <= rooms
    heavy = {module[0] for path in FILES for level, module in imported(path) if not level}
    assert {"numpy", "casadi", "scipy", "matplotlib"} <= heavy


def test_every_package_is_listed() -> None:
    """What is not listed is missing from the wheel."""
    assert all((ROOT / Path(*name.split(".")[1:]) / "__init__.py").is_file() for name in PACKAGES)
    assert sorted(project()["tool"]["setuptools"]["packages"]) == PACKAGES


def test_every_part_is_seen_as_one_package() -> None:
    """Type checker and documentation find the parts below one name, and no way leads back to where they began."""
    links = {path.name: path.resolve() for path in (ROOT / ".typing/dynident").iterdir()}
    rooms = {name.split(".")[1] for name in PACKAGES if "." in name} | {"tests", "benchmarks", "examples"}
    files = {path.name for path in ROOT.glob("*.py*") if path.is_file() and path.suffix != ".toml"}
    assert links == {name: (ROOT / name).resolve() for name in rooms | files | {"py.typed"}}


def test_every_data_file_is_listed() -> None:
    listed = project()["tool"]["setuptools"]["package-data"]
    data = [
        path
        for room in (*ROOMS, "commands")
        for path in (ROOT / room).rglob("*.*")
        if path.suffix not in (".py", ".pyi", ".pyc")
    ]
    assert {"rx90.toml", "tx40.toml", "ur10e.toml", "paper_tables.toml"} <= {path.name for path in data}
    for path in [*data, ROOT / "py.typed"]:
        homes = {
            package: path.relative_to(ROOT / Path(*package.split(".")[1:])).as_posix()
            for package in listed
            if path.is_relative_to(ROOT / Path(*package.split(".")[1:]))
        }
        assert any(fnmatch(name, glob) for package, name in homes.items() for glob in listed[package]), path


ROBOTS = sorted((ROOT / "model/robots").glob("*.toml"))


@pytest.mark.parametrize("path", ROBOTS, ids=[path.stem for path in ROBOTS])
def test_every_robot_loads_by_name_and_by_path(path: Path) -> None:
    assert load_robot(path.stem) == load_robot(path)


@pytest.mark.parametrize("module", PUBLIC)
def test_every_public_name(module: str) -> None:
    """It is there, listed once, and says what it is."""
    room = importlib.import_module(module)
    assert room.__doc__
    assert len(set(room.__all__)) == len(room.__all__)
    for name in room.__all__:
        assert documented(getattr(room, name), name, Path(inspect.getfile(room)).parent), f"{module}.{name}"


STUBS = [path for room in ROOMS for path in (ROOT / room).rglob("__init__.pyi")]


@pytest.mark.parametrize("stub", STUBS, ids=names(STUBS))
def test_no_file_is_called_as_a_name_beside_it(stub: Path) -> None:
    """Once imported, a file would stand in the place of the name that its room offers."""
    beside = {path.stem for path in stub.parent.glob("*.py")} | {
        path.parent.name for path in stub.parent.glob("*/__init__.py")
    }
    offered = {
        alias.name
        for node in ast.parse(stub.read_text(encoding="utf-8")).body
        if isinstance(node, ast.ImportFrom) and node.module
        for alias in node.names
    }
    assert not offered & beside


def documented(value: object, name: str, folder: Path) -> bool:
    """A docstring of its own: not the one that dataclasses make, nor a built-in type's."""
    if inspect.isclass(value) or inspect.isroutine(value):
        text = value.__doc__ or ""
        return bool(text) and not text.startswith(f"{name}(")
    return any(constant_has_text(path, name) for path in folder.rglob("*.py"))


def constant_has_text(path: Path, name: str) -> bool:
    body = ast.parse(path.read_text(encoding="utf-8")).body
    for node, after in pairwise(body):
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        if any(isinstance(target, ast.Name) and target.id == name for target in targets):
            return isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
    return False


def modules_after(code: str) -> set[str]:
    command = [sys.executable, "-c", f"{code}\nimport sys\nprint(*sys.modules)"]
    return set(subprocess.run(command, check=True, capture_output=True, text=True).stdout.split())


@pytest.mark.parametrize("module", ["dynident", "dynident.cli"])
def test_light_imports(module: str) -> None:
    """The command answers --help before NumPy would be loaded."""
    loaded = modules_after(f"import {module}")
    assert module in loaded
    assert not loaded & {"numpy", "casadi", "scipy", "matplotlib", "rich", "cvxpy"}


def test_estimation_waits_with_what_is_slow() -> None:
    loaded = modules_after("from dynident.estimation import answer_payload")
    assert "numpy" in loaded
    assert not loaded & {"cvxpy", "matplotlib", "scipy.signal", "scipy.interpolate", "rich"}


SLOW = {"clarabel", "cvxpy", "distributed", "fsspec", "matplotlib", "mujoco", "pandas", "pyarrow", "scipy", "viser"}
"""Packages that take long to import, or are an extra: a function may import them where it uses them."""


def inner_imports(tree: ast.Module) -> set[tuple[int, str]]:
    """Line and package of each import within a function; relative ones begin with a dot."""
    packages = set()
    for function in (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)):
        for node in ast.walk(function):
            if isinstance(node, ast.Import):
                packages |= {(node.lineno, alias.name.split(".")[0]) for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                packages.add((node.lineno, "." * node.level + (node.module or "").split(".")[0]))
    return packages


def test_imports_stand_at_the_top() -> None:
    """Within functions only what is slow or an extra, and seldom: rooms wait by themselves (``common/lazy.py``)."""
    inner = [
        (path.relative_to(ROOT).as_posix(), package)
        for path in FILES
        for _, package in inner_imports(ast.parse(path.read_text(encoding="utf-8")))
    ]
    assert not [place for place in inner if place[1] not in SLOW]
    assert len(inner) <= 25


@pytest.mark.parametrize(
    ("line", "package"),
    [("import json", "json"), ("from ..model import Robot", "..model"), ("from . import a", ".")],
)
def test_an_inner_import_is_seen(line: str, package: str) -> None:
    assert inner_imports(ast.parse(f"{line}\ndef f():\n  {line}\n  def g():\n    {line}")) == {
        (3, package),
        (5, package),
    }


def test_rooms_are_found_in_the_package_only() -> None:
    """At top level their relative imports fail, so that no second copy of a class is made."""
    code = f"import sys; sys.path.insert(0, {str(ROOT)!r}); import estimation"
    answer = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True)
    assert "attempted relative import beyond top-level package" in answer.stderr


def test_tests_mirror_the_rooms() -> None:
    folders = {path.parent.relative_to(ROOT / "tests") for path in (ROOT / "tests").rglob("test_*.py")}
    assert {Path("model"), Path("estimation"), Path("trajectories"), Path("report")} <= folders
    for folder in folders:
        room = folder in map(Path, ("docs", "frozen", "mutations")) or (ROOT / folder / "__init__.py").is_file()
        assert room, f"tests/{folder} mirrors no room"
    stems = [path.stem for path in (ROOT / "tests").rglob("test_*.py")]
    assert len(set(stems)) == len(stems), "a test file's name says which it is"


def test_version_is_told_once() -> None:
    assert dynident.__version__ == project()["project"]["version"]
