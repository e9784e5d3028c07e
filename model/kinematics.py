"""Frame changes and link motion of the chain, as CasADi expressions."""

from typing import NamedTuple

import casadi as ca

from .pose import cos_sin
from .robot import Joint, Robot


class LinkMotion(NamedTuple):
    """Motion of a link's frame, in its own axes; each 3 x 1.

    ``acceleration`` is that of the origin minus gravity, so that a robot at rest accelerates upwards.
    """

    speed: ca.SX
    angular_acceleration: ca.SX
    acceleration: ca.SX


def joint_transform(joint: Joint, q: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Rotation (3 x 3) and origin (3 x 1 [m]) of frame j in frame j-1 at position ``q``."""
    ca_, sa = cos_sin(joint.alpha)
    co, so = cos_sin(joint.theta)
    if joint.revolute:
        # The offset is taken out of the cosine, so that special offsets stay exact.
        c, s = ca.cos(q), ca.sin(q)
        ct, st, r = c * co - s * so, s * co + c * so, ca.SX(joint.r)
    else:
        ct, st, r = ca.SX(co), ca.SX(so), q + joint.r
    rotation = ca.SX(3, 3)
    entries: list[list[ca.SX | float]] = [[ct, -st, 0.0], [ca_ * st, ca_ * ct, -sa], [sa * st, sa * ct, ca_]]
    for i, row in enumerate(entries):
        for k, entry in enumerate(row):
            rotation[i, k] = entry
    return rotation, ca.vertcat(ca.SX(joint.d), -sa * r, ca_ * r)


def joint_axis(joint: Joint) -> tuple[ca.SX, ca.SX]:
    """Turning and sliding direction of the joint in its own frame, each 3 x 1."""
    z, zero = ca.SX([0, 0, 1]), ca.SX([0, 0, 0])
    return (z, zero) if joint.revolute else (zero, z)


def spin_matrix(motion: LinkMotion) -> ca.SX:
    """U = alpha^ + w^ w^, 3 x 3: a point at p of the link accelerates by U p more than its origin."""
    w = ca.skew(motion.speed)
    return ca.skew(motion.angular_acceleration) + w @ w


def base_motion(robot: Robot) -> LinkMotion:
    """Motion of frame 0: at rest, gravity taken as an upward acceleration."""
    return LinkMotion(ca.SX([0, 0, 0]), ca.SX([0, 0, 0]), -ca.SX(list(robot.gravity)))


def next_motion(
    before: LinkMotion, rotation: ca.SX, origin: ca.SX, axes: tuple[ca.SX, ca.SX], qd: ca.SX, qdd: ca.SX
) -> LinkMotion:
    """Motion of frame j from that of frame j-1 (Khalil and Dombre 2002, forward recursion)."""
    turn, slide = axes
    w0, a0 = before.speed, before.angular_acceleration
    acceleration = before.acceleration + spin_matrix(before) @ origin
    w = rotation.T @ w0
    speed = w + turn * qd
    angular = rotation.T @ a0 + turn * qdd + ca.cross(w, turn * qd)
    linear = rotation.T @ acceleration + slide * qdd + 2 * ca.cross(w, slide * qd)
    return LinkMotion(speed, angular, linear)


def forward_kinematics(robot: Robot) -> ca.Function:
    """``forward_kinematics(q) -> (R, p)``: axes (3 x 3) and origin [m] of frame n in frame 0."""
    q = ca.SX.sym("q", robot.n)
    R, p = ca.SX.eye(3), ca.SX([0, 0, 0])
    for j, joint in enumerate(robot.joints):
        rotation, origin = joint_transform(joint, q[j])
        R, p = R @ rotation, p + R @ origin
    return ca.Function("forward_kinematics", [q], [R, p], ["q"], ["R", "p"])
