"""A rigid body: poses of its frames, its inertial parameters in all their views, and how sure those are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..common import Array, ArrayLike, Brief, Document, Float, InputError, Vector, frozen_array
from ..common.schema import Matrix

INERTIAL = ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M")
"""The ten inertial parameters of a body, in the order of (6)."""

_ROWS, _COLUMNS = np.triu_indices(3)
_ROUNDING = 1e-9  # error by rounding of a moment about the centre of mass, over that about the frame's origin
_Row = tuple[float, float, float]
_IDENTITY: tuple[_Row, _Row, _Row] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_EXACT = 1e-12  # size that arithmetic leaves on entries that are 0, 1 or -1, and on lengths in m
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
    if abs(quarter - round(quarter)) < _EXACT:
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
    def of(R: Array, p: Array) -> Pose:
        """Make a pose of arrays, 3 x 3 and (3,) [m]; what rounding leaves on special entries is taken off."""
        near = np.round(R)
        rows = np.where(np.abs(R - near) < _EXACT, near, R) + 0.0
        first, second, third = ((float(a), float(b), float(c)) for a, b, c in rows)
        x, y, z = (round(float(value), 12) + 0.0 for value in p)
        return Pose((first, second, third), (x, y, z))

    @staticmethod
    def from_rpy(origin: Sequence[float], rpy: Sequence[float]) -> Pose:
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

    def __matmul__(self, other: Pose) -> Pose:
        """Pose of a third frame: this one's in the first, ``other`` in this one."""
        return Pose.of(self.R @ other.R, self.p + self.R @ other.p)

    def inverse(self) -> Pose:
        """Pose of the first frame in this one."""
        return Pose.of(self.R.T, -self.R.T @ self.p)


def skew(v: ArrayLike) -> Array:
    """3 x 3 matrix of the cross product with ``v``."""
    x, y, z = np.asarray(v, dtype=float)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


@dataclass(frozen=True, eq=False, repr=False)
class InertialParameters(Brief):
    """Inertial parameters of a body: Khalil's ten, about the origin and in the axes of its frame.

    Attributes:
        vector: XX XY XZ YY YZ ZZ [kg m^2], MX MY MZ [kg m], M [kg], shape (10,). XY is the entry of the
            inertia matrix, -integral of x y dm.

    >>> InertialParameters.from_com(2.0, [0.0, 0.0, 0.1], [0.01, 0.01, 0.005]).com
    array([0. , 0. , 0.1])
    """

    vector: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "vector", frozen_array(self.vector, (10,), "inertial parameters"))

    def __repr__(self) -> str:
        return f"InertialParameters({', '.join(f'{name}={value:.5g}' for name, value in self.named().items())})"

    @staticmethod
    def from_com(mass: float, com: ArrayLike, inertia_com: ArrayLike) -> InertialParameters:
        """Make a body of its mass [kg], centre of mass [m] and the inertia about it [kg m^2].

        Args:
            mass: positive.
            com: in the body's frame, shape (3,).
            inertia_com: about the centre of mass in the frame's axes: three moments of a diagonal matrix, the six
                entries XX XY XZ YY YZ ZZ, or the symmetric 3 x 3 matrix.

        Raises:
            InputError: for another shape, and for a body that cannot exist.
        """
        if not 0.0 < mass < np.inf:
            raise InputError(f"mass {mass:g} kg: a body has a positive mass")
        c = _numbers(com, "centre of mass")
        if c.shape != (3,):
            raise InputError(f"centre of mass of shape {c.shape}: give x, y, z [m]")
        rounding = _ROUNDING * float(mass * (c @ c))
        inertia = _numbers(inertia_com, "inertia")
        if inertia.shape not in ((3,), (6,), (3, 3)):
            fault = f"inertia of shape {inertia.shape}"
            raise InputError(f"{fault}: give three moments, six entries XX XY XZ YY YZ ZZ, or a 3 x 3 matrix")
        if inertia.ndim == 1:
            inertia = np.diag(inertia) if len(inertia) == 3 else symmetric(inertia)
        if np.abs(inertia - inertia.T).max() > 1e-6 * np.abs(inertia).max() + rounding:
            raise InputError("inertia: the 3 x 3 matrix is not symmetric: check the products of inertia")
        inertia = 0.5 * (inertia + inertia.T)
        # No body has a negative principal moment, or one that exceeds the sum of the others.
        moments = np.linalg.eigvalsh(inertia)
        allowed = _ROUNDING * float(np.abs(moments).sum()) + rounding
        if moments[0] < -allowed or moments[0] + moments[1] < moments[2] - allowed:
            shown = ", ".join(f"{moment:.4g}" for moment in moments)
            why = "one is negative" if moments[0] < -allowed else "the largest exceeds the sum of the others"
            fault = f"principal moments {shown} kg m^2: no body has them ({why})"
            raise InputError(f"{fault}: correct the inertia, which is about the centre of mass")
        return InertialParameters(ten_parameters(mass, c, inertia))

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return float(self.vector[9])

    @property
    def first_moments(self) -> Array:
        """Mass times centre of mass [kg m], shape (3,)."""
        return self.vector[6:9]

    @cached_property
    def inertia(self) -> Array:
        """Inertia about the frame's origin [kg m^2], 3 x 3."""
        return frozen_array(symmetric(self.vector[:6]), (3, 3), "inertia")

    @cached_property
    def com(self) -> Array:
        """Centre of mass [m], shape (3,). Raises ZeroDivisionError for a body without mass."""
        if self.mass == 0.0:
            raise ZeroDivisionError("a body without mass has no centre of mass")
        return frozen_array(self.first_moments / self.mass, (3,), "centre of mass")

    @cached_property
    def inertia_com(self) -> Array:
        """Inertia about the centre of mass, in the frame's axes [kg m^2], 3 x 3."""
        cross = skew(self.com)
        return frozen_array(self.inertia + self.mass * cross @ cross, (3, 3), "inertia")

    @cached_property
    def pseudo_inertia(self) -> Array:
        """4 x 4 pseudo-inertia [[integral of p p' dm, m c], [m c', m]]; a body can exist if it has no
        negative eigenvalue (Wensing, Kim and Slotine, 2018).
        """
        h, spread = self.first_moments[:, None], 0.5 * np.trace(self.inertia) * np.eye(3) - self.inertia
        return frozen_array(np.block([[spread, h], [h.T, self.mass]]), (4, 4), "pseudo-inertia")

    @cached_property
    def min_pseudo_inertia_eigenvalue(self) -> float:
        """Smallest eigenvalue of the pseudo-inertia (mixed units: kg m^2, kg m and kg)."""
        return float(np.linalg.eigvalsh(self.pseudo_inertia)[0])

    @property
    def physically_consistent(self) -> bool:
        """True if such a body can exist: positive mass and no negative pseudo-inertia eigenvalue."""
        return self.mass > 0.0 and self.min_pseudo_inertia_eigenvalue >= 0.0

    def moved(self, rotation: ArrayLike, origin: ArrayLike) -> InertialParameters:
        """Describe the body in another frame.

        Args:
            rotation: 3 x 3; its columns are this frame's axes in the other frame.
            origin: this frame's origin in the other frame [m], shape (3,).
        """
        R, p = np.asarray(rotation, dtype=float), np.asarray(origin, dtype=float)
        h = R @ self.first_moments
        # About the new origin: J' = R J R' - (h^ p^ + p^ h^) - m p^ p^.
        inertia = R @ self.inertia @ R.T - skew(h) @ skew(p) - skew(p) @ skew(h)
        inertia -= self.mass * skew(p) @ skew(p)
        upper = inertia[_ROWS, _COLUMNS]
        return InertialParameters(np.concatenate([upper, h + self.mass * p, [self.mass]]))

    def named(self, suffix: str = "") -> dict[str, float]:
        """Map names of the ten, "XX" to "M" with a suffix such as "6", to their values."""
        return {f"{kind}{suffix}": float(value) for kind, value in zip(INERTIAL, self.vector, strict=True)}


def ten_parameters(mass: float, com: Array, inertia_com: Array) -> Array:
    """Compute Khalil's ten by Steiner's theorem, (10,), of any numbers; ``from_com`` refuses impossible bodies."""
    inertia = inertia_com - mass * skew(com) @ skew(com)
    return np.concatenate([inertia[_ROWS, _COLUMNS], mass * com, [mass]])


def symmetric(entries: ArrayLike) -> Array:
    """Make the 3 x 3 matrix of its entries XX XY XZ YY YZ ZZ, which may be rows of several numbers each."""
    matrix = np.empty((3, 3, *np.shape(entries)[1:]))
    matrix[_ROWS, _COLUMNS] = matrix[_COLUMNS, _ROWS] = entries
    return matrix


def _numbers(values: ArrayLike, name: str) -> Array:
    try:
        numbers = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{name} {values!r}: numbers are needed") from None
    if not np.isfinite(numbers).all():
        raise InputError(f"{name} has a number that is not finite")
    return numbers


def gradients(x: Array) -> Array:
    """Gradients by the ten x of the centre of mass, then of the inertia there, XX XY XZ YY YZ ZZ; 9 x 10.

    That inertia is I_0 - (|h|^2 1 - h h') / M with the first moments h.
    """
    h, M, one, slopes = x[6:9], x[9], np.eye(3), np.eye(9, 10, -3)
    slopes[:3, 6:9], slopes[:3, 9] = one / M, -h / M**2
    by_h = 2.0 * h[:, None, None] * one - one[:, :, None] * h - one[:, None] * h[:, None]
    slopes[3:, 6:9] = -by_h[:, _ROWS, _COLUMNS].T / M
    slopes[3:, 9] = (h @ h * one - np.outer(h, h))[_ROWS, _COLUMNS] / M**2
    return slopes


class PayloadSpread(Document, frozen=True, eq=False):
    """Standard deviations of a body's numbers; infinite where a number is not determined, null in a document.

    Attributes:
        mass: [kg].
        com: of the centre of mass [m], shape (3,).
        inertia_com: of the inertia at the centre of mass [kg m^2], 3 x 3.
    """

    mass: Float
    com: Vector
    inertia_com: Matrix

    @property
    def moments(self) -> Array:
        """The three moments of inertia [kg m^2], shape (3,)."""
        return np.diag(self.inertia_com).copy()


def payload_spread(values: Array, covariance: Array, indices: Sequence[int]) -> PayloadSpread:
    """Standard deviations of a body's numbers to first order, by the full covariance.

    ``values``: the ten, shape (10,); ``covariance``: of those that are determined, k x k; ``indices``: which, k.
    """
    C = np.zeros((10, 10))
    C[np.ix_(indices, indices)] = covariance
    known, sigma = np.isin(np.arange(10), indices), np.full(9, np.inf)
    x = np.where(known, values, 0.0)
    if known[9] and x[9] != 0.0:
        J = gradients(x)
        # Known is what depends on known ones alone: a moment on the other two first moments, a product on its own.
        rest = (gradients(np.ones(10)) != 0.0) @ ~known
        sigma = np.where(rest, np.inf, np.sqrt(np.maximum(np.einsum("ik,kl,il->i", J, C, J), 0.0)))
    mass = float(np.sqrt(C[9, 9])) if known[9] else np.inf
    return PayloadSpread(mass, sigma[:3], symmetric(sigma[3:]))
