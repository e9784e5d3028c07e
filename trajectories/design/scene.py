"""Scenes: bodies, floor and walls in the way of a motion, as values, as a TOML file, and as a limit.

Bodies are capsules fixed to link frames (a sphere is a capsule whose ends are the same). Frame 0 stands in the
world, so that a capsule fixed to it is an obstacle; floor and walls are half-spaces. Distances are continuous and
have slopes everywhere but where two axes cross; slopes come from CasADi through the batch kernel.
"""

import functools
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, ClassVar

import casadi as ca
import numpy as np
from msgspec import Meta

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.schema import Real, Table, Triple, read_toml
from ...model import Robot
from ...model.kernel.kernel import Kernel
from ...model.kinematics import link_frames
from .limits import Limit, State

_TINY = 1e-12  # m^2: keeps slopes finite where two axes touch, and spheres have an axis of no length
_UNIT = 0.1  # m

_Name = Annotated[str, Meta(min_length=1)]
_Pairs = tuple[tuple[str, str], ...]


class Capsule(Table, frozen=True):
    """Capsule: all points within ``radius`` of the line from ``start`` to ``end``, in the frame of a link.

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
        """True if both ends are the same."""
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
    """Scene of bodies, surfaces and the pairs that must stay apart.

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
    """Read a scene: fields of ``Scene``, of ``Capsule`` in ``[[bodies]]``, of ``HalfSpace`` in ``[[surfaces]]``.

    Raises:
        InputError: names the key at fault.
    """
    return read_toml(path, Scene)


def clearance(robot: Robot, scene: Scene) -> Limit:
    """Limit the distances in the scene, a column per pair; values in units of 0.1 m.

    Raises:
        InputError: if the scene names a link that the robot does not have, or nothing could collide.
    """
    *functions, labels = _functions(robot, scene)
    distance, adjoint = map(Kernel, functions)
    unit, low, high = (np.full(len(labels), value) for value in (_UNIT, scene.clearance / _UNIT, np.inf))

    def values(state: State) -> Array:
        return np.asarray(distance(state.samples.q).T / unit)

    def pullback(state: State, slope: Array, into: State) -> None:
        into.samples.q[...] += adjoint(state.samples.q, slope / unit).T

    return Limit("clearance", "clearance", labels, low, high, np.zeros(len(labels)), unit, values, pullback)


@functools.lru_cache(maxsize=16)
def _functions(robot: Robot, scene: Scene) -> tuple[ca.Function, ca.Function, tuple[str, ...]]:
    """Make functions of distances (one per pair) and of their adjoint, and name the pairs."""
    if any(body.link > robot.n for body in scene.bodies):
        raise InputError(f"the scene names a link that robot {robot.name!r} does not have: it has {robot.n}")
    q = ca.SX.sym("q", robot.n)
    frames = link_frames(robot, q)
    axes, distances = dict[str, tuple[ca.SX, ca.SX]](), dict[str, ca.SX]()
    for body in scene.bodies:
        R, p = frames[body.link]
        first, last = (p + R @ ca.SX(list(end)) for end in (body.start, body.end or body.start))
        axes[body.name] = first, first if body.sphere else last
        for surface in scene.surfaces:
            if body.link > 0 and (body.name, surface.name) not in scene.may_touch:
                normal = np.array(surface.normal) / np.linalg.norm(surface.normal)
                ends = (
                    {body.name: first}
                    if body.sphere
                    else {f"{body.name}, start,": first, f"{body.name}, end,": last}
                )
                for label, end in ends.items():
                    height = ca.dot(ca.SX(normal.tolist()), end) - surface.offset
                    distances[f"{label} to {surface.name}"] = height - body.radius
    radius = {body.name: body.radius for body in scene.bodies}
    for a, b in scene.pairs:
        distances[f"{a} to {b}"] = _segments_apart(axes[a], axes[b]) - radius[a] - radius[b]
    distances = {label: value for label, value in distances.items() if ca.depends_on(value, q)}
    if not distances:
        raise InputError("nothing in the scene can collide: give surfaces or pairs, and bodies on moving links")
    distance = ca.cse(ca.vertcat(*distances.values()))
    seed = ca.SX.sym("seed", len(distances))
    slope = ca.cse(ca.densify(ca.jtimes(distance, q, seed, True)))
    return ca.Function("distance", [q], [distance]), ca.Function("adjoint", [q, seed], [slope]), tuple(distances)


def _segments_apart(first: tuple[ca.SX, ca.SX], second: tuple[ca.SX, ca.SX]) -> ca.SX:
    """Distance of two segments (Ericson, Real-Time Collision Detection, 5.1.9), zero-length ones included."""
    (p1, q1), (p2, q2) = first, second
    u, v, r = q1 - p1, q2 - p2, p1 - p2
    a, e = ca.dot(u, u) + _TINY, ca.dot(v, v) + _TINY
    c, f, b = ca.dot(u, r), ca.dot(v, r), ca.dot(u, v)
    s = _unit((b * f - c * e) / (a * e - b * b + _TINY))
    t = _unit((b * s + f) / e)
    gap = r + _unit((b * t - c) / a) * u - t * v
    return ca.sqrt(ca.dot(gap, gap) + _TINY)


def _unit(x: ca.SX) -> ca.SX:
    return ca.fmin(ca.fmax(x, 0), 1)
