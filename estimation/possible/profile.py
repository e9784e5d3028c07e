"""The set of payloads that constraints allow near an estimate, and its farthest points, as cone programs.

The set is all z that hold the constraints with ||R (z - centre)||^2 <= k^2 + q, k the distance of the nearest of
them. Seen from that one, z = nearest + sqrt(q) R^-1 u, the distance says |u|^2 + 2 kappa e'u <= 1 with kappa =
k / sqrt(q) and the unit vector e along R (nearest - centre), or ||(u, kappa e'u)|| <= 1 - kappa e'u. All u are then
within the unit ball, however fine the data are and however far the constraints: the programs stay well scaled. Only
the direction changes from one question to the next, so a solver is set up once.
"""

from functools import cached_property
from typing import Any

import numpy as np

from ...common.arrays import Array
from .cone import TRIANGLE, Cone, SolverError, cone_solver
from .scaling import ScaledProblem


class ProfileSet:
    """Payloads that hold a scaled problem's constraints, little farther from its centre than the nearest one."""

    def __init__(self, problem: ScaledProblem, nearest: Array, q: float) -> None:
        """The set of squared distance up to that of ``nearest`` plus ``q``, in the problem's metric R."""
        self.problem = problem
        self._nearest = nearest
        self._inverse = np.asarray(np.linalg.inv(problem.R), dtype=float)
        self._spread = np.sqrt(q) * self._inverse
        self._pull = problem.R @ (nearest - problem.centre) / np.sqrt(q)  # kappa e
        self._radius = float(np.sqrt(q * (1.0 + self._pull @ self._pull)))

    def farthest(self, c: Array) -> Array:
        """The z of the set with the largest c'z.

        Raises:
            SolverError: for anything but a clean solve.
        """
        direction = c @ self._inverse
        alone = self.problem.centre + self._radius * self._inverse @ direction / np.linalg.norm(direction)
        if self.problem.holds(alone):  # the distance alone decides
            return np.asarray(alone)
        return np.asarray(self._nearest + self._spread @ self._solved(self._points, -direction))

    def largest_ratio(self, c: Array, k: int) -> float:
        """Largest c'z / z_k, for a z_k that is positive in the whole set: linear in z / z_k and 1 / z_k.

        Raises:
            SolverError: for anything but a clean solve.
        """
        moved = np.column_stack([self._spread, self._nearest])
        return float(c @ moved @ self._solved(self._ratios(k), -(c @ moved)))

    @cached_property
    def _points(self) -> "_Region":
        """The set in u."""
        K, cones = self._cones
        return _Region(-K[:, :-1], K[:, -1], cones)

    def _ratios(self, k: int) -> "_Region":
        """The set in (u / z_k, 1 / z_k)."""
        if k not in self._ratio_regions:
            K, cones = self._cones
            unit = np.append(self._spread[k], self._nearest[k])
            right = np.append(1.0, np.zeros(len(K)))
            self._ratio_regions[k] = _Region(np.vstack([unit, -K]), right, [("Zero", 1), *cones])
        return self._ratio_regions[k]

    @cached_property
    def _ratio_regions(self) -> "dict[int, _Region]":
        return {}

    def _solved(self, region: "_Region", cost: Array) -> Array:
        """The point of least cost; a cost of norm 1 is what the solver's tolerances are made for."""
        unit = cost / np.linalg.norm(cost)
        region.solver.update(q=unit)
        solution = region.solver.solve()
        if str(solution.status) != "Solved":
            # About once in 100,000 directions the rows' own scale will not do: begin anew with the solver's.
            solution = region.made(unit).solve()
        if str(solution.status) != "Solved":
            raise SolverError(str(solution.status), self.problem.program())
        return np.asarray(solution.x)

    @cached_property
    def _cones(self) -> tuple[Array, list[Cone]]:
        """K with K (u, 1) in the cones: bounds, distance, pseudo-inertia."""
        problem, n = self.problem, len(self.problem.scale)
        body = TRIANGLE @ problem.select.T
        K = np.vstack(
            [
                np.column_stack([problem.A @ self._spread, problem.A @ self._nearest + problem.b]),
                np.append(-self._pull, 1.0),
                np.eye(n, n + 1),
                np.append(self._pull, 0.0),
                np.column_stack([body @ self._spread, body @ self._nearest]),
            ]
        )
        return K, [("Nonnegative", len(problem.b)), ("SecondOrder", n + 2), ("PSDTriangle", 4)]


class _Region:
    """All x with right - matrix x in the cones, and a solver whose direction changes from question to question."""

    def __init__(self, matrix: Array, right: Array, cones: list[Cone]) -> None:
        self._matrix, self._right, self._cones = matrix, right, cones
        self.solver = self.made(np.zeros(matrix.shape[1]), reused=True)

    def made(self, cost: Array, reused: bool = False) -> Any:
        """A solver for the point of least cost."""
        return cone_solver(cost, self._matrix, self._right, self._cones, reused)
