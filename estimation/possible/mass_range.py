"""What the data allow of the masses of links that can exist: the least and the largest, of each link and of all.

Standard parameters x of a robot that can exist are allowed if chi2 of their base parameters rises by no more than
t^2 above the constrained minimum, t Student's 97.5 % point: a mass alone is then in its 95 % profile interval.
"""

from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model import BaseParameters, Robot
from ..fit.estimate import Estimate, error_model
from ..fit.robust import student95
from .cone import TRIANGLE, Cone, SolverError, cone_solver
from .robot import RobotProgram, solve_robot_program

Range = tuple[float, float]
"""Least and largest; infinite where nothing bounds it."""
_CLOSED = 1000.0
"""kg: the sum of the masses in the program, far above any arm's, so that its set is bounded."""
_LARGEST = 1e3
"""Entries of the whitened equations are scaled down to this."""
_DIGITS = 1e-6
"""kg: less is the solver's rounding."""


class MassRanges(NamedTuple):
    """Masses [kg] that the data allow: of all moving links together, and of each, base to tip."""

    total: Range
    links: tuple[Range, ...]


def mass_ranges(robot: Robot, base: BaseParameters, estimate: Estimate) -> MassRanges:
    """Least and largest masses of links that can exist, within the 95 % interval of the data.

    Args:
        robot: the robot.
        base: its base parameters.
        estimate: of all of them, in their order.

    Raises:
        InputError: if the estimate is not of these parameters.
        SolverError: if the solver finds no answer.
    """
    estimate = error_model(estimate)
    problem = RobotProgram.of(robot, base, estimate, None)
    nearest = solve_robot_program(problem, base, estimate)
    places = [base.standard.index(f"M{link}") for link in range(1, robot.n + 1)]
    unit = float(problem.scale[places[0]])
    radius = float(np.sqrt(nearest.chi2_rise + student95(estimate.degrees_of_freedom) ** 2))
    matrix, right, cones = _allowed(problem, places, _CLOSED / unit, radius)

    def least(cost: Array) -> float:
        solution = cone_solver(cost, matrix, right, cones).solve()
        if str(solution.status) not in ("Solved", "AlmostSolved"):
            raise SolverError(str(solution.status), problem.program)
        return float(cost @ np.asarray(solution.x)) * unit

    units = np.eye(len(problem.scale))[places]
    ranges = [_range(least(unit_mass), -least(-unit_mass)) for unit_mass in (units.sum(axis=0), *units)]
    return MassRanges(ranges[0], tuple(ranges[1:]))


def _range(low: float, high: float) -> Range:
    return (low if low > _DIGITS else 0.0, high if high < 0.5 * _CLOSED else np.inf)


def _allowed(
    problem: RobotProgram, masses: list[int], closed: float, radius: float
) -> tuple[Array, Array, list[Cone]]:
    """Matrix, right-hand side and cones of the z within ``radius`` whose masses add up to ``closed`` at most."""
    F, d, A, b, bodies = problem.program
    (k, n), p = F.shape, len(bodies)
    sum_of_masses = np.zeros(n)
    sum_of_masses[masses] = 1.0
    scale = max(1.0, float(np.abs(F).max()) / _LARGEST)
    matrix = np.vstack(
        [-A, sum_of_masses, np.zeros(n), -F / scale, -(TRIANGLE @ bodies).reshape(10 * p, n)],
    )
    right = np.concatenate([b, [closed, radius / scale], -d / scale, np.zeros(10 * p)])
    links: list[Cone] = [("PSDTriangle", 4)] * p
    return matrix, right, [("Nonnegative", len(A) + 1), ("SecondOrder", k + 1), *links]
