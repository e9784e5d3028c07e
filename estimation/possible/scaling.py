"""The constrained payload problem in scaled units, where a cone solver is accurate."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import InertialParameters
from ..equations.equations import PAYLOAD
from ..fit.estimate import Estimate
from .cone import ConeProgram, ConeSolution, SolverError
from .constraints import PSEUDO_INERTIA, Constraint, KnownMass, PossibleBody
from .result import Active

POSSIBLE = (PossibleBody("payload"),)
"""What every payload holds."""
_NO_MULTIPLIER = 1e-7
"""A smaller multiplier is rounding."""
_DEPENDENT = 1e-13
"""Smallest eigenvalue of a correlation matrix that counts as of full rank."""
NOISE_FLOOR = 3e-7
"""Of the body's own size: a solver accurate to 1e-8 cannot weigh finer errors, nor does any recording have them."""
TOLERANCE = 1e-6
"""By how much a linear constraint may be missed, in scaled units."""


class ScaledProblem(NamedTuple):
    """The problem in z = x / (M l^2, M l, M), for the parameters that were not eliminated.

    ``select`` n x 10 picks them, ``scale`` (n,); chi2 = ||R z - d||^2 + ``floor`` with ``R`` n x n, ``d`` (n,), and
    its minimum at ``centre`` (n,); ``A`` and ``b`` the bounds with rows of largest entry 1, ``owners`` the
    constraint of each row.
    """

    select: Array
    scale: Array
    centre: Array
    R: Array
    d: Array
    floor: float
    A: Array
    b: Array
    owners: tuple[Constraint, ...]

    @staticmethod
    def of(estimate: Estimate, constraints: Sequence[Constraint]) -> "ScaledProblem":
        """Scale an estimate and its constraints."""
        select = np.eye(10)[_places(estimate)]
        scale = select @ _sizes(estimate, select)
        centre, n = estimate.values / scale, len(scale)
        factor = whitening(estimate.covariance, estimate.names, NOISE_FLOOR * scale) * scale
        # One more QR merges soft terms: the distance from their common minimum is all that is left to the solver.
        weighed = [c for c in constraints if isinstance(c, KnownMass)]
        rows = [np.append(select[:, 9] * scale, term.mass) / term.sigma for term in weighed]
        R, d, floor = factor, factor @ centre, 0.0
        if rows:
            merged = np.asarray(np.linalg.qr(np.vstack([np.column_stack([R, d]), *rows]), mode="r"))
            R, d, floor = merged[:n, :n], merged[:n, n], float(merged[n, n] ** 2)
            centre = solve_triangular(R, d)
        A = np.vstack([c.rows.A for c in constraints]) @ select.T * scale
        b = np.concatenate([c.rows.b for c in constraints])
        norms = np.maximum(np.abs(A).max(axis=1, initial=0.0), 1e-300)
        owners = tuple(c for c in constraints for _ in c.rows.b)
        return ScaledProblem(select, scale, centre, R, d, floor, A / norms[:, None], b / norms, owners)

    def program(self) -> ConeProgram:
        """What the solver takes."""
        return ConeProgram(self.R, self.d, self.A, self.b, self.select.T[None])

    def full(self, z: Array) -> Array:
        """The ten in SI units, (10,) or k x 10."""
        return np.asarray((z * self.scale) @ self.select)

    def holds(self, z: Array) -> bool:
        """Whether z holds every constraint."""
        return bool((self.A @ z + self.b >= 0.0).all()) and self.lowest(z) >= 0.0

    def repaired(self, z: Array) -> Array:
        """z moved by as little as leaves no negative eigenvalue; eliminated parameters stay zero.

        Raises:
            SolverError: if that is more than rounding, or a bound is missed by more.
        """
        step, inward = 1.01 * max(-self.lowest(z), 0.0), self.select @ IDENTITY
        result = z + step * inward
        while InertialParameters(self.full(result)).min_pseudo_inertia_eigenvalue < 0.0 and step < TOLERANCE:
            step = 2.0 * step + 1e-16
            result = z + step * inward
        if step >= TOLERANCE or (self.A @ result + self.b < -TOLERANCE).any():
            raise SolverError("constraints missed by more than rounding", self.program())
        return np.asarray(result)

    def active(self, constraints: Sequence[Constraint], z: Array, solution: ConeSolution) -> tuple[Active, ...]:
        """Constraints whose multiplier exceeds their slack, largest first."""
        found: list[Active] = []
        for constraint in constraints:
            rows = [k for k, owner in enumerate(self.owners) if owner is constraint]
            slack, multipliers = (self.A @ z + self.b)[rows], solution.row_multipliers[rows]
            if isinstance(constraint, PossibleBody):
                slack, multipliers = np.array([self.lowest(z)]), solution.body_multipliers
            holding = float(multipliers[multipliers > np.maximum(slack, _NO_MULTIPLIER)].sum())
            if holding > 0.0:  # d chi2 = 2 norm d norm
                found.append(Active(constraint.description, 2.0 * solution.norm * holding, constraint))
        return tuple(sorted(found, key=lambda active: -active.multiplier))

    def lowest(self, z: Array) -> float:
        """Smallest eigenvalue of the scaled pseudo-inertia."""
        return float(np.linalg.eigvalsh((z @ self.select @ PSEUDO_INERTIA.reshape(10, 16)).reshape(4, 4))[0])


IDENTITY: Array = np.array([2.0, 0.0, 0.0, 2.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0])
"""The ten whose pseudo-inertia is the identity."""


def whitening(C: Array, names: Sequence[str], floor: Array) -> Array:
    """R with R'R = (C + diag(floor^2))^-1.

    Raises:
        InputError: if C is not finite or not of full rank.
    """
    sigma = np.sqrt(np.maximum(np.diag(C), 0.0))
    if not np.isfinite(C).all() or (sigma == 0.0).any():
        raise InputError(f"the covariance of {', '.join(names)} is no covariance: identify all of them first")
    values, vectors = np.linalg.eigh(C / np.outer(sigma, sigma))
    if values[0] < _DEPENDENT * values[-1]:
        mixed = [name for name, part in zip(names, np.abs(vectors[:, 0]), strict=True) if part > 0.05]
        raise InputError(
            f"the data do not tell {', '.join(mixed)} apart: constraints cannot replace motion; move more joints"
        )
    L = np.linalg.cholesky((C + np.diag(floor**2)) / np.outer(sigma, sigma))
    return np.linalg.solve(L, np.diag(1.0 / sigma))


def _places(estimate: Estimate) -> list[int]:
    unknown = [name for name in estimate.names if name not in PAYLOAD]
    if unknown or not {"M_L"} <= set(estimate.names):
        raise InputError(
            f"an estimate of {', '.join(estimate.names)} is not that of a payload: it needs M_L and others of "
            f"{', '.join(PAYLOAD)}"
        )
    return [PAYLOAD.index(name) for name in estimate.names]


def _sizes(estimate: Estimate, select: Array) -> Array:
    """M l^2, M l and M for the ten, from the estimate itself or, where it is next to nothing, its sigma."""
    size = np.maximum(np.abs(estimate.values), estimate.sigma) @ select
    mass = size[9]
    length = np.sqrt(max(size[[0, 3, 5]].sum() / 2.0, size[6:9].max() ** 2 / mass) / mass)
    return np.asarray([mass * length**2] * 6 + [mass * length] * 3 + [mass])


def with_possible(constraints: Sequence[Constraint]) -> tuple[Constraint, ...]:
    """The constraints, with ``PossibleBody`` if it was not listed."""
    if any(isinstance(c, PossibleBody) for c in constraints):
        return tuple(constraints)
    return (*POSSIBLE, *constraints)
