"""The plan of the house: rooms, directions of imports, what is packaged, what is imported when."""

import ast
import importlib
import inspect
import subprocess
import sys
import tomllib
from fnmatch import fnmatch
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
ROOMS = ("common", "model", "estimation", "trajectories", "apps")
FILES = sorted([*ROOT.glob("*.py"), *(path for room in ROOMS for path in (ROOT / room).rglob("*.py"))])
PACKAGES = sorted({"dynident", *(".".join(("dynident", *path.parent.relative_to(ROOT).parts)) for path in FILES)})
PUBLIC = [f"dynident.{room}" for room in ("model", "estimation", "trajectories")]


def project() -> dict[str, Any]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def test_every_package_is_listed() -> None:
    """A package that is not listed is missing from the wheel."""
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
        path for room in ROOMS for path in (ROOT / room).rglob("*.*") if path.suffix not in (".py", ".pyi", ".pyc")
    ]
    assert {"rx90.toml", "tx40.toml", "ur10e.toml"} <= {path.name for path in data}
    for path in [*data, ROOT / "py.typed"]:
        homes = {
            package: path.relative_to(ROOT / Path(*package.split(".")[1:])).as_posix()
            for package in listed
            if path.is_relative_to(ROOT / Path(*package.split(".")[1:]))
        }
        assert any(fnmatch(name, glob) for package, name in homes.items() for glob in listed[package]), path


@pytest.mark.parametrize("module", PUBLIC)
def test_every_public_name(module: str) -> None:
    """It is there, listed once, and says what it is."""
    room = importlib.import_module(module)
    assert room.__doc__
    assert len(set(room.__all__)) == len(room.__all__)
    for name in room.__all__:
        assert documented(getattr(room, name), name, Path(inspect.getfile(room)).parent), f"{module}.{name}"


STUBS = [path for room in ROOMS for path in (ROOT / room).rglob("__init__.pyi")]


@pytest.mark.parametrize("stub", STUBS, ids=str)
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
    command = [sys.executable, "-c", f"{code}\nimport sys\nprint(*sys.modules, file=sys.stderr)"]
    return set(subprocess.run(command, check=True, capture_output=True, text=True).stderr.split())


@pytest.mark.parametrize("words", [[], ["--help"], ["--version"]])
def test_help_and_version_load_nothing_heavy(words: list[str]) -> None:
    """The command answers before NumPy would be loaded, and so does the package."""
    loaded = modules_after(f"import dynident\nfrom dynident.cli import main\nif {words}:\n    main({words})")
    assert "dynident.cli" in loaded
    assert not loaded & {"numpy", "casadi", "scipy", "matplotlib", "msgspec", *(() if words else ("rich", "cvxpy"))}


def test_estimation_waits_with_what_is_slow() -> None:
    loaded = modules_after("from dynident.estimation import answer_payload")
    assert "numpy" in loaded
    assert not loaded & {"cvxpy", "matplotlib", "scipy.signal", "scipy.interpolate", "rich"}


def test_rooms_are_found_in_the_package_only() -> None:
    """At top level their relative imports fail, so that no second copy of a class is made."""
    code = f"import sys; sys.path.insert(0, {str(ROOT)!r}); import estimation"
    answer = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True)
    assert "attempted relative import beyond top-level package" in answer.stderr
