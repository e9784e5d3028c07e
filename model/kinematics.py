"""Frame changes of the chain and the places they lead to, at one symbolic state or at many states of numbers.

Vectors are triples of entries: numbers, CasADi's scalars, or arrays whose last axis counts states. So the same
formulas make the symbolic model, and evaluate it by NumPy for a robot that is tried once, where generated code does
not pay.
"""

from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from ..common import Array
from .pose import cos_sin
from .robot import Joint, Robot

Vector = tuple[Any, Any, Any]
ZERO: Vector = (0.0, 0.0, 0.0)  # zero vector, with which ``dot`` takes no operations


class FrameChange(NamedTuple):
    """Frame j in frame j-1."""

    c: Any  # cosine of the angle about z
    s: Any  # its sine
    alpha: tuple[float, float]  # cosine and sine of the angle about x
    origin: Vector  # of frame j in frame j-1 [m]

    @staticmethod
    def of(joint: Joint, q: Any, lib: Any = ca) -> "FrameChange":
        """Make the change before a joint at position ``q`` [rad or m], by CasADi or NumPy."""
        c, s = cos_sin(joint.theta)
        along = joint.r
        if joint.revolute:
            # The offset is taken out of the cosine, so that special offsets stay exact.
            cq, sq = lib.cos(q), lib.sin(q)
            c, s = cq * c - sq * s, sq * c + cq * s
        else:
            along = q + along
        ca_, sa = cos_sin(joint.alpha)
        return FrameChange(c, s, (ca_, sa), (joint.d, -sa * along, ca_ * along))

    @property
    def axes(self) -> Array:
        """Axes of frame j in frame j-1, 3 x 3, of a change of numbers."""
        x, y, z = np.eye(3)
        return np.array(self.out_of((x, y, z)))

    def into(self, x: Vector) -> Vector:
        """Rotate a vector of frame j-1 into the axes of frame j."""
        ca_, sa = self.alpha
        across = ca_ * x[1] + sa * x[2]
        return self.c * x[0] + self.s * across, self.c * across - self.s * x[0], ca_ * x[2] - sa * x[1]

    def out_of(self, x: Vector) -> Vector:
        """Rotate a vector of frame j into the axes of frame j-1."""
        ca_, sa = self.alpha
        across = self.s * x[0] + self.c * x[1]
        return self.c * x[0] - self.s * x[1], ca_ * across - sa * x[2], sa * across + ca_ * x[2]


def add(a: Vector, b: Vector) -> Vector:
    """Sum of two vectors."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def dot(a: Vector, b: Vector) -> Any:
    """Scalar product of two vectors."""
    return 0.0 if b is ZERO else a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Cross product of two vectors."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def link_frames(robot: Robot, q: ca.SX) -> list[tuple[ca.SX, ca.SX]]:
    """Axes (3 x 3) and origins (3 x 1 [m]) of frames 0 to n in frame 0, as expressions of ``q``, n x 1."""
    frames = [(ca.SX.eye(3), ca.SX.zeros(3))]
    for joint, position in zip(robot.joints, ca.vertsplit(q), strict=True):
        change = FrameChange.of(joint, position)
        axes = ca.horzcat(*(ca.vertcat(*change.out_of((x, y, z))) for x, y, z in np.eye(3).tolist()))
        R, p = frames[-1]
        frames.append((R @ axes, p + R @ ca.vertcat(*change.origin)))
    return frames


def forward_kinematics(robot: Robot) -> ca.Function:
    """``forward_kinematics(q) -> (R, p)``: axes (3 x 3) and origin [m] of frame n in frame 0."""
    q = ca.SX.sym("q", robot.n)
    return ca.Function("forward_kinematics", [q], [*link_frames(robot, q)[-1]], ["q"], ["R", "p"])


def point_at(robot: Robot, point: Array, q: Array) -> tuple[Array, Array]:
    """Position of a point of frame n at positions q, N x n, in frame 0 [m], and its Jacobian; 3 x (n x) N."""
    x, y, z = point[:, None] + np.zeros(len(q))
    position: Vector = (x, y, z)
    x, y, z = np.zeros((3, *q.T.shape))
    moved: Vector = (x, y, z)
    for j in reversed(range(robot.n)):
        if robot.joints[j].revolute:
            moved[0][j], moved[1][j] = -position[1], position[0]
        else:
            moved[2][j] = 1.0
        change = FrameChange.of(robot.joints[j], q[:, j], np)
        moved, position = change.out_of(moved), add(change.out_of(position), change.origin)
    return np.array(position), np.array(moved)
