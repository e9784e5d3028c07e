"""Standard parameters of a robot that can exist: those nearest to a prior that the data allow.

Data speak only of base parameters; of all robots that explain them about as well, the one whose links are nearest
to a prior in entropic distance is one definite answer. The weight of the distance is chosen so that chi2 rises by a
stated budget above that of the nearest robot that can exist: the prior never costs more than that.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..model import BaseParameters, InputError, Robot
from ..model.arrays import Array, frozen_array
from .cone import ConeProgram, SolverError, solve_cone
from .constrained_base import ConstrainedBase, Holding, RobotProgram, solve_robot_program
from .constraints import MassBounds
from .entropic import EntropicSolution, distances, nearest_within, pseudo_inertias, whitened_bodies
from .estimate import Estimate
from .origins import Origin, origins
from .robot_prior import RobotPrior
from .scaling import TOLERANCE, rise_p_value

BUDGET = 1.0
"""By which chi2 may rise above the constrained minimum."""
_MET = 1e-8
"""Of the budget: how exactly it is met."""
_ROUNDS = 5


@dataclass(frozen=True)
class ConstrainedRobot:
    """Standard parameters of a robot that can exist, data first, then a prior.

    Attributes:
        nearest: the base gauge: base parameters of the nearest robot that can exist, and the free estimate.
        prior: what the links were thought to be.
        budget: by which chi2 was allowed to rise above ``nearest.chi2_rise``.
        weight: of the entropic distance; infinite where the prior itself is within the budget.
        parameters: all standard parameters by name. Those that are not identified are the prior's choice.
        origins: who decides each of them.
        values: base parameters, in the order of ``nearest.free.names``.
        chi2_rise: squared distance from the free base parameters by their covariance.
        distances: entropic distance of each link from its prior.
        active: rules of drives and mass that hold the estimate back, largest multiplier first.
        min_eigenvalues: smallest eigenvalue of each link's pseudo-inertia; all are positive.
        status: "Solved", or "prior" where the prior itself is within the budget.
    """

    nearest: ConstrainedBase
    prior: RobotPrior
    budget: float
    weight: float
    parameters: dict[str, float]
    origins: dict[str, Origin]
    values: Array
    chi2_rise: float
    distances: tuple[float, ...]
    active: tuple[Holding, ...]
    min_eigenvalues: tuple[float, ...]
    status: str

    def __post_init__(self) -> None:
        """Lock the values."""
        object.__setattr__(self, "values", frozen_array(self.values, (None,), "base parameters"))

    @property
    def free(self) -> Estimate:
        """The unconstrained estimate."""
        return self.nearest.free

    @cached_property
    def p_value(self) -> float:
        """As for ``ConstrainedEstimate``, of the whole rise, budget included."""
        return rise_p_value(self.chi2_rise, len(self.free.names), self.free.degrees_of_freedom)


def solve_constrained_prior(
    robot: Robot,
    base: BaseParameters,
    estimate: Estimate,
    prior: RobotPrior,
    budget: float = BUDGET,
    total_mass: MassBounds | None = None,
) -> ConstrainedRobot:
    """The robot nearest to a prior among those that explain the data within a budget.

    Links can exist, and drives hold the rules of ``solve_constrained_base``; the distance is that of the links
    alone.

    Args:
        robot: the robot.
        base: its base parameters.
        estimate: of all of them, in their order.
        prior: one body for each link.
        budget: by which chi2 may rise above the constrained minimum.
        total_mass: bounds of the mass of all links together, where known.

    Raises:
        InputError: if the estimate or the prior are not of this robot, or the budget is not positive.
        SolverError: for anything but a clean solve.
    """
    if len(prior.bodies) != robot.n:
        raise InputError(f"a prior of {len(prior.bodies)} links for the {robot.n} of {robot.name}: give one each")
    if not 0.0 < budget < np.inf:
        raise InputError(f"budget {budget:g} of the prior must be positive: 1 is one standard deviation")
    problem = RobotProgram.of(robot, base, estimate, total_mass)
    nearest = solve_robot_program(problem, base, estimate)
    z0 = _prior_point(problem, prior)
    P0 = pseudo_inertias(problem.program, z0)
    limit = nearest.chi2_rise + budget
    found, weight, status = _prior_itself(problem, z0, limit), np.inf, "prior"
    active: tuple[Holding, ...] = ()
    if found is None:
        solution = nearest_within(problem.program, P0, limit)
        found, weight, status = solution.z, solution.weight, "Solved"
        active = _active(problem, solution)
    z = problem.repaired(found)
    if status == "Solved":
        z = problem.repaired(_on_budget(problem, z, limit, budget))
    x = z * problem.scale
    values = base.grouping @ x
    return ConstrainedRobot(
        nearest=nearest,
        prior=prior,
        budget=budget,
        weight=weight,
        parameters={name: float(value) for name, value in zip(base.standard, x, strict=True)},
        origins=origins(robot, base),
        values=values,
        chi2_rise=float(np.sum((problem.R @ (values - estimate.values)) ** 2)),
        distances=tuple(float(distance) for distance in distances(problem.program, P0, z)),
        active=active,
        min_eigenvalues=problem.min_eigenvalues(z),
        status=status,
    )


def _prior_point(problem: RobotProgram, prior: RobotPrior) -> Array:
    """The prior's links in scaled parameters; drives are zero."""
    z = np.zeros(len(problem.scale))
    for link, body in zip(problem.links, prior.bodies, strict=True):
        z[link] = body.vector / problem.scale[link]
    return z


def _prior_itself(problem: RobotProgram, z0: Array, limit: float) -> Array | None:
    """The prior's links with the drives that suit them best, if that is within the limit."""
    F, d, A, b, bodies = problem.program
    drives = [k for k in range(len(z0)) if k not in {place for link in problem.links for place in link}]
    shift = A @ z0 + b
    rows = np.abs(A[:, drives]).max(axis=1, initial=0.0) > 0.0
    if (shift[~rows] < -TOLERANCE).any():
        return None  # the prior breaks a bound of the mass
    z = z0.copy()
    if drives:
        part = ConeProgram(F[:, drives], d - F @ z0, A[np.ix_(rows, drives)], shift[rows], bodies[:0, :, drives])
        z[drives] = solve_cone(part, 1e3).z
        signed = list(problem.rules.signed)
        z[signed] = np.maximum(z[signed], 0.0)
    return z if float(np.sum((F @ z - d) ** 2)) <= limit else None


def _on_budget(problem: RobotProgram, z: Array, limit: float, budget: float) -> Array:
    """z with the solver's rounding in chi2 taken out, by the change nearest in the metric of the distance.

    Raises:
        SolverError: if that is more than rounding.
    """
    F, d = problem.program[:2]
    start = float(np.sum((F @ z - d) ** 2))
    for _ in range(_ROUNDS):
        error = F @ z - d
        chi2 = float(error @ error)
        if abs(chi2 - limit) <= _MET * budget:
            return z
        S = _metric(problem, z)
        across = np.linalg.solve(S, F.T)
        z = z - (1.0 - np.sqrt(limit / chi2)) * across @ np.linalg.solve(F @ across, error)
    raise SolverError(f"chi2 {start:.6g} misses its bound {limit:.6g} by more than rounding", problem.program)


def _metric(problem: RobotProgram, z: Array) -> Array:
    """Second derivative of the links' entropic distance; of what must not be negative its logarithm's."""
    S = np.eye(len(z))
    signed = list(problem.rules.signed)
    S[signed, signed] = 1.0 / np.maximum(z[signed], 1e-9) ** 2
    M = whitened_bodies(problem.program, pseudo_inertias(problem.program, z)).reshape(-1, len(z))
    places = [place for link in problem.links for place in link]
    S[np.ix_(places, places)] = (M.T @ M)[np.ix_(places, places)]
    return S


def _active(problem: RobotProgram, solution: EntropicSolution) -> tuple[Holding, ...]:
    slack = problem.rules.A @ solution.z + problem.rules.b
    found = [
        Holding(text, float(price))
        for text, price, room in zip(problem.rules.texts, solution.multipliers, slack, strict=True)
        if price > max(room, TOLERANCE)
    ]
    return tuple(sorted(found, key=lambda holding: -holding.multiplier))
