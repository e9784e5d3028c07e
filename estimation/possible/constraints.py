"""Prior knowledge of a body, as small values that can be combined."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from ...common import Array, ArrayLike, InputError, frozen_array
from ...model import InertialParameters
from ...model.pose import check_metres

PSEUDO_INERTIA: Array = np.array([InertialParameters(unit).pseudo_inertia for unit in np.eye(10)])
"""Matrices of the pseudo-inertia: J = sum over k of x_k times the k-th: 10 x 4 x 4."""


def lowest_eigenvalue(x: Array) -> float:
    """Smallest eigenvalue of the pseudo-inertia of ten parameters in any units."""
    return float(np.linalg.eigvalsh((x @ PSEUDO_INERTIA.reshape(10, 16)).reshape(4, 4))[0])


@dataclass(frozen=True)
class Constraint:
    """Constraint on x, Khalil's ten of one body about the origin and in the axes of its frame."""

    demand: ClassVar[str]  # its numbers to be filled in from the attributes

    @property
    def description(self) -> str:
        """Demand in one line."""
        return self.demand.format(**vars(self))

    def violation(self, x: ArrayLike) -> float:
        """Distance of x, (10,), from keeping it: <= 0 where it is kept, in the constraint's own unit."""
        A, b = self.rows
        return float(np.max(-(A @ np.asarray(x, dtype=float) + b), initial=-np.inf))

    @property
    def rows(self) -> tuple[Array, Array]:
        """Rows A, k x 10, and b, (k,), of its linear inequalities A x + b >= 0; none by default."""
        return np.zeros((0, 10)), np.zeros(0)


@dataclass(frozen=True)
class PossibleBody(Constraint):
    """Body that can exist: its 4 x 4 pseudo-inertia is positive semidefinite (Wensing, Kim and Slotine, 2018).

    Nothing weaker will do: positive mass and a positive definite inertia still allow principal inertias that
    break the triangle inequality, which no distribution of mass has. Every estimate holds it, listed or not.

    Attributes:
        body: how texts call the body.
    """

    body: str = "payload"
    demand = "{body} can exist: pseudo-inertia positive semidefinite"

    def violation(self, x: ArrayLike) -> float:
        """Minus the smallest eigenvalue of the pseudo-inertia (mixed units)."""
        return -InertialParameters(np.asarray(x, dtype=float)).min_pseudo_inertia_eigenvalue


@dataclass(frozen=True)
class MassBounds(Constraint):
    """Bounds on the mass: low <= M <= high.

    Attributes:
        low: smallest mass [kg].
        high: largest mass [kg]; may be infinite.
    """

    low: float = 0.0
    high: float = float("inf")
    demand = "mass from {low:g} to {high:g} kg"

    def __post_init__(self) -> None:
        if not self.low <= self.high or not np.isfinite(self.low) or not self.high > 0.0:
            raise InputError(
                f"no mass lies within {self.low:g} to {self.high:g} kg: give low <= high, and high above 0"
            )

    @cached_property
    def rows(self) -> tuple[Array, Array]:
        """Rows of M - low >= 0 and high - M >= 0 [kg]."""
        finite, A = np.isfinite([self.low, self.high]), np.zeros((2, 10))
        A[:, 9] = 1.0, -1.0
        return A[finite], np.array([-self.low, self.high])[finite]


@dataclass(frozen=True)
class KnownMass(Constraint):
    """Weighed mass: a soft term ((M - mass) / sigma)^2, because scales err too, that nothing violates.

    Attributes:
        mass: what the scale shows [kg].
        sigma: its standard deviation [kg].
    """

    mass: float
    sigma: float
    demand = "mass weighed as {mass:g} kg, standard deviation {sigma:g} kg"

    def __post_init__(self) -> None:
        if not (self.mass > 0.0 and self.sigma > 0.0 and np.isfinite([self.mass, self.sigma]).all()):
            raise InputError(
                f"known mass {self.mass:g} kg with sigma {self.sigma:g} kg: mass and sigma must be positive"
            )


@dataclass(frozen=True)
class CentreOfMassInBox(Constraint):
    """Box along the frame's axes in which the centre of mass lies.

    Attributes:
        low: smallest coordinates [m], shape (3,).
        high: largest coordinates [m], shape (3,).
    """

    low: ArrayLike
    high: ArrayLike
    demand = "centre of mass in the box {low!r} to {high!r} m"

    def __post_init__(self) -> None:
        for name in ("low", "high"):
            object.__setattr__(self, name, _as_tuples(getattr(self, name), (3,), f"{name} corner of the box"))
            check_metres(getattr(self, name), f"{name} corner of the box")
        if (np.asarray(self.low) > np.asarray(self.high)).any():
            raise InputError(f"the box from {self.low!r} to {self.high!r} m is empty: give low <= high")

    @cached_property
    def rows(self) -> tuple[Array, Array]:
        """Rows of MX - M low >= 0 and M high - MX >= 0 for each axis [kg m]."""
        A = np.zeros((6, 10))
        A[:3, 6:9], A[3:, 6:9] = np.eye(3), -np.eye(3)
        A[:3, 9], A[3:, 9] = -np.asarray(self.low), np.asarray(self.high)
        return A, np.zeros(6)


@dataclass(frozen=True)
class InEllipsoid(Constraint):
    """Ellipsoid in which all mass lies: tr(J Q) >= 0 for the pseudo-inertia J (Wensing, Kim and Slotine, 2018).

    Q is the 4 x 4 matrix with [p 1] Q [p 1]' >= 0 for points p inside. Together with ``PossibleBody`` the
    condition is necessary and sufficient.

    Attributes:
        centre: of the ellipsoid [m], shape (3,).
        semi_axes: half the lengths of its axes [m], shape (3,).
        rotation: 3 x 3, its columns are the directions of the axes; the frame's own by default.
    """

    centre: ArrayLike
    semi_axes: ArrayLike
    rotation: ArrayLike = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    demand = "mass in the ellipsoid around {centre!r} with semi-axes {semi_axes!r} m"

    def __post_init__(self) -> None:
        for name, shape in (("centre", (3,)), ("semi_axes", (3,)), ("rotation", (3, 3))):
            object.__setattr__(self, name, _as_tuples(getattr(self, name), shape, f"{name} of an ellipsoid"))
        for name in ("centre", "semi_axes"):
            check_metres(getattr(self, name), name)
        if not (np.asarray(self.semi_axes) > 0.0).all():
            raise InputError(f"semi_axes {self.semi_axes!r} m of an ellipsoid: all three must be positive")
        R = np.asarray(self.rotation)
        if np.abs(R.T @ R - np.eye(3)).max() > 1e-6:
            raise InputError("rotation of an ellipsoid: its columns must be orthonormal")

    @cached_property
    def rows(self) -> tuple[Array, Array]:
        """Row of tr(J Q) >= 0 [kg]."""
        c, R = np.asarray(self.centre), np.asarray(self.rotation)
        A = R @ np.diag(1.0 / np.square(self.semi_axes)) @ R.T
        Q = np.block([[-A, (A @ c)[:, None]], [(c @ A)[None], np.array([[1.0 - c @ A @ c]])]])
        return np.einsum("kij,ij->k", PSEUDO_INERTIA, Q)[None], np.zeros(1)


def _as_tuples(values: ArrayLike, shape: tuple[int, ...], name: str) -> Any:
    """Convert numbers to nested tuples, which compare and hash."""
    try:
        array = frozen_array(values, shape, name)
    except ValueError as error:
        raise InputError(f"{error}: correct it") from None
    return tuple(map(tuple, array.tolist())) if array.ndim == 2 else tuple(array.tolist())
