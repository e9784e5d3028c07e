"""Numbers of a chain at q = 0: where the axes are, which are parallel, and bodies seen from the frame before."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ..pose import cos_sin
from ..robot import Joint, Robot
from .polynomial import Polynomial, Scalar

ZERO = 1e-9
"""Cosine, sine or length that is rounding: nearly special geometry was snapped when the robot was made."""

_UPPER = np.triu_indices(3)


@dataclass(frozen=True)
class Chain:
    """Axes of a robot at q = 0, in frame 0. Joints are counted from 0.

    Attributes:
        revolute: which joints turn.
        rotation: axes of each frame, n x 3 x 3.
        origin: origin of each frame [m], n x 3.
        gravity: acceleration of gravity [m/s^2], shape (3,), not zero.
        r1: first revolute joint, n if there is none.
        r2: next revolute joint whose axis is not parallel to that of r1, n if there is none.
    """

    revolute: tuple[bool, ...]
    rotation: Array
    origin: Array
    gravity: Array
    r1: int
    r2: int

    def axis(self, j: int) -> Array:
        """Direction of axis ``j``, shape (3,)."""
        return np.asarray(self.rotation[j, :, 2])

    def parallel(self, i: int, j: int) -> bool:
        """True if two axes are parallel or opposite."""
        return _parallel(self.axis(i), self.axis(j))

    def orthogonal(self, i: int, j: int) -> bool:
        """True if two axes are at right angles."""
        return abs(float(self.axis(i) @ self.axis(j))) < ZERO

    def turns_about_gravity(self, j: int) -> bool:
        """True if revolute axis ``j`` always coincides with that of r1, along gravity, all earlier parallel."""
        first, up = self.axis(self.r1), self.gravity / np.linalg.norm(self.gravity)
        aligned = all(_parallel(self.axis(i), up) for i in range(j + 1))
        # Every revolute axis on the way has to coincide: two offsets may cancel at q = 0 only.
        on_the_way = [i for i in range(self.r1, j + 1) if self.revolute[i]]
        away = np.cross(self.origin[on_the_way] - self.origin[self.r1], first)
        return aligned and bool(np.abs(away).max(initial=0.0) < ZERO)


def chain_at_zero(robot: Robot) -> Chain:
    """Axes of the robot at q = 0."""
    R, p = np.eye(3), np.zeros(3)
    rotations, origins = [], []
    for joint in robot.joints:
        R, p = R @ frame_rotation(joint), p + R @ frame_origin(joint, {})
        rotations.append(R)
        origins.append(p)
    turning = tuple(joint.revolute for joint in robot.joints)
    axes = [rotation[:, 2] for rotation in rotations]
    r1 = next((j for j in range(robot.n) if turning[j]), robot.n)
    r2 = next((j for j in range(r1, robot.n) if turning[j] and not _parallel(axes[j], axes[r1])), robot.n)
    return Chain(turning, np.array(rotations), np.array(origins), np.array(robot.gravity), r1, r2)


def frame_rotation(joint: Joint) -> Array:
    """Axes of frame j in frame j-1 at q = 0, 3 x 3, exact at special angles."""
    (ca, sa), (ct, st) = cos_sin(joint.alpha), cos_sin(joint.theta)
    return np.array([[ct, -st, 0.0], [ca * st, ca * ct, -sa], [sa * st, sa * ct, ca]])


def frame_origin(joint: Joint, symbols: Mapping[str, Polynomial]) -> NDArray[Any]:
    """Origin of frame j in frame j-1 at q = 0 [m], shape (3,); lengths named in ``symbols`` stay symbols."""
    ca, sa = cos_sin(joint.alpha)
    d, r = (
        symbols.get(name, value) if value != 0.0 else 0.0
        for name, value in zip(joint.names, (joint.d, joint.r), strict=True)
    )
    return np.array([d, -sa * r, ca * r])


def transfer_matrix(joint: Joint, symbols: Mapping[str, Polynomial]) -> NDArray[Any]:
    """Transfer matrix of the inertial parameters from frame j to frame j-1 at q = 0, 10 x 10, order of (6)."""
    R, p = frame_rotation(joint), frame_origin(joint, symbols)
    columns: list[list[Scalar]] = []
    for xx, xy, xz, yy, yz, zz, *first, mass in np.eye(10):
        h = R @ first
        J = R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T
        # About the new origin: J - (h^ p^ + p^ h^) - m p^ p^, with a^ b^ = b a' - (a.b) 1.
        both = np.outer(h, p) + np.outer(p, h) + mass * np.outer(p, p)
        columns.append([*(J + np.eye(3) * both.trace() - both)[_UPPER], *(h + mass * p), mass])
    return np.array(columns).T


def _parallel(a: Array, b: Array) -> bool:
    return math.sqrt(float(np.sum(np.cross(a, b) ** 2))) < ZERO
