"""A wheel is built from an sdist, and installed into an empty environment, without a network."""

import os
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet", "--no-input")
OFFLINE = ("--no-index", "--no-deps")
IMPORT_ALL = """
import importlib, sys, dynident
for name in sys.argv[1:]:
    importlib.import_module(name)
from dynident.model import load_robot, robot_names
print(dynident.__file__, [load_robot(name).n for name in robot_names()])
"""


def run(*command: str | Path, cwd: Path | None = None) -> str:
    """Output of a program that sees no other copy of the package."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "PIP_"))}
    environment["PIP_CONFIG_FILE"] = os.devnull
    answer = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False, env=environment)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    return answer.stdout


@pytest.fixture(scope="module")
def sdist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built of a copy: building leaves files."""
    folder = tmp_path_factory.mktemp("built")
    away = shutil.ignore_patterns(".*", "build", "dist", "*.egg-info", "__pycache__", "site", "demo")
    shutil.copytree(ROOT, folder / "dynident", ignore=away)
    code = f"from setuptools import build_meta as b; print(b.build_sdist({str(folder)!r}))"
    return folder / run(sys.executable, "-c", code, cwd=folder / "dynident").splitlines()[-1]


@pytest.fixture(scope="module")
def wheel(sdist: Path) -> Path:
    """Built from the sdist, so that it needs nothing that the sdist lacks."""
    run(*PIP, "wheel", "--no-build-isolation", *OFFLINE, "--wheel-dir", sdist.parent, sdist)
    (archive,) = sdist.parent.glob("*-py3-none-any.whl")  # pure Python: one wheel for every system
    return archive


def shipped() -> set[str]:
    """Files of the packages and their data, as the repository has them."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    files, data = set(), project["package-data"]
    for package in project["packages"]:
        folder = ROOT / Path(*package.split(".")[1:])
        for glob in ("*.py", *data["*"], *data.get(package, ())):
            files |= {f"dynident/{path.relative_to(ROOT).as_posix()}" for path in folder.glob(glob)}
    return files


@pytest.mark.long
def test_the_sdist_holds_all_that_belongs_to_the_work(sdist: Path) -> None:
    with tarfile.open(sdist) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    for folder in ("tests", "docs", "examples", "benchmarks"):
        files = {path for path in (ROOT / folder).rglob("*.*") if path.is_file() and path.suffix != ".pyc"}
        assert {path.relative_to(ROOT).as_posix() for path in files if ".pytest_cache" not in path.parts} <= names


@pytest.mark.long
def test_the_wheel_holds_the_packages_and_nothing_else(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if ".dist-info/" not in name}
        (license_file,) = [name for name in archive.namelist() if name.endswith("/LICENSE")]
        assert "BSD" in archive.read(license_file).decode()
    assert names == shipped()


@pytest.mark.long
def test_the_wheel_is_installed(wheel: Path, tmp_path: Path) -> None:
    """Every module is imported, and the command runs; dependencies are seen where they are installed."""
    home = tmp_path / "environment"
    venv.EnvBuilder(with_pip=False).create(home)
    programs = home / ("Scripts" if sys.platform == "win32" else "bin")
    run(*PIP, "--python", programs / "python", "install", *OFFLINE, wheel)
    packages = Path(sysconfig.get_path("purelib", "venv", {"base": str(home), "platbase": str(home)}))
    dependencies = {sysconfig.get_path("purelib"), sysconfig.get_path("platlib")}
    (packages / "dependencies.pth").write_text("\n".join(sorted(dependencies)) + "\n", encoding="utf-8")
    scripts = "dynident/examples/"  # which do their work when they are imported
    files = sorted(name for name in shipped() if name.endswith(".py") and not name.startswith(scripts))
    modules = [name.removesuffix(".py").removesuffix("/__init__").replace("/", ".") for name in files]
    printed = run(programs / "python", "-c", IMPORT_ALL, *modules, cwd=tmp_path)
    assert Path(printed.split(" [")[0]).is_relative_to(home)
    assert "[7, 6, 6" in printed
    assert len(modules) > 60
    assert run(programs / "dynident", "--version", cwd=tmp_path).startswith("dynident ")
    assert "--out" in run(programs / "python", "-m", "dynident.examples.figures", "--help", cwd=tmp_path)
    assert "--lowered" in run(programs / "python", ROOT / "benchmarks", "payload_sets", "--help", cwd=tmp_path)
    code = ("codegen", "--robot", "rx90", "--function", "gravity", "--out", "c")
    paths = run(programs / "dynident", *code, cwd=tmp_path).splitlines()
    assert len(paths) == 3
    assert all((tmp_path / path).is_file() for path in paths)
