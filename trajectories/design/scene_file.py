"""Reads a scene from TOML: what stands in the way of a motion."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, ClassVar

from msgspec import Meta, structs

from ...common.schema import Real, Table, Triple, at, naming, read_toml
from .collision import Capsule, HalfSpace, Scene

_Name = Annotated[str, Meta(min_length=1)]


class _Body(Table, frozen=True):
    advice: ClassVar[Mapping[str, str]] = {
        "link": "must be a whole number, 0 for the world",
        "radius": "must be a number [m]",
    }

    name: _Name
    link: int
    radius: Real
    start: Triple = (0.0, 0.0, 0.0)
    end: Triple | None = None


class _Surface(Table, frozen=True):
    name: _Name
    normal: Triple = (0.0, 0.0, 1.0)
    offset: Real = 0.0


class SceneTable(Table, frozen=True):
    """Bodies, surfaces, and which of them keep clear of each other."""

    advice: ClassVar[Mapping[str, str]] = {
        "bodies": "must be tables [[bodies]]",
        "surfaces": "must be tables [[surfaces]]",
        "pairs": "must be pairs of names",
        "may_touch": "must be pairs of names",
        "clearance": "must be a number [m]",
    }

    bodies: tuple[_Body, ...] = ()
    surfaces: tuple[_Surface, ...] = ()
    pairs: tuple[tuple[str, str], ...] = ()
    may_touch: tuple[tuple[str, str], ...] = ()
    clearance: Real = 0.0


def read_scene(path: str | Path) -> Scene:
    """Read a scene; lengths in m, in the frame of each link (link 0: the world).

    ``[[bodies]]``: ``name``, ``link``, ``radius``, ``start`` and, for a capsule, ``end``; ``[[surfaces]]``:
    ``name``, ``normal`` into the free space, ``offset`` along it; ``pairs`` of bodies that keep clear of each
    other, ``may_touch``: (body, surface) pairs that need not; ``clearance``.

    Raises:
        InputError: names the key at fault.
    """
    table = read_toml(path, SceneTable)
    bodies, surfaces = [], []
    with naming(path):
        for number, body in enumerate(table.bodies, start=1):
            with at(f"bodies[{number}]"):
                bodies.append(Capsule(**structs.asdict(body)))
        for number, surface in enumerate(table.surfaces, start=1):
            with at(f"surfaces[{number}]"):
                surfaces.append(HalfSpace(**structs.asdict(surface)))
        return Scene(tuple(bodies), tuple(surfaces), table.pairs, table.may_touch, table.clearance)
