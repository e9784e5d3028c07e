"""Scenes: bodies, floor and walls in the way of a motion, as values, as a TOML file, and as a limit.

Bodies are capsules fixed to link frames (a sphere is a capsule whose ends are the same). Frame 0 stands in the
world, so that a capsule fixed to it is an obstacle; floor and walls are half-spaces. Distances are continuous and
have slopes everywhere but where two axes cross; slopes come from CasADi through the batch kernel.
"""

import math
from collections.abc import Mapping
from functools import lru_cache, partial
from pathlib import Path
from typing import Annotated, ClassVar

import casadi as ca
import numpy as np
from msgspec import Meta

from ...common import Array, InputError
from ...common.schema import Real, Table, Triple, read_toml
from ...model import Robot
from ...model.frames import frames_at, link_frames, step
from ...model.kernel.kernel import Kernel
from ...model.stand_in import cylinder_radius
from ..motions.family import Samples
from .limits import Limit, Pullback

_TINY = 1e-12  # m^2: keeps slopes finite where two axes touch, and spheres have an axis of no length
_UNIT = 0.1  # m

_THICK = 0.6  # radius of a tube that stands for a link, of the stand-in's cylinder: some 5 % of the arm's length
_POSES, _OFTEN = 300, 0.3  # random poses, and the fraction of them at which tubes may touch
_LEVEL = 0.7  # cosine between gravity and the base's axis
_kernel = lru_cache(maxsize=32)(Kernel)  # of each function once
_MOUNTS = ("floor at the base's height", "wall that it hangs on", "ceiling that it hangs from")

_Name = Annotated[str, Meta(min_length=1)]
_Pairs = tuple[tuple[str, str], ...]


class Capsule(Table, frozen=True):
    """Capsule: all points within ``radius`` of the line from ``start`` to ``end``, in the frame of a link [m]."""

    advice: ClassVar = {"link": "must be a whole number, 0 for the world", "radius": "must be a number [m]"}

    name: _Name
    link: int  # number of the link; 0 for the world
    radius: Real
    start: Triple = (0.0, 0.0, 0.0)
    end: Triple | None = None  # a sphere if it is the start

    def __post_init__(self) -> None:
        if not 0.0 <= self.radius < math.inf or self.link < 0:
            raise InputError(f"body {self.name!r}: link {self.link} and radius {self.radius:g} m are not possible")


class HalfSpace(Table, frozen=True):
    """Floor or wall: bodies stay where ``normal`` · p >= ``offset``."""

    name: _Name
    normal: Triple = (0.0, 0.0, 1.0)  # direction into the free space, in frame 0
    offset: Real = 0.0  # of the surface along the unit normal [m]

    def __post_init__(self) -> None:
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


def tubes(robot: Robot, radius: float) -> tuple[Capsule, ...]:
    """Make bodies along x and each joint's axis (over its range if it slides) to the next frame and the flange."""
    bodies = list[Capsule]()

    def add(name: str, link: int, start: Array, end: Array) -> None:
        ends = [(float(x), float(y), float(z)) for x, y, z in (start, end)]
        bodies.append(Capsule(f"link {link}/{name}", link, radius, *ends))

    for j, joint in enumerate(robot.joints):
        reach = np.clip(joint.limits.position, -1.0, 1.0) if not joint.revolute else (0.0, 0.0)
        corner = step(joint, 0.0)[0]
        ends = [(corner @ step(joint, float(q))[1]).p for q in reach]
        low, high = sorted([corner.p, *ends], key=lambda p: float((p - corner.p) @ corner.R[:, 2]))[::2]
        add("along x", j, np.zeros(3), corner.p)
        add(f"along axis {j + 1}", j, low, high)
    add("flange", robot.n, np.zeros(3), robot.flange.p)
    return tuple(bodies)


def usual_scene(robot: Robot, poses: Array, floor: bool = True) -> Scene | None:
    """Make the scene that is looked at where none is given: the arm itself, as tubes, and what it is bolted to.

    Tubes that touch at a pose where the arm stands, or at most poses, are thicker than the arm there: they are not
    kept apart. The surface goes through the base, with the arm in front; there is none where a pose reaches behind
    it, or where the description starts at the shoulder, so that the base's height is not known.

    ``poses``: where the arm is known to stand, k x n; ``floor``: whether the surface counts.
    """
    radius, n = _THICK * cylinder_radius(robot), robot.n
    bodies = tuple(body for body in tubes(robot, radius) if math.dist(body.start, body.end or body.start) > _TINY)
    pairs = [(a.name, b.name) for k, a in enumerate(bodies) for b in bodies[k + 1 :] if b.link - a.link > 1]
    normal = robot.base.R[:, 2]
    offset = min(0.0, float(normal @ robot.base.p))
    down = float(np.array(robot.gravity) @ normal) / (math.hypot(*robot.gravity) or 1.0)
    surface = _MOUNTS[0] if down < -_LEVEL else _MOUNTS[2] if down > _LEVEL else _MOUNTS[1]
    x, y, z = normal.tolist()
    shoulder = float(normal @ (robot.base @ frames_at(robot, [0.0] * n)[min(2, n)]).p) - offset
    surfaces = (HalfSpace(surface, (x, y, z), offset),) if floor and shoulder > radius else ()
    whole = Scene(bodies, surfaces, tuple(pairs))
    try:
        distance, _, labels = _functions(robot, whole)
    except InputError:  # a chain too short to touch itself
        return None
    low, high = np.clip(np.array([joint.limits.position for joint in robot.joints]).T, -math.pi, math.pi)
    random = np.random.default_rng(0).uniform(low, high, (_POSES, n))
    often, there = np.hsplit(np.array(distance(np.vstack([random, poses]).T)) < 0.0, [_POSES])
    touching = {labels[k] for k in np.flatnonzero((often.mean(axis=1) > _OFTEN) | there.any(axis=1))}
    below = any(label.endswith(f" to {surface}") for label in np.array(labels)[there.any(axis=1)])
    kept = tuple(pair for pair in pairs if " to ".join(pair) in labels and " to ".join(pair) not in touching)
    surfaces = () if below else surfaces
    return Scene(bodies, surfaces, kept) if kept or surfaces else None


def clearance(robot: Robot, scene: Scene) -> Limit:
    """Limit the distances in the scene, a column per pair; values in units of 0.1 m."""
    labels = _functions(robot, scene)[2]
    unit, low, high = (np.full(len(labels), value) for value in (_UNIT, scene.clearance / _UNIT, np.inf))
    measure = partial(_distances, robot, scene)
    return Limit("clearance", "clearance", labels, low, high, np.zeros(len(labels)), unit, measure)


def _distances(robot: Robot, scene: Scene, state: Samples) -> tuple[Array, Pullback]:
    distance, adjoint = map(_kernel, _functions(robot, scene)[:2])
    values = distance(state.q).T / _UNIT
    return values, lambda slope, into: np.add(into.q, adjoint(state.q, slope / _UNIT).T, out=into.q)


@lru_cache(maxsize=16)
def _functions(robot: Robot, scene: Scene) -> tuple[ca.Function, ca.Function, tuple[str, ...]]:
    if any(body.link > robot.n for body in scene.bodies):
        raise InputError(f"the scene names a link that robot {robot.name!r} does not have: it has {robot.n}")
    q = ca.SX.sym("q", robot.n)
    frames = link_frames(robot, q)
    axes, distances = dict[str, tuple[ca.SX, ca.SX]](), dict[str, ca.SX]()
    for body in scene.bodies:
        R, p = frames[body.link]
        first, last = (p + R @ ca.SX(list(end)) for end in (body.start, body.end or body.start))
        sphere = body.end in (None, body.start)
        axes[body.name] = first, first if sphere else last
        for surface in scene.surfaces:
            if body.link > 0 and (body.name, surface.name) not in scene.may_touch:
                normal = np.array(surface.normal) / np.linalg.norm(surface.normal)
                ends = {body.name: first} if sphere else {f"{body.name}, start,": first, f"{body.name}, end,": last}
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
