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

from ...common.arrays import Array, frozen_array
from ...model import InertialParameters
from ..equations.names import PAYLOAD
from ..fit.estimate import Estimate
from .cone import SolverError, solve_cone
from .constraints import PSEUDO_INERTIA, Constraint, KnownMass
from .scaling import NOISE_FLOOR, POSSIBLE, Active, ScaledProblem, rise_p_value, with_possible


@dataclass(frozen=True)
class ConstrainedEstimate:
    """A payload that can exist, and what that cost.

    Attributes:
        free: the unconstrained estimate.
        values: the constrained ten in the order of ``PAYLOAD``, shape (10,); eliminated ones are zero.
        chi2_rise: of these values, squared distance from the free ones by their covariance, plus soft terms.
        soft_terms: number of soft terms.
        active: constraints that hold the estimate back, largest multiplier first.
        constraints: what was demanded.
        status: of the solver; without a solve "free" if the free estimate holds every constraint, "repaired" if
            it does but for an eigenvalue of rounding size (exact data).
    """

    free: Estimate
    values: Array
    chi2_rise: float
    soft_terms: int
    active: tuple[Active, ...]
    constraints: tuple[Constraint, ...]
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
        k = len(self.free.names) + self.soft_terms
        return rise_p_value(self.chi2_rise, k, self.free.degrees_of_freedom)


def solve_constrained(estimate: Estimate, constraints: Sequence[Constraint] = POSSIBLE) -> ConstrainedEstimate:
    """The nearest payload that holds the constraints.

    ``PossibleBody`` always holds, whether listed or not. Bounds hold to 1e-6 of the body's own size, the
    pseudo-inertia exactly: it is repaired after the solve, and chi2 is that of the repaired values.

    Args:
        estimate: of some or all of ``PAYLOAD``; parameters that are absent were eliminated and stay zero.
        constraints: what is known beforehand.

    Raises:
        InputError: if the covariance does not determine every parameter.
        SolverError: for anything but a clean solve, as when no body holds all constraints.
    """
    constraints = with_possible(constraints)
    problem = ScaledProblem.of(estimate, constraints)
    try:
        z, active, status = _nearest(problem, [c for c in constraints if not isinstance(c, KnownMass)])
    except SolverError as error:
        raise error.naming(*(c.description for c in constraints)) from None
    chi2 = problem.floor + float(np.sum((problem.R @ (z - problem.centre)) ** 2))
    return ConstrainedEstimate(estimate, problem.full(z), chi2, problem.soft_terms, active, constraints, status)


def _nearest(problem: ScaledProblem, hard: Sequence[Constraint]) -> tuple[Array, tuple[Active, ...], str]:
    """Scaled parameters, active constraints and status."""
    z = problem.centre
    if all(c.violation(problem.full(z)) <= 0.0 for c in hard):
        return z, (), "free"
    if problem.lowest(z) >= -NOISE_FLOOR and (problem.A @ z + problem.b >= 0.0).all():
        return problem.repaired(z), (), "repaired"  # rounding, too little for a solver to work on
    solution = solve_cone(problem.program())
    z = problem.repaired(solution.z)
    return z, problem.active(hard, z, solution), solution.status


class CvxpyProblem(NamedTuple):
    """The same problem in CVXPY, to which other constraints and terms can be added.

    ``problem``: a ``cvxpy.Problem``, its value the distance, square root of the chi2 rise
    less what soft terms alone cost; ``values``: the parameters ``estimate.names``, ``pseudo_inertia``: 4 x 4, both
    expressions in SI units.
    """

    problem: Any
    values: Any
    pseudo_inertia: Any


def build_constrained(estimate: Estimate, constraints: Sequence[Constraint] = POSSIBLE) -> CvxpyProblem:
    """What ``solve_constrained`` solves, as a CVXPY problem that is not solved yet.

    Add your own by ``cvxpy.Problem(built.problem.objective, [*built.problem.constraints, ...])``. Its solution is
    not repaired: eigenvalues down to -1e-7 of the largest are left.

    Raises:
        InputError: if the covariance does not determine every parameter.
    """
    import cvxpy  # slow to import

    problem = ScaledProblem.of(estimate, with_possible(constraints))
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
