"""Keeping clear of floor, walls, obstacles and the robot itself.

Distances of capsules are continuous and have slopes everywhere but where two axes cross; slopes come from CasADi
through the batch kernel.
"""

import functools

import casadi as ca
import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Robot
from ...model.kernel.kernel import Kernel
from ...model.kinematics import joint_transform
from .limits import Limit, State
from .scene import Capsule, HalfSpace, Scene

_TINY = 1e-12  # m^2: keeps slopes finite where two axes touch
_UNIT = 0.1  # m


def clearance(robot: Robot, scene: Scene) -> Limit:
    """Distances in the scene as a limit on the motion, a column per pair; values in units of 0.1 m.

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
    (body, p1, q1), (second_body, p2, q2) = first, second
    u, v, r = q1 - p1, q2 - p2, p1 - p2
    a, e = ca.dot(u, u), ca.dot(v, v)
    c, f, b = ca.dot(u, r), ca.dot(v, r), ca.dot(u, v)
    if body.sphere and second_body.sphere:
        s, t = ca.SX(0), ca.SX(0)
    elif body.sphere:
        s, t = ca.SX(0), _unit(f / e)
    elif second_body.sphere:
        s, t = _unit(-c / a), ca.SX(0)
    else:
        s = _unit((b * f - c * e) / (a * e - b * b + _TINY))
        t = _unit((b * s + f) / e)
        s = _unit((b * t - c) / a)
    gap = r + s * u - t * v
    return ca.sqrt(ca.dot(gap, gap) + _TINY)


def _unit(x: ca.SX) -> ca.SX:
    return ca.fmin(ca.fmax(x, 0), 1)
