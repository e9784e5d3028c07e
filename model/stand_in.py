"""A robot to rehearse with where nothing is known of its links: made from the maker's mass, and called assumed."""

from collections.abc import Mapping
from dataclasses import replace

import casadi as ca
import numpy as np

from ..common.arrays import Array
from ..common.errors import InputError
from .base.geometry import frame_origin
from .dynamics import gravity, mass_matrix
from .inertia import InertialParameters
from .regressors import standard_columns
from .robot import ASSUMED, Robot

RADIUS = 0.08
"""Radius of the cylinders, of the sum of the lengths between joints."""
MOVING = 0.5
"""Of the maker's mass, in the cylinders: (h2 + h3) / (mass x length), h_j = hypot(MXjR, MYjR), then is .22 to .29; it is
.19 to .31 of five arms that were identified or published, .45 to .58 if all of the mass were in the cylinders. The
rest stands in the base and about axis 1.
"""
SAFETY = 1.5
"""Torque limit over the largest torque of links and rated payload."""
FRICTION = 0.1
"""Of the torque limit: friction at the largest speed, half of it dry, half viscous."""
ROTOR = 0.05
"""Of the torque limit: what turning the rotor takes at the largest acceleration."""
PAYLOAD_COM = (0.05, 0.0, 0.1)
"""m from the flange: where a rated payload is taken to have its centre of mass, out of the flange and beside it."""
PAYLOAD_INERTIA = 0.003
"""m^2: its moments of inertia over its mass."""
_POSES = 2000


def cylinders(robot: Robot, total_mass: float) -> tuple[InertialParameters, ...]:
    """Links as cylinders of one density and radius, each from a joint to the next at q = 0.

    The radius is ``RADIUS`` times the sum of all lengths between joints; each cylinder goes on by one radius beyond
    both joints, so that links between axes that meet have an extent too. One of zero length stands along z.

    Args:
        robot: the robot.
        total_mass: of all links [kg].

    Raises:
        InputError: if the mass is not positive.
    """
    if not 0.0 < total_mass < np.inf:
        raise InputError(f"total mass {total_mass:g} kg of the links must be positive")
    ends = [np.asarray(frame_origin(joint, {}), dtype=float) for joint in robot.joints[1:]] + [np.zeros(3)]
    radius = cylinder_radius(robot)
    lengths = np.array([np.linalg.norm(end) for end in ends]) + 2.0 * radius
    masses = total_mass * lengths / lengths.sum()
    return tuple(
        _cylinder(float(mass), end, float(length), radius)
        for mass, end, length in zip(masses, ends, lengths, strict=True)
    )


def cylinder_radius(robot: Robot) -> float:
    """Radius of ``cylinders`` [m]."""
    lengths = [np.linalg.norm(np.asarray(frame_origin(joint, {}), dtype=float)) for joint in robot.joints[1:]]
    return RADIUS * (float(sum(lengths)) or 1.0)


def with_stand_in(robot: Robot) -> Robot:
    """The robot with parameters and torque limits, as far as its description lacks them and they can be assumed.

    Links are ``cylinders`` of the share ``MOVING`` of the maker's mass; torque limits ``assumed_torque_limits``;
    friction and rotor inertia the shares ``FRICTION`` and ``ROTOR`` of the limits, offsets zero. What was assumed
    is in its ``sources``, under "torque" and "parameters".

    Raises:
        InputError: if the description holds neither parameters nor the arm's mass, or only some parameters.
    """
    columns = standard_columns(robot)
    missing = [name for name in columns if name not in robot.parameters]
    if not missing:
        return _limited(robot, robot.parameters)
    if robot.mass is None or len(missing) < len(columns):
        raise InputError(
            f"robot {robot.name!r}: its description lacks {', '.join(missing[:6])}"
            f"{' and more' if len(missing) > 6 else ''}; add a [parameters] table, or mass_kg in place of all of "
            "them for a stand-in"
        )
    values = dict.fromkeys(columns, 0.0)
    for link, body in enumerate(cylinders(robot, MOVING * robot.mass), start=1):
        values |= body.named(str(link))
    limited = _limited(robot, values)
    for number, joint in enumerate(limited.joints, start=1):
        most = joint.limits.torque if np.isfinite(joint.limits.torque) else 0.0
        dry, viscous = 0.5 * FRICTION * most, 0.5 * FRICTION * most / joint.limits.speed
        shares = {"FS": dry, "FV": viscous, "IA": ROTOR * most / joint.limits.acceleration}
        # Of coupled drives one rotor turns with both joints, and rubs on its own.
        shares |= {"FSM": 0.5 * dry, "FVM": 0.5 * viscous}
        values |= {f"{kind}{number}": value for kind, value in shares.items() if f"{kind}{number}" in values}
    told = (
        f"{ASSUMED}: links are cylinders of {100 * MOVING:g} % of the arm's {robot.mass:g} kg, friction is "
        f"{100 * FRICTION:g} % of the torque limits at full speed"
    )
    return replace(limited, parameters=values, sources={**limited.sources, "parameters": told})


def assumed_torque_limits(robot: Robot, parameters: Mapping[str, float]) -> Array:
    """Torque limits where none is published [N·m or N], shape (n,): ``SAFETY`` times what the arm needs at most.

    That is the torque at rest and at each joint's largest acceleration, with the rated payload at ``PAYLOAD_COM``,
    over poses in the joints' ranges; infinite where accelerations are not limited.

    Args:
        robot: the robot.
        parameters: standard parameters of its links and rotors.
    """
    values = dict(parameters)
    if np.isfinite(robot.rated_payload):
        mass = robot.rated_payload
        body = InertialParameters.from_com(mass, PAYLOAD_COM, PAYLOAD_INERTIA * mass * np.eye(3))
        flange = robot.flange if robot.flange_pose is None else robot.flange @ robot.flange_pose
        for name, value in body.moved(flange.R, flange.p).named(str(robot.n)).items():
            values[name] += value
    chi = np.array([values[name] for name in standard_columns(robot)])
    q = ca.SX.sym("q", robot.n)
    at_rest, inertia = gravity(robot)(q, chi), ca.diag(mass_matrix(robot)(q, chi))
    strong = np.array([joint.limits.acceleration for joint in robot.joints])
    torque = ca.Function("torque", [q], [at_rest, inertia])
    rest, moments = (np.array(part) for part in torque.map(_POSES)(_poses(robot).T))
    return np.asarray(SAFETY * (np.abs(rest) + moments * strong[:, None]).max(axis=1))


def _limited(robot: Robot, parameters: Mapping[str, float]) -> Robot:
    """The robot with torque limits, if it lacks them."""
    if all(np.isfinite(joint.limits.torque) for joint in robot.joints):
        return robot
    joints = tuple(
        replace(joint, limits=replace(joint.limits, torque=min(joint.limits.torque, float(most))))
        for joint, most in zip(robot.joints, assumed_torque_limits(robot, parameters), strict=True)
    )
    told = (
        f"{ASSUMED}: {SAFETY:g} times the largest torque of links and rated payload at rest and at the largest "
        "acceleration"
    )
    return replace(robot, joints=joints, sources={**robot.sources, "torque": told})


def _poses(robot: Robot) -> Array:
    """Positions in the joints' ranges, or one turn or metre without a range; always the same."""
    ranges = np.array([joint.limits.position for joint in robot.joints])
    bound = np.array([np.pi if joint.revolute else 0.5 for joint in robot.joints])
    low, high = np.clip(ranges, -bound[:, None], bound[:, None]).T
    return np.asarray(np.random.default_rng(0).uniform(low, high, (_POSES, robot.n)))


def _cylinder(mass: float, end: Array, length: float, radius: float) -> InertialParameters:
    distance = float(np.linalg.norm(end))
    axis = end / distance if distance > 0.0 else np.array([0.0, 0.0, 1.0])
    along, across = mass * radius**2 / 2.0, mass * (3.0 * radius**2 + length**2) / 12.0
    inertia = across * np.eye(3) + (along - across) * np.outer(axis, axis)
    return InertialParameters.from_com(mass, end / 2.0, inertia)
