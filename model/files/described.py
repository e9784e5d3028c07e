"""Descriptions that others' tools give: files of xacro, and the names of robot_descriptions, out of its cache."""

import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from difflib import get_close_matches
from importlib import import_module
from io import StringIO
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from ...common import InputError

_INSTALL = "pip install 'dynident[robots]'"
ENDING = "_description"  # ending of the names of robot_descriptions: ``panda_description``


class Source(NamedTuple):
    """File of a description; of a xacro file its arguments, and packages that it names besides its own."""

    path: Path
    arguments: Mapping[str, str] = {}
    packages: Mapping[str, str] = {}


def described(name: str) -> Source:
    """Find the URDF or xacro file of a name of robot_descriptions in the cache of that package; fetch nothing.

    Raises InputError if the package is not installed, has no such URDF, or the file is not in its cache.
    """
    try:
        from robot_descriptions import DESCRIPTIONS, _repositories
    except ImportError:
        raise InputError(f"no robot {name!r} is shipped; for names of robot_descriptions: {_INSTALL}") from None
    known = [key for key, about in DESCRIPTIONS.items() if about.has_urdf]
    if name not in known:
        near = get_close_matches(name.removesuffix(ENDING), [key.removesuffix(ENDING) for key in known], 3, 0.6)
        meant = " or ".join(repr(f"{key}{ENDING}") for key in near)
        hint = f"did you mean {meant}?" if near else "'robot_descriptions list' shows them"
        raise InputError(f"no robot {name!r}, nor a URDF of that name in robot_descriptions: {hint}")
    cache = Path(os.environ.get("ROBOT_DESCRIPTIONS_CACHE", "~/.cache/robot_descriptions")).expanduser()

    def cached(repository: str, commit: str | None = None) -> str:
        own = _repositories.REPOSITORIES[repository].cache_path
        folder = cache / (own if commit is None else f"{own}-{commit}/{own}")
        if not folder.is_dir():
            fault = f"{name}: not in the cache of robot_descriptions, {folder} is missing"
            pull = f"run 'robot_descriptions pull {name}' once, where there is a network"
            raise InputError(f"{fault}: {pull}, or give the path of a URDF")
        return str(folder)

    # A description's module tells where its files are, and clones them as it is imported: not here.
    module = f"robot_descriptions.{name}"
    with _standing_in("robot_descriptions._cache", clone_to_cache=cached):
        sys.modules.pop(module, None)
        about = import_module(module)
        del sys.modules[module]  # the next one may find another cache
    path = Path(getattr(about, "URDF_PATH", None) or about.XACRO_PATH)
    if not path.is_file():
        fault = f"{path} is missing in the cache of robot_descriptions"
        raise InputError(f"{name}: {fault}: delete {cache} and pull again")
    packages = {path.name: str(path) for path in (Path(about.PACKAGE_PATH), Path(about.REPOSITORY_PATH))}
    return Source(path, getattr(about, "XACRO_ARGS", {}), packages | getattr(about, "XACRO_PACKAGE_PATHS", {}))


def expanded(source: Source) -> str:
    """Expand a xacro file to URDF; InputError if the package xacro is not installed or does not take the file."""
    path, arguments, packages = source
    try:
        import xacro
    except ImportError:
        raise InputError(
            f"{path}: a xacro file: {_INSTALL}, or expand it first (xacro FILE > robot.urdf)"
        ) from None

    def find(package: str) -> str:
        own = packages.get(package)
        for place in (Path(own),) if own else package_places(package, path.resolve().parent):
            if place.is_dir():
                return str(place)
        raise LookupError(f"package {package!r} is not found above the file, nor by ROS_PACKAGE_PATH")

    try:
        finding = _standing_in("ament_index_python.packages", get_package_share_directory=find)
        with finding, redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            return str(xacro.process_file(str(path), mappings=dict(arguments)).toxml())
    except Exception as error:  # it evaluates Python of the file's own: anything may come
        message = " ".join(str(error).split()) or type(error).__name__
        advice = "expand it first (xacro FILE ARGUMENT:=VALUE > robot.urdf)"
        raise InputError(f"{path}: xacro failed ({message}): {advice}") from None


def package_places(package: str, folder: Path) -> Iterator[Path]:
    """List where a ROS package may be: in the folders above a file, and in those of ROS's environment."""
    for above in (folder, *folder.parents):
        yield above / package
        if above.name == package:
            yield above
    for root in filter(None, os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)):
        yield from (Path(root) / package, Path(root).parent / package)
    for root in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
        yield Path(root) / "share" / package


@contextmanager
def _standing_in(name: str, **functions: Any) -> Iterator[None]:
    """Replace a module by one that holds these functions only, within the block."""
    made, before = ModuleType(name), sys.modules.get(name)
    vars(made).update(functions)
    sys.modules[name] = made
    try:
        yield
    finally:
        if before is None:
            del sys.modules[name]
        else:
            sys.modules[name] = before
