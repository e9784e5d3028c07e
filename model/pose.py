"""Pose of one frame in another: a rotation and an origin, frozen and hashable."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..common import Array, ArrayLike, InputError

_Row = tuple[float, float, float]
_IDENTITY: tuple[_Row, _Row, _Row] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_ROUNDING = 1e-12  # size that arithmetic leaves on entries that are 0, 1 or -1, and on lengths in m
_FARTHEST = 3.0  # m: no payload or tool of an arm reaches farther


def check_metres(lengths: ArrayLike, name: str) -> None:
    """Refuse lengths of a payload or a tool that no arm carries: mostly they are in mm."""
    farthest = float(max(np.ravel(lengths), key=abs))
    if abs(farthest) >= _FARTHEST:
        fault = f"{name}: {farthest:g} m is farther than a payload or a tool reaches"
        raise InputError(f"{fault}: is it in mm? write it in m, {farthest / 1000.0:g}")


def cos_sin(angle: float) -> tuple[float, float]:
    """Cosine and sine, exactly 0, 1 or -1 at multiples of 90 degrees."""
    quarter = angle / (math.pi / 2)
    if abs(quarter - round(quarter)) < _ROUNDING:
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(quarter) % 4]
    return math.cos(angle), math.sin(angle)


@dataclass(frozen=True)
class Pose:
    """Axes and origin of a frame in another one.

    Attributes:
        rotation: rows of the 3 x 3 matrix whose columns are the frame's axes.
        origin: the frame's origin [m].
    """

    rotation: tuple[_Row, _Row, _Row] = _IDENTITY
    origin: _Row = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        R = np.array(self.rotation)
        if R.shape != (3, 3) or len(self.origin) != 3 or not np.isfinite([*R.ravel(), *self.origin]).all():
            raise ValueError("a pose needs a 3 x 3 rotation and an origin of finite numbers")
        if np.abs(R @ R.T - np.eye(3)).max() > 1e-9 or np.linalg.det(R) < 0.0:
            raise ValueError("the rotation of a pose must be orthogonal and right-handed")

    @staticmethod
    def of(R: Array, p: Array) -> "Pose":
        """Make a pose of arrays, 3 x 3 and (3,) [m]; what rounding leaves on special entries is taken off."""
        near = np.round(R)
        rows = np.where(np.abs(R - near) < _ROUNDING, near, R) + 0.0
        first, second, third = ((float(a), float(b), float(c)) for a, b, c in rows)
        x, y, z = (round(float(value), 12) + 0.0 for value in p)
        return Pose((first, second, third), (x, y, z))

    @staticmethod
    def from_rpy(origin: Sequence[float], rpy: Sequence[float]) -> "Pose":
        """Make a pose of an origin [m] and roll, pitch, yaw [rad] about fixed x, y, z, as in URDF."""
        (cr, sr), (cp, sp), (cy, sy) = (cos_sin(angle) for angle in rpy)
        Rx = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
        Ry = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
        Rz = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
        return Pose.of(Rz @ Ry @ Rx, np.array(origin, dtype=float))

    @property
    def R(self) -> Array:  # noqa: N802
        """Rotation, 3 x 3."""
        return np.array(self.rotation)

    @property
    def p(self) -> Array:
        """Origin [m], shape (3,)."""
        return np.array(self.origin)

    @property
    def rpy(self) -> _Row:
        """Roll, pitch and yaw [rad] about fixed x, y, z; yaw is 0 where the pitch is +-90 degrees."""
        (r00, r01, _), (r10, r11, _), (r20, r21, r22) = self.rotation
        if math.hypot(r00, r10) < 1e-12:
            return math.copysign(1.0, -r20) * math.atan2(r01, r11), math.copysign(math.pi / 2, -r20), 0.0
        return math.atan2(r21, r22), math.atan2(-r20, math.hypot(r00, r10)), math.atan2(r10, r00)

    @property
    def is_identity(self) -> bool:
        """True if both frames are one."""
        return self == Pose()

    def __matmul__(self, other: "Pose") -> "Pose":
        """Pose of a third frame: this one's in the first, ``other`` in this one."""
        return Pose.of(self.R @ other.R, self.p + self.R @ other.p)

    def inverse(self) -> "Pose":
        """Pose of the first frame in this one."""
        return Pose.of(self.R.T, -self.R.T @ self.p)
