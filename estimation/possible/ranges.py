"""What the data allow of numbers that they do not determine alone: the least and the largest of each.

Standard parameters x of a robot that can exist are allowed if chi2 of their base parameters rises by no more than
t^2 above the constrained minimum, t Student's 97.5 % point: a number alone is then in its 95 % profile interval.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model import BaseParameters, Robot
from ...model.names import parameter_kind
from ..fit.estimate import Estimate, error_model
from ..fit.robust import student95
from .cone import TRIANGLE, Cone, SolverError, cone_solver
from .origin import origins
from .robot import RobotProgram, solve_robot_program
from .robot_rules import typical_length

Range = tuple[float, float]
"""Least and largest; infinite where nothing bounds it."""
CLOSED = 1000.0
"""kg: what the links weigh together at most, far above any arm; so that the set is bounded, half the traces of
their inertias over the square of a link's length count as mass too."""
_LARGEST = 1e3
"""Entries of the whitened equations are scaled down to this."""
_ROUNDING = 1e-6
"""kg, or in the size of a parameter: less is the solver's rounding."""
_OPEN = 0.1
"""A number has no bound if it grows by this share of the growth of ``CLOSED``: linear is 1, as a root is 0.5."""


class Ranges(NamedTuple):
    """What the data allow: of the mass of all moving links together, and of each standard parameter by name."""

    total: Range
    parameters: dict[str, Range]


def parameter_ranges(
    robot: Robot, base: BaseParameters, estimate: Estimate, names: Sequence[str] | None = None
) -> Ranges:
    """Least and largest numbers of links that can exist, within the 95 % interval of the data.

    Args:
        estimate: of all of them, in their order.
        names: of standard parameters; all that the data do not determine alone without it.

    Raises:
        InputError: if the estimate is not of these parameters.
        SolverError: if the solver finds no answer.
    """
    if names is None:
        names = [name for name, origin in origins(robot, base).items() if origin.kind != "identified"]
    allowed = _Allowed.of(robot, base, error_model(estimate))
    places = [base.standard.index(name) for name in names]
    return Ranges(allowed.range(allowed.masses), dict(zip(names, map(allowed.range_of, places), strict=True)))


class _Allowed(NamedTuple):
    """The z that are allowed, of links with ``masses`` that are not above ``CLOSED``, the row ``closing``."""

    problem: RobotProgram
    masses: Array
    matrix: Array
    right: Array
    cones: list[Cone]
    closing: int

    @staticmethod
    def of(robot: Robot, base: BaseParameters, estimate: Estimate) -> "_Allowed":
        problem = RobotProgram.of(robot, base, estimate, None)
        nearest = solve_robot_program(problem, base, estimate)
        F, d, A, b, bodies = problem.program
        (k, n), p = F.shape, len(bodies)
        masses, inertias = (_sum_of(problem, base, kinds) for kinds in (("M",), ("XX", "YY", "ZZ")))
        unit = float(masses.max())
        radius = float(np.sqrt(nearest.chi2_rise + student95(estimate.degrees_of_freedom) ** 2))
        scale = max(1.0, float(np.abs(F).max()) / _LARGEST)
        matrix = np.vstack(
            [
                -A,
                (masses + inertias / (2.0 * typical_length(robot) ** 2)) / unit,
                np.zeros(n),
                -F / scale,
                -(TRIANGLE @ bodies).reshape(10 * p, n),
            ],
        )
        right = np.concatenate([b, [CLOSED / unit, radius / scale], -d / scale, np.zeros(10 * p)])
        links: list[Cone] = [("PSDTriangle", 4)] * p
        cones: list[Cone] = [("Nonnegative", len(A) + 1), ("SecondOrder", k + 1), *links]
        return _Allowed(problem, masses, matrix, right, cones, len(A))

    def range_of(self, place: int) -> Range:
        """Range of the standard parameter in a place."""
        unit = np.zeros(len(self.masses))
        unit[place] = self.problem.scale[place]
        return self.range(unit)

    def range(self, number: Array) -> Range:
        """Range of a weighted sum of z."""
        return self._least(number), -self._least(-number)

    def _least(self, number: Array) -> float:
        """The least; minus infinity if only ``CLOSED`` bounds it, zero if less than rounding."""
        size = float(np.abs(number).max())
        solution = cone_solver(number / size, self.matrix, self.right, self.cones).solve()
        if str(solution.status) not in ("Solved", "AlmostSolved"):
            raise SolverError(str(solution.status), self.problem.program)
        least = float(number @ np.asarray(solution.x)) / size
        if float(solution.z[self.closing]) * float(self.right[self.closing]) > max(_OPEN * abs(least), _ROUNDING):
            return -np.inf
        return least * size if abs(least) > _ROUNDING else 0.0


def _sum_of(problem: RobotProgram, base: BaseParameters, kinds: Sequence[str]) -> Array:
    """Weights of z in the sum of all parameters of some kinds."""
    return np.where([parameter_kind(name) in kinds for name in base.standard], problem.scale, 0.0)
