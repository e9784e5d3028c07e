"""The payload nearest to a free estimate among those that can exist.

Minimises (x - x_LS)' C^-1 (x - x_LS) over the x that hold the constraints. Whatever method gave x_LS with its full
covariance C, the data enter only through this distance: minimising a joint problem over the robot's parameters
first, which are not constrained, leaves exactly it (C is the block of the joint covariance, and its inverse the
Schur complement of the joint normal matrix). So method 4 under constraints on the payload is this problem too.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.linear import rank
from ...model import InertialParameters
from ..equations.equations import PAYLOAD
from ..fit.estimate import Estimate
from .cone import SolverError, solve_cone
from .constraints import PSEUDO_INERTIA, Constraint, KnownMass, PossibleBody
from .result import CONFLICT, Active, Possible, rise_p_value
from .scaling import NOISE_FLOOR, POSSIBLE, ScaledProblem, with_possible


class Tested(NamedTuple):
    """A constraint that holds the estimate back, and how unlikely that is if it is true.

    ``rise``: what it adds to chi2. ``p_value``: probability of as much, at most: by chi-squared (or Fisher's F) of
    as many degrees as the constraint restricts directions.
    """

    constraint: Constraint
    rise: float
    p_value: float

    @property
    def conflict(self) -> bool:
        """Whether it contradicts the data."""
        return self.p_value < CONFLICT


def solve_constrained(estimate: Estimate, constraints: Sequence[Constraint] = POSSIBLE) -> Possible:
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
    values = problem.full(z)
    return Possible(estimate, values, chi2, active, (InertialParameters(values),), status, tuple(constraints))


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


def tested(result: Possible) -> tuple[Tested, ...]:
    """Each active constraint by itself: the rise with all constraints less that without it.

    That a body must exist is not left out; its rise is that which it causes alone.
    """
    found = []
    for constraint in [active.constraint for active in result.active if active.constraint is not None]:
        others = [c for c in result.constraints if c is not constraint]
        if isinstance(constraint, PossibleBody):
            rise, k = solve_constrained(result.free, [constraint]).chi2_rise, len(result.free.names)
        else:
            rise = result.chi2_rise - solve_constrained(result.free, others).chi2_rise
            k = rank(constraint.rows.A)
        p = rise_p_value(max(rise, 0.0), k, result.free.degrees_of_freedom)
        found.append(Tested(constraint, rise, p))
    return tuple(found)


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
