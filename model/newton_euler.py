"""The inverse dynamic model (1) by the recursive Newton-Euler algorithm."""

from collections.abc import Mapping

import casadi as ca

from .drives import drive_terms
from .kinematics import LinkMotion, base_motion, joint_axis, joint_transform, next_motion
from .regressors import link_wrench, standard_columns
from .robot import INERTIAL, Robot


def inverse_dynamics(robot: Robot) -> ca.Function:
    """``inverse_dynamics(q, qd, qdd, chi) -> Gamma`` (1).

    q, qd, qdd are n x 1; chi holds the standard parameters in the order of ``standard_columns``. Gamma [N·m
    or N], n x 1, is what the motors must give: the torque of a spring is already taken off.
    """
    q, qd, qdd = (ca.SX.sym(symbol, robot.n) for symbol in ("q", "qd", "qdd"))
    chi = ca.SX.sym("chi", len(standard_columns(robot)))
    value = parameter_values(robot, chi)
    torque = rigid_body_torque(robot, q, qd, qdd, value) + drive_torque_symbol(robot, q, qd, qdd, value)
    return ca.Function(
        "inverse_dynamics", [q, qd, qdd, chi], [ca.cse(torque)], ["q", "qd", "qdd", "chi"], ["Gamma"]
    )


def parameter_values(robot: Robot, chi: ca.SX) -> dict[str, ca.SX]:
    """Entries of ``chi`` (standard parameters) by name."""
    return dict(zip(standard_columns(robot), ca.vertsplit(chi), strict=True))


def drive_torque_symbol(robot: Robot, q: ca.SX, qd: ca.SX, qdd: ca.SX, value: Mapping[str, ca.SX]) -> ca.SX:
    """Rotor inertia, friction and offsets less the torque of the spring, n x 1 [N·m or N]."""
    torque = ca.SX.zeros(robot.n)
    for name, rows in drive_terms(robot.drives, qd, qdd).items():
        for row, factor in rows.items():
            torque[row] += factor * value[name]
    if robot.spring:
        row = robot.spring.joint - 1
        torque[row] -= robot.spring.torque_symbol(q[row])
    return torque


def rigid_body_torque(robot: Robot, q: ca.SX, qd: ca.SX, qdd: ca.SX, value: Mapping[str, ca.SX]) -> ca.SX:
    """Torques that move the links, without drives, n x 1 [N·m or N]."""
    motion = base_motion(robot)
    steps = []
    for j, joint in enumerate(robot.joints):
        rotation, origin = joint_transform(joint, q[j])
        axes = joint_axis(joint)
        motion = next_motion(motion, rotation, origin, axes, qd[j], qdd[j])
        steps.append((rotation, origin, axes, *_link_wrench(motion, value, j + 1)))
    torque = ca.SX.zeros(robot.n)
    force, moment = ca.SX.zeros(3), ca.SX.zeros(3)
    for j, (rotation, origin, (turn, slide), own_force, own_moment) in reversed(list(enumerate(steps))):
        force, moment = force + own_force, moment + own_moment
        torque[j] = ca.dot(turn, moment) + ca.dot(slide, force)
        force = rotation @ force
        moment = rotation @ moment + ca.cross(origin, force)
    return torque


def _link_wrench(motion: LinkMotion, value: Mapping[str, ca.SX], link: int) -> tuple[ca.SX, ca.SX]:
    """Force [N] and moment [N·m] that the link's own motion needs, at its origin."""
    parameters = ca.vertcat(*(value[f"{kind}{link}"] for kind in INERTIAL))
    force, moment = link_wrench(motion)
    return force @ parameters, moment @ parameters
