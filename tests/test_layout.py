"""The plan of the house: what is packaged, what is imported when, and values that show themselves in brief."""

import subprocess
import sys
import tomllib
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
ROOMS = ("common", "model", "estimation", "trajectories", "apps", "examples")
FILES = sorted([*ROOT.glob("*.py"), *(path for room in ROOMS for path in (ROOT / room).rglob("*.py"))])
PACKAGES = sorted({"dynident", *(".".join(("dynident", *path.parent.relative_to(ROOT).parts)) for path in FILES)})


def project() -> dict[str, Any]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def test_every_package_and_benchmark_is_listed() -> None:
    """What is not listed is missing from the wheel, or from ``make bench``."""
    assert all((ROOT / Path(*name.split(".")[1:]) / "__init__.py").is_file() for name in PACKAGES)
    assert sorted(project()["tool"]["setuptools"]["packages"]) == PACKAGES
    scripts = {one.stem for one in (ROOT / "benchmarks").glob("[a-z]*.py") if "__main__" in one.read_text("utf-8")}
    named = (ROOT / "Makefile").read_text("utf-8").split("for name in ")[1].split(";")[0]
    assert {*named.replace("\\", "").split()} == scripts


def test_every_part_is_seen_as_one_package() -> None:
    """Type checker and documentation find the parts below one name, and no way leads back to where they began."""
    links = {path.name: path.resolve() for path in (ROOT / ".typing/dynident").iterdir()}
    rooms = {name.split(".")[1] for name in PACKAGES if "." in name} | {"tests", "benchmarks"}
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


WITHOUT_IMPORTS: dict[str, tuple[str, set[str]]] = {
    "from dynident.cli import main": (
        "dynident.cli", {"numpy", "casadi", "scipy", "matplotlib", "msgspec", "rich", "cvxpy"}
    ),
    "from dynident.cli import main; main(['--help'])": (
        "dynident.cli", {"numpy", "casadi", "scipy", "matplotlib", "msgspec"}
    ),
    "from dynident.estimation import Identification, PayloadAnswer, answer_payload": (
        "numpy", {"cvxpy", "matplotlib", "scipy.signal", "scipy.interpolate", "rich", "dynident.apps.report"}
    ),
    "import dynident.apps.report.sections.payload": (
        "dynident.apps.report.figures", {"matplotlib", "jinja2"}
    ),
}  # fmt: skip
"""Code, a module that it loads, and those that it can wait for."""


@pytest.mark.parametrize("code", WITHOUT_IMPORTS)
def test_what_is_slow_is_loaded_when_it_is_needed(code: str) -> None:
    own, slow = WITHOUT_IMPORTS[code]
    command = [sys.executable, "-c", f"{code}\nimport sys\nprint(*sys.modules, file=sys.stderr)"]
    loaded = set(subprocess.run(command, check=True, capture_output=True, text=True).stderr.split())
    assert own in loaded
    assert not loaded & slow
