"""Keeping clear of floor, walls, obstacles and the robot itself.

Bodies are capsules fixed to link frames (a sphere is a capsule whose ends are the same). Frame 0 stands in the
world, so that a capsule fixed to it is an obstacle; floor and walls are half-spaces. Distances of capsules are
continuous and have slopes everywhere but where two axes cross; slopes come from CasADi through the batch kernel.
"""

import functools
from dataclasses import dataclass

import casadi as ca
import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Robot
from ...model.kernel import Kernel
from ...model.kinematics import joint_transform
from .limits import Slopes, State

_TINY = 1e-12  # m^2: keeps slopes finite where two axes touch

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Capsule:
    """All points within ``radius`` of the line from ``start`` to ``end``, in the frame of a link.

    Attributes:
        name: for messages.
        link: number of the link; 0 for the world.
        radius: [m].
        start, end: ends of the axis in the link's frame [m]; a sphere if they are the same.
    """

    name: str
    link: int
    radius: float
    start: Point = (0.0, 0.0, 0.0)
    end: Point | None = None

    def __post_init__(self) -> None:
        """Refuse a body without size."""
        if not 0.0 <= self.radius < np.inf or self.link < 0:
            raise InputError(f"body {self.name!r}: link {self.link} and radius {self.radius:g} m are not possible")

    @property
    def sphere(self) -> bool:
        """Whether both ends are the same."""
        return self.end is None or self.end == self.start


@dataclass(frozen=True)
class HalfSpace:
    """Floor or wall: bodies stay where ``normal`` · p >= ``offset``.

    Attributes:
        name: for messages.
        normal: direction into the free space, in frame 0.
        offset: of the surface along the unit normal [m].
    """

    name: str
    normal: Point = (0.0, 0.0, 1.0)
    offset: float = 0.0

    def __post_init__(self) -> None:
        """Refuse a normal without direction."""
        if not 0.0 < np.linalg.norm(self.normal) < np.inf:
            raise InputError(f"half-space {self.name!r} needs a normal of positive length")


@dataclass(frozen=True)
class Scene:
    """Bodies, surfaces and the pairs that must stay apart.

    Attributes:
        bodies: on the links and in the world.
        surfaces: floor and walls; every body of a link keeps clear of all, except ``may_touch``.
        pairs: names of bodies that keep clear of each other.
        may_touch: (body, surface) pairs that need not.
        clearance: smallest distance [m].
    """

    bodies: tuple[Capsule, ...]
    surfaces: tuple[HalfSpace, ...] = ()
    pairs: tuple[tuple[str, str], ...] = ()
    may_touch: tuple[tuple[str, str], ...] = ()
    clearance: float = 0.0

    def __post_init__(self) -> None:
        """Refuse names that are not there or stand for two things."""
        names = [body.name for body in self.bodies] + [surface.name for surface in self.surfaces]
        if len(set(names)) != len(names):
            raise InputError("two bodies or surfaces of the scene have the same name")
        for name in {name for pair in (*self.pairs, *self.may_touch) for name in pair} - set(names):
            raise InputError(f"the scene has no body or surface {name!r}: it has {', '.join(names)}")


class Clearance:
    """Distances in the scene as a limit on the motion, a column per pair; values in units of 0.1 m."""

    def __init__(self, robot: Robot, scene: Scene) -> None:
        """Generate and compile the code.

        Raises:
            InputError: if the scene names a link that the robot does not have, or nothing could collide.
        """
        distance, adjoint, labels = _functions(robot, scene)
        self.name, self.labels = "clearance", labels
        self.unit, self.middle = np.full(len(labels), 0.1), np.zeros(len(labels))
        self.low, self.high = np.full(len(labels), scene.clearance / 0.1), np.full(len(labels), np.inf)
        self._distance, self._adjoint = Kernel(distance), Kernel(adjoint)

    def values(self, state: State) -> Array:
        """Distances over 0.1 m."""
        return np.asarray(self._distance(state.samples.q).T / self.unit)

    def pullback(self, state: State, slope: Array, into: Slopes) -> None:
        """Add the slopes to those in the positions."""
        into.samples.q[...] += self._adjoint(state.samples.q, slope / self.unit).T

    def label(self, column: int) -> str:
        """The pair."""
        return self.labels[column]


@functools.lru_cache(maxsize=16)
def _functions(robot: Robot, scene: Scene) -> tuple[ca.Function, ca.Function, tuple[str, ...]]:
    """Distances (one per pair), their adjoint, and the pairs' names."""
    if any(body.link > robot.n for body in scene.bodies):
        raise InputError(f"the scene names a link that robot {robot.name!r} does not have: it has {robot.n}")
    q = ca.SX.sym("q", robot.n)
    distances = {label: value for label, value in _distances(robot, scene, q).items() if ca.depends_on(value, q)}
    if not distances:
        raise InputError("nothing in the scene can collide: give surfaces or pairs, and bodies on moving links")
    distance = ca.cse(ca.vertcat(*distances.values()))
    seed = ca.SX.sym("seed", len(distances))
    slope = ca.cse(ca.densify(ca.jtimes(distance, q, seed, True)))
    return ca.Function("distance", [q], [distance]), ca.Function("adjoint", [q, seed], [slope]), tuple(distances)


def _distances(robot: Robot, scene: Scene, q: ca.SX) -> dict[str, ca.SX]:
    """Distance of each pair of body and surface, or of two bodies, by the pair's name [m]."""
    frames = [(ca.SX.eye(3), ca.SX([0, 0, 0]))]
    for j, joint in enumerate(robot.joints):
        R, p = frames[-1]
        rotation, origin = joint_transform(joint, q[j])
        frames.append((R @ rotation, p + R @ origin))
    bodies = {body.name: (body, *_axis(body, frames)) for body in scene.bodies}
    distances: dict[str, ca.SX] = {}
    for body, *ends in bodies.values():
        for surface in scene.surfaces:
            if body.link > 0 and (body.name, surface.name) not in scene.may_touch:
                for k, end in enumerate(ends[: 1 if body.sphere else 2]):
                    label = body.name if body.sphere else f"{body.name}, {('start', 'end')[k]},"
                    distances[f"{label} to {surface.name}"] = _height(end, surface) - body.radius
    for a, b in scene.pairs:
        apart = _segments_apart(bodies[a], bodies[b])
        distances[f"{a} to {b}"] = apart - bodies[a][0].radius - bodies[b][0].radius
    return distances


def _axis(body: Capsule, frames: list[tuple[ca.SX, ca.SX]]) -> tuple[ca.SX, ca.SX]:
    R, p = frames[body.link]
    ends = (body.start, body.start if body.end is None else body.end)
    first, second = (p + R @ ca.SX(list(end)) for end in ends)
    return first, second


def _height(point: ca.SX, surface: HalfSpace) -> ca.SX:
    normal = np.array(surface.normal) / np.linalg.norm(surface.normal)
    return ca.dot(ca.SX(normal.tolist()), point) - surface.offset


def _segments_apart(first: tuple[Capsule, ca.SX, ca.SX], second: tuple[Capsule, ca.SX, ca.SX]) -> ca.SX:
    """Distance of two axes (Ericson, Real-Time Collision Detection, 5.1.9), zero-length ones included."""
    (body, p1, q1), (other, p2, q2) = first, second
    u, v, r = q1 - p1, q2 - p2, p1 - p2
    a, e = ca.dot(u, u), ca.dot(v, v)
    c, f, b = ca.dot(u, r), ca.dot(v, r), ca.dot(u, v)
    if body.sphere and other.sphere:
        s, t = ca.SX(0), ca.SX(0)
    elif body.sphere:
        s, t = ca.SX(0), _unit(f / e)
    elif other.sphere:
        s, t = _unit(-c / a), ca.SX(0)
    else:
        s = _unit((b * f - c * e) / (a * e - b * b + _TINY))
        t = _unit((b * s + f) / e)
        s = _unit((b * t - c) / a)
    gap = r + s * u - t * v
    return ca.sqrt(ca.dot(gap, gap) + _TINY)


def _unit(x: ca.SX) -> ca.SX:
    return ca.fmin(ca.fmax(x, 0), 1)
