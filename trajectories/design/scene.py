"""What stands in the way of a motion: bodies, floor and walls, as values and as a TOML file.

Bodies are capsules fixed to link frames (a sphere is a capsule whose ends are the same). Frame 0 stands in the
world, so that a capsule fixed to it is an obstacle; floor and walls are half-spaces.
"""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, ClassVar

from msgspec import Meta

from ...common.errors import InputError
from ...common.schema import Real, Table, Triple, read_toml

_Name = Annotated[str, Meta(min_length=1)]
_Pairs = tuple[tuple[str, str], ...]


class Capsule(Table, frozen=True):
    """All points within ``radius`` of the line from ``start`` to ``end``, in the frame of a link.

    Attributes:
        name: for messages.
        link: number of the link; 0 for the world.
        radius: [m].
        start, end: ends of the axis in the link's frame [m]; a sphere if they are the same.
    """

    advice: ClassVar[Mapping[str, str]] = {
        "link": "must be a whole number, 0 for the world",
        "radius": "must be a number [m]",
    }

    name: _Name
    link: int
    radius: Real
    start: Triple = (0.0, 0.0, 0.0)
    end: Triple | None = None

    def __post_init__(self) -> None:
        """Refuse a body without size."""
        if not 0.0 <= self.radius < math.inf or self.link < 0:
            raise InputError(f"body {self.name!r}: link {self.link} and radius {self.radius:g} m are not possible")

    @property
    def sphere(self) -> bool:
        """Whether both ends are the same."""
        return self.end is None or self.end == self.start


class HalfSpace(Table, frozen=True):
    """Floor or wall: bodies stay where ``normal`` · p >= ``offset``.

    Attributes:
        name: for messages.
        normal: direction into the free space, in frame 0.
        offset: of the surface along the unit normal [m].
    """

    name: _Name
    normal: Triple = (0.0, 0.0, 1.0)
    offset: Real = 0.0

    def __post_init__(self) -> None:
        """Refuse a normal without direction."""
        if not 0.0 < math.hypot(*self.normal) < math.inf:
            raise InputError(f"half-space {self.name!r} needs a normal of positive length")


class Scene(Table, frozen=True):
    """Bodies, surfaces and the pairs that must stay apart.

    Attributes:
        bodies: on the links and in the world.
        surfaces: floor and walls; every body of a link keeps clear of all, except ``may_touch``.
        pairs: names of bodies that keep clear of each other.
        may_touch: (body, surface) pairs that need not.
        clearance: smallest distance [m].
    """

    advice: ClassVar[Mapping[str, str]] = {
        "bodies": "must be tables [[bodies]]",
        "surfaces": "must be tables [[surfaces]]",
        "pairs": "must be pairs of names",
        "may_touch": "must be pairs of names",
        "clearance": "must be a number [m]",
    }

    bodies: tuple[Capsule, ...] = ()
    surfaces: tuple[HalfSpace, ...] = ()
    pairs: _Pairs = ()
    may_touch: _Pairs = ()
    clearance: Real = 0.0

    def __post_init__(self) -> None:
        """Refuse names that are not there or stand for two things."""
        names = [body.name for body in self.bodies] + [surface.name for surface in self.surfaces]
        if len(set(names)) != len(names):
            raise InputError("two bodies or surfaces of the scene have the same name")
        for name in {name for pair in (*self.pairs, *self.may_touch) for name in pair} - set(names):
            raise InputError(f"the scene has no body or surface {name!r}: it has {', '.join(names)}")


def read_scene(path: str | Path) -> Scene:
    """Read a scene; lengths in m, in the frame of each link (link 0: the world).

    ``[[bodies]]``: ``name``, ``link``, ``radius``, ``start`` and, for a capsule, ``end``; ``[[surfaces]]``:
    ``name``, ``normal`` into the free space, ``offset`` along it; ``pairs`` of bodies that keep clear of each
    other, ``may_touch``: (body, surface) pairs that need not; ``clearance``.

    Raises:
        InputError: names the key at fault.
    """
    return read_toml(path, Scene)
