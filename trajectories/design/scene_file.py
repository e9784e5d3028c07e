"""Reads a scene from TOML: what stands in the way of a motion."""

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ...common.errors import InputError
from .collision import Capsule, HalfSpace, Point, Scene

_SCENE = ("clearance", "bodies", "surfaces", "pairs", "may_touch")
_BODY = ("name", "link", "radius", "start", "end")
_SURFACE = ("name", "normal", "offset")


def read_scene(path: str | Path) -> Scene:
    """Read a scene; lengths in m, in the frame of each link (link 0: the world).

    ``[[bodies]]``: ``name``, ``link``, ``radius``, ``start`` and, for a capsule, ``end``; ``[[surfaces]]``:
    ``name``, ``normal`` into the free space, ``offset`` along it; ``pairs`` of bodies that keep clear of each
    other, ``may_touch``: (body, surface) pairs that need not; ``clearance``.

    Raises:
        InputError: names the key at fault.
    """
    try:
        data = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as text ({error})") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not valid TOML: {error}") from None
    try:
        _known(data, _SCENE, "the file")
        return Scene(
            tuple(_body(entry, k) for k, entry in enumerate(_tables(data, "bodies"))),
            tuple(_surface(entry, k) for k, entry in enumerate(_tables(data, "surfaces"))),
            _pairs(data, "pairs"),
            _pairs(data, "may_touch"),
            _number(data, "clearance", "the file", 0.0),
        )
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _body(entry: Mapping[str, Any], k: int) -> Capsule:
    where = f"bodies[{k}]"
    _known(entry, _BODY, where)
    link = entry.get("link")
    if isinstance(link, bool) or not isinstance(link, int):
        raise InputError(f"key 'link' of {where}: must be a whole number, 0 for the world")
    start = _point(entry, "start", where) or (0.0, 0.0, 0.0)
    return Capsule(_name(entry, where), link, _number(entry, "radius", where), start, _point(entry, "end", where))


def _surface(entry: Mapping[str, Any], k: int) -> HalfSpace:
    where = f"surfaces[{k}]"
    _known(entry, _SURFACE, where)
    normal = _point(entry, "normal", where) or (0.0, 0.0, 1.0)
    return HalfSpace(_name(entry, where), normal, _number(entry, "offset", where, 0.0))


def _known(table: Mapping[str, Any], keys: Sequence[str], where: str) -> None:
    for key in table:
        if key not in keys:
            raise InputError(f"key {key!r} of {where}: unknown; known here: {', '.join(keys)}")


def _tables(data: Mapping[str, Any], key: str) -> list[Mapping[str, Any]]:
    entries = data.get(key, [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise InputError(f"key {key!r}: must be tables [[{key}]]")
    return entries


def _name(entry: Mapping[str, Any], where: str) -> str:
    name = entry.get("name")
    if not isinstance(name, str) or not name:
        raise InputError(f"key 'name' of {where}: must be a text")
    return name


def _number(entry: Mapping[str, Any], key: str, where: str, default: float | None = None) -> float:
    value = entry.get(key, default)
    if not _finite(value):
        raise InputError(f"key {key!r} of {where}: must be a number [m]")
    return float(value)


def _point(entry: Mapping[str, Any], key: str, where: str) -> Point | None:
    if key not in entry:
        return None
    value = entry[key]
    if not isinstance(value, list) or len(value) != 3 or not all(_finite(x) for x in value):
        raise InputError(f"key {key!r} of {where}: must be three numbers [m]")
    x, y, z = (float(v) for v in value)
    return x, y, z


def _pairs(data: Mapping[str, Any], key: str) -> tuple[tuple[str, str], ...]:
    pairs = data.get(key, [])
    good = isinstance(pairs, list) and all(
        isinstance(pair, list) and len(pair) == 2 and all(isinstance(name, str) for name in pair) for pair in pairs
    )
    if not good:
        raise InputError(f"key {key!r}: must be pairs of names")
    return tuple((str(a), str(b)) for a, b in pairs)


def _finite(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e6
