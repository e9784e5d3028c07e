"""The inverse dynamic model (1) by the recursive Newton-Euler algorithm, and what follows from it."""

import casadi as ca

from .drives import drive_terms
from .kinematics import LinkMotion, base_motion, joint_axis, joint_transform, next_motion
from .regressor import standard_columns
from .robot import INERTIAL, Robot


def inverse_dynamics(robot: Robot) -> ca.Function:
    """``inverse_dynamics(q, qd, qdd, chi) -> Gamma`` (1).

    q, qd, qdd are n x 1; chi holds the standard parameters in the order of ``standard_columns``. Gamma [N·m
    or N], n x 1, is what the motors must give: the torque of a spring is already taken off.
    """
    q, qd, qdd = (ca.SX.sym(symbol, robot.n) for symbol in ("q", "qd", "qdd"))
    columns = standard_columns(robot)
    chi = ca.SX.sym("chi", len(columns))
    value = dict(zip(columns, ca.vertsplit(chi), strict=True))
    torque = _rigid_body_torque(robot, q, qd, qdd, value)
    for name, rows in drive_terms(robot.drives, qd, qdd).items():
        for row, factor in rows.items():
            torque[row] += factor * value[name]
    if robot.spring:
        row = robot.spring.joint - 1
        torque[row] -= robot.spring.torque_symbol(q[row])
    return ca.Function(
        "inverse_dynamics", [q, qd, qdd, chi], [ca.cse(torque)], ["q", "qd", "qdd", "chi"], ["Gamma"]
    )


def mass_matrix(robot: Robot) -> ca.Function:
    """``mass_matrix(q, chi) -> A``, n x n: the inertia matrix, rotors included."""
    q, chi = ca.SX.sym("q", robot.n), ca.SX.sym("chi", len(standard_columns(robot)))
    qdd = ca.SX.sym("qdd", robot.n)
    torque = inverse_dynamics(robot)(q, ca.SX.zeros(robot.n), qdd, chi)
    return ca.Function("mass_matrix", [q, chi], [ca.cse(ca.jacobian(torque, qdd))], ["q", "chi"], ["A"])


def _rigid_body_torque(robot: Robot, q: ca.SX, qd: ca.SX, qdd: ca.SX, value: dict[str, ca.SX]) -> ca.SX:
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


def _link_wrench(motion: LinkMotion, value: dict[str, ca.SX], link: int) -> tuple[ca.SX, ca.SX]:
    """Force [N] and moment [N·m] that the link's own motion needs, at its origin."""
    w, alpha, a = motion
    xx, xy, xz, yy, yz, zz, mx, my, mz, m = (value[f"{kind}{link}"] for kind in INERTIAL)
    J = ca.vertcat(ca.horzcat(xx, xy, xz), ca.horzcat(xy, yy, yz), ca.horzcat(xz, yz, zz))
    h = ca.vertcat(mx, my, mz)
    force = m * a + ca.cross(alpha, h) + ca.cross(w, ca.cross(w, h))
    moment = J @ alpha + ca.cross(w, J @ w) + ca.cross(h, a)
    return force, moment
