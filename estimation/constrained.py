"""The payload nearest to a free estimate among those that can exist.

Minimises (x - x_LS)' C^-1 (x - x_LS) over the x that hold the constraints. Whatever method gave x_LS with its full
covariance C, the data enter only through this distance: minimising a joint problem over the robot's parameters
first, which are not constrained, leaves exactly it (C is the block of the joint covariance, and its inverse the
Schur complement of the joint normal matrix). So method 4 under constraints on the payload is this problem too.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

from ..model import InertialParameters, InputError
from ..model.arrays import Array, frozen_array
from .cone import ConeProgram, ConeSolution, SolverFailed, solve_cone
from .constraints import PSEUDO_INERTIA, Constraint, KnownMass, PossibleBody
from .estimate import Estimate
from .payload.problem import PAYLOAD

POSSIBLE = (PossibleBody("payload"),)
"""What every payload holds."""
_DEPENDENT = 1e-13
"""Smallest eigenvalue of a correlation matrix that counts as of full rank."""
_NO_MULTIPLIER = 1e-7
"""A smaller multiplier is rounding."""
_TOLERANCE = 1e-6
"""By how much a linear constraint may be missed, in scaled units."""


class Active(NamedTuple):
    """A constraint that holds the estimate back.

    ``multiplier``: how fast chi2 falls as the constraint is relaxed, per scaled unit (M l^2, M l, M of the body).
    """

    constraint: Constraint
    multiplier: float


@dataclass(frozen=True)
class ConstrainedEstimate:
    """A payload that can exist, and what that cost.

    Attributes:
        free: the unconstrained estimate.
        values: the constrained ten in the order of ``PAYLOAD``, shape (10,); eliminated ones are zero.
        chi2_rise: of these values, squared distance from the free ones by their covariance, plus soft terms.
        soft_terms: number of soft terms.
        active: constraints that hold the estimate back, largest multiplier first.
        status: of the solver; "free" if the free estimate holds every constraint and nothing was solved.
    """

    free: Estimate
    values: Array
    chi2_rise: float
    soft_terms: int
    active: tuple[Active, ...]
    status: str

    def __post_init__(self) -> None:
        """Lock the values."""
        object.__setattr__(self, "values", frozen_array(self.values, (10,), "constrained values"))

    @cached_property
    def body(self) -> InertialParameters:
        """The payload as a body."""
        return InertialParameters(self.values)

    @property
    def min_pseudo_inertia_eigenvalue(self) -> float:
        """Smallest eigenvalue of the pseudo-inertia; not negative."""
        return self.body.min_pseudo_inertia_eigenvalue

    @property
    def moved_in_sigma(self) -> Array:
        """By how many standard deviations each free value was moved, in the order of ``free.names``."""
        places = [PAYLOAD.index(name) for name in self.free.names]
        return np.asarray((self.values[places] - self.free.values) / self.free.sigma)

    @property
    def p_value(self) -> float:
        """Probability of a rise this large if the true payload holds the constraints.

        The nearest admissible point is no farther than the truth, whose squared distance is chi-squared with as
        many degrees of freedom k as there are parameters and soft terms (k times Fisher's F, as the covariance
        holds an estimated variance). At the boundary of a cone the rise itself follows a mixture of chi-squared
        laws of 0 to k degrees of freedom, for which the law of k is an upper bound: this p-value is too large,
        never too small; a small one says that a constraint or the model is wrong.
        """
        from scipy.special import chdtrc, fdtrc

        k = len(self.free.names) + self.soft_terms
        if np.isinf(self.free.degrees_of_freedom):
            return float(chdtrc(k, self.chi2_rise))
        return float(fdtrc(k, max(self.free.degrees_of_freedom, 1.0), self.chi2_rise / k))


def constrained(estimate: Estimate, constraints: Sequence[Constraint] = POSSIBLE) -> ConstrainedEstimate:
    """The nearest payload that holds the constraints.

    ``PossibleBody`` always holds, whether listed or not. Bounds hold to 1e-6 of the body's own size, the
    pseudo-inertia exactly: it is repaired after the solve, and chi2 is that of the repaired values.

    Args:
        estimate: of some or all of ``PAYLOAD``; parameters that are absent were eliminated and stay zero.
        constraints: what is known beforehand.

    Raises:
        InputError: if the covariance does not determine every parameter.
        SolverFailed: for anything but a clean solve, as when no body holds all constraints.
    """
    constraints = _with_possible(constraints)
    problem = _Scaled.of(estimate, constraints)
    hard = [c for c in constraints if not isinstance(c, KnownMass)]
    nearest = problem.full(problem.centre)
    if all(c.violation(nearest) <= 0.0 for c in hard):
        return ConstrainedEstimate(estimate, nearest, problem.floor, problem.soft_terms, (), "free")
    program = problem.program()
    solution = solve_cone(program)
    z = problem.repaired(solution.z)
    if len(program.A) and (program.A @ z + program.b).min() < -_TOLERANCE:
        raise SolverFailed("constraints missed after the solve", program)
    distance = float(np.sum((program.R @ z - program.d) ** 2))
    active = problem.active(hard, z, solution)
    chi2 = distance + problem.floor
    return ConstrainedEstimate(estimate, problem.full(z), chi2, problem.soft_terms, active, solution.status)


class CvxpyProblem(NamedTuple):
    """The same problem in CVXPY, to which other constraints and terms can be added.

    ``problem``: a ``cvxpy.Problem``, its value the distance, square root of the chi2 rise less what
    soft terms alone cost; ``values``: the
    parameters ``estimate.names`` in SI units, an expression; ``pseudo_inertia``: 4 x 4, SI units, an expression.
    """

    problem: Any
    values: Any
    pseudo_inertia: Any


def build_constrained(estimate: Estimate, constraints: Sequence[Constraint] = POSSIBLE) -> CvxpyProblem:
    """What ``constrained`` solves, as a CVXPY problem that is not solved yet.

    Add your own by ``cvxpy.Problem(built.problem.objective, [*built.problem.constraints, ...])``. Its solution is
    not repaired: eigenvalues down to -1e-7 of the largest are left.

    Raises:
        InputError: if the covariance does not determine every parameter, or CVXPY is not installed.
    """
    try:
        import cvxpy
    except ImportError:
        raise InputError("build_constrained needs CVXPY: install dynident[cvxpy]") from None
    problem = _Scaled.of(estimate, _with_possible(constraints))
    program = problem.program()
    z = cvxpy.Variable(len(estimate.names), name="scaled_parameters")
    ten = program.bodies[0]
    scaled = cvxpy.reshape((PSEUDO_INERTIA.reshape(10, 16).T @ ten) @ z, (4, 4), order="C")
    rules = [scaled >> 0]
    if len(program.A):
        rules.append(program.A @ z + program.b >= 0)
    objective = cvxpy.Minimize(cvxpy.norm(program.R @ z - program.d))
    values = cvxpy.multiply(problem.scale, z)
    places = [PAYLOAD.index(name) for name in estimate.names]
    si = cvxpy.reshape(PSEUDO_INERTIA.reshape(10, 16).T[:, places] @ values, (4, 4), order="C")
    return CvxpyProblem(cvxpy.Problem(objective, rules), values, si)


class _Scaled(NamedTuple):
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
    soft_terms: int

    @staticmethod
    def of(estimate: Estimate, constraints: Sequence[Constraint]) -> "_Scaled":
        """Scale an estimate and its constraints."""
        select = np.eye(10)[_places(estimate)]
        scale = select @ _sizes(estimate, select)
        centre, n = estimate.values / scale, len(scale)
        factor = whitening(estimate.covariance, estimate.names) * scale
        soft = [c.soft for c in constraints if isinstance(c, KnownMass)]
        # One more QR merges soft terms: the distance from their common minimum is all that is left to the solver.
        rows = [np.append(term.a @ select.T * scale, term.b) / term.sigma for term in soft]
        R, d, floor = factor, factor @ centre, 0.0
        if soft:
            merged = np.linalg.qr(np.vstack([np.column_stack([R, d]), *rows]), mode="r")
            R, d, floor = merged[:n, :n], merged[:n, n], float(merged[n, n] ** 2)
            centre = solve_triangular(R, d)
        A = np.vstack([c.rows.A for c in constraints]) @ select.T * scale
        b = np.concatenate([c.rows.b for c in constraints])
        norms = np.maximum(np.abs(A).max(axis=1, initial=0.0), 1e-300)
        owners = tuple(c for c in constraints for _ in c.rows.b)
        return _Scaled(select, scale, centre, R, d, floor, A / norms[:, None], b / norms, owners, len(soft))

    def program(self) -> ConeProgram:
        """What the solver takes."""
        return ConeProgram(self.R, self.d, self.A, self.b, self.select.T[None])

    def full(self, z: Array) -> Array:
        """The ten in SI units."""
        return np.asarray((z * self.scale) @ self.select)

    def repaired(self, z: Array) -> Array:
        """z moved by as little as leaves no negative eigenvalue; eliminated parameters stay zero."""
        step, inward = max(-self.lowest(z), 0.0), self.select @ _IDENTITY
        result = z + step * inward
        while InertialParameters(self.full(result)).min_pseudo_inertia_eigenvalue < 0.0:
            step = 2.0 * step + 1e-16
            if step > _TOLERANCE:
                raise SolverFailed("eigenvalues too negative to be repaired", self.program())
            result = z + step * inward
        return result

    def active(self, constraints: Sequence[Constraint], z: Array, solution: ConeSolution) -> tuple[Active, ...]:
        """Constraints whose multiplier exceeds their slack, largest first."""
        found: list[Active] = []
        for constraint in constraints:
            rows = [k for k, owner in enumerate(self.owners) if owner is constraint]
            slack, multipliers = (self.A @ z + self.b)[rows], solution.row_multipliers[rows]
            if isinstance(constraint, PossibleBody):
                slack, multipliers = np.array([self.lowest(z)]), solution.body_multipliers
            holding = float(multipliers[multipliers > np.maximum(slack, _NO_MULTIPLIER)].sum())
            if holding > 0.0:
                found.append(Active(constraint, 2.0 * solution.norm * holding))  # d chi2 = 2 norm d norm
        return tuple(sorted(found, key=lambda active: -active.multiplier))

    def lowest(self, z: Array) -> float:
        """Smallest eigenvalue of the scaled pseudo-inertia."""
        return float(np.linalg.eigvalsh(np.tensordot(z @ self.select, PSEUDO_INERTIA, 1))[0])


_IDENTITY: Array = np.array([2.0, 0.0, 0.0, 2.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0])
"""The ten whose pseudo-inertia is the identity."""


def whitening(C: Array, names: Sequence[str]) -> Array:
    """R with R'R = C^-1.

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
    L = np.linalg.cholesky(C / np.outer(sigma, sigma))
    return np.asarray(solve_triangular(L, np.diag(1.0 / sigma), lower=True))


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


def _with_possible(constraints: Sequence[Constraint]) -> tuple[Constraint, ...]:
    if any(isinstance(c, PossibleBody) for c in constraints):
        return tuple(constraints)
    return (*POSSIBLE, *constraints)
