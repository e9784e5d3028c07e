"""A wheel and an sdist are built, and the wheel is installed into an empty environment, without a network."""

import os
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import venv
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

pytestmark = pytest.mark.long

ROOT = Path(__file__).parents[1]
PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet", "--no-input")
OFFLINE = ("--no-index", "--no-deps")


def run(*command: str | Path, cwd: Path | None = None) -> str:
    """Output of a program that sees no other copy of the package."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "PIP_"))}
    environment["PIP_CONFIG_FILE"] = os.devnull
    answer = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False, env=environment)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    return answer.stdout


def results(place: Path) -> set[str]:
    """The folder that ``make demo`` leaves at the root."""
    return {"demo"} if place == ROOT else set()


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the repository: building leaves files beside the sources."""
    folder = tmp_path_factory.mktemp("source") / "dynident"
    away = shutil.ignore_patterns(".*", "build", "dist", "*.egg-info", "__pycache__", "docs")
    shutil.copytree(ROOT, folder, ignore=lambda place, names: away(place, names) | results(Path(place)))
    return folder


@pytest.fixture(scope="module")
def sdist(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("sdist")
    run(sys.executable, "-c", f"from setuptools import build_meta as b; b.build_sdist({str(target)!r})", cwd=source)
    (archive,) = target.iterdir()
    return archive


@pytest.fixture(scope="module")
def wheel(sdist: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built from the sdist, so that it needs nothing that the sdist lacks."""
    target = tmp_path_factory.mktemp("wheel")
    run(*PIP, "wheel", "--no-build-isolation", *OFFLINE, "--wheel-dir", target, sdist)
    (archive,) = target.iterdir()
    return archive


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Folder of programs of an empty environment with the wheel; dependencies are seen where they are installed."""
    home = tmp_path_factory.mktemp("environment")
    venv.EnvBuilder(with_pip=False).create(home)
    programs = home / ("Scripts" if sys.platform == "win32" else "bin")
    run(*PIP, "--python", programs / "python", "install", *OFFLINE, wheel)
    scheme = {"base": str(home), "platbase": str(home)}
    packages = Path(sysconfig.get_path("purelib", "venv", scheme))
    dependencies = {sysconfig.get_path("purelib"), sysconfig.get_path("platlib")}
    (packages / "dependencies.pth").write_text("\n".join(sorted(dependencies)) + "\n", encoding="utf-8")
    yield programs
    shutil.rmtree(home)


def shipped() -> set[str]:
    """Files of the packages and their data, as the repository has them."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    files, data = set(), project["package-data"]
    for package in project["packages"]:
        folder = ROOT / Path(*package.split(".")[1:])
        for glob in ("*.py", *data["*"], *data.get(package, ())):
            files |= {f"dynident/{path.relative_to(ROOT).as_posix()}" for path in folder.glob(glob)}
    return files


def test_the_wheel_holds_the_packages_and_nothing_else(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if ".dist-info/" not in name}
        (license_file,) = [name for name in archive.namelist() if name.endswith("/LICENSE")]
        assert "BSD" in archive.read(license_file).decode()
    assert names == shipped()
    assert wheel.name.endswith("-py3-none-any.whl")  # pure Python: one wheel for every system


def test_every_module_imports_from_the_wheel(wheel: Path, installed: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        files = [name for name in archive.namelist() if name.endswith(".py")]
    modules = [name.removesuffix(".py").removesuffix("/__init__").replace("/", ".") for name in files]
    code = (
        "import importlib, sys, dynident\n"
        "for name in sys.argv[1:]:\n    importlib.import_module(name)\n"
        "from dynident.model import load_robot, robot_names\n"
        "print(dynident.__file__, [load_robot(name).n for name in robot_names()])"
    )
    printed = run(installed / "python", "-c", code, *modules, cwd=tmp_path)
    place = Path(printed.split(" [")[0])
    assert place.is_relative_to(installed.parent)
    assert "[7, 6, 6" in printed
    assert len(modules) > 60


def test_the_command_is_installed(installed: Path, tmp_path: Path) -> None:
    helped = run(installed / "dynident", "--help", cwd=tmp_path)
    for command in ("payload", "identify", "export"):
        assert command in helped
    assert run(installed / "dynident", "--version", cwd=tmp_path).startswith("dynident ")
    code = ("codegen", "--robot", "rx90", "--function", "gravity", "--out", "c")
    paths = run(installed / "dynident", *code, cwd=tmp_path).splitlines()
    assert len(paths) == 3
    assert all((tmp_path / path).is_file() for path in paths)
