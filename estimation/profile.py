"""The set of payloads that constraints allow near an estimate, and its farthest points, as cone programs.

z = centre + spread u with |u| <= 1: the ball keeps the program well scaled however fine the data are. Only the
direction changes from one question to the next, so the solver is set up once.
"""

from functools import cached_property
from typing import Any

import numpy as np

from ..model.arrays import Array
from .cone import TRIANGLE, SolverError, settings, sparse
from .scaling import ScaledProblem


class ProfileSet:
    """All z = centre + spread u, |u| <= 1, of a scaled problem that hold its constraints."""

    def __init__(self, problem: ScaledProblem, radius: float) -> None:
        """The set within ``radius`` of the problem's centre, a distance by its R."""
        self.problem = problem
        self._spread = np.asarray(radius * np.linalg.inv(problem.R), dtype=float)

    def farthest(self, c: Array) -> Array:
        """The z of the set with the largest c'z.

        Raises:
            SolverError: for anything but a clean solve.
        """
        direction = c @ self._spread
        ball = self.problem.centre + self._spread @ direction / np.linalg.norm(direction)
        if self.problem.holds(ball):  # the distance alone decides
            return np.asarray(ball)
        return np.asarray(self.problem.centre + self._spread @ self._solved(self._points, -direction))

    def largest_ratio(self, c: Array, k: int) -> float:
        """Largest c'z / z_k, for a z_k that is positive in the whole set: linear in z / z_k and 1 / z_k.

        Raises:
            SolverError: for anything but a clean solve.
        """
        moved = np.column_stack([self._spread, self.problem.centre])
        return float(c @ moved @ self._solved(self._ratios(k), -(c @ moved)))

    @cached_property
    def _points(self) -> Any:
        """Solver in u."""
        K, cones = self._cones
        return _solver(-K[:, :-1], K[:, -1], cones)

    def _ratios(self, k: int) -> Any:
        """Solver in (u / z_k, 1 / z_k)."""
        if k not in self._ratio_solvers:
            import clarabel

            K, cones = self._cones
            unit = np.append(self._spread[k], self.problem.centre[k])
            right = np.append(1.0, np.zeros(len(K)))
            self._ratio_solvers[k] = _solver(np.vstack([unit, -K]), right, [clarabel.ZeroConeT(1), *cones])
        return self._ratio_solvers[k]

    @cached_property
    def _ratio_solvers(self) -> dict[int, Any]:
        return {}

    def _solved(self, solver: Any, cost: Array) -> Array:
        """The point of least cost; a cost of norm 1 is what the solver's tolerances are made for."""
        solver.update(q=cost / np.linalg.norm(cost))
        solution = solver.solve()
        if str(solution.status) != "Solved":
            raise SolverError(str(solution.status), self.problem.program())
        return np.asarray(solution.x)

    @cached_property
    def _cones(self) -> tuple[Array, list[Any]]:
        """K with K (u, 1) in the cones: bounds, |u| <= 1, pseudo-inertia."""
        import clarabel

        problem, n = self.problem, len(self.problem.scale)
        body = TRIANGLE @ problem.select.T
        K = np.vstack(
            [
                np.column_stack([problem.A @ self._spread, problem.A @ problem.centre + problem.b]),
                np.append(np.zeros(n), 1.0),
                np.eye(n, n + 1),
                np.column_stack([body @ self._spread, body @ problem.centre]),
            ]
        )
        bounds = [clarabel.NonnegativeConeT(len(problem.b))] if len(problem.b) else []
        return K, [*bounds, clarabel.SecondOrderConeT(n + 1), clarabel.PSDTriangleConeT(4)]


def _solver(matrix: Array, right: Array, cones: list[Any]) -> Any:
    """A solver for right - matrix x in the cones, its direction still zero."""
    import clarabel
    from scipy.sparse import csc_matrix

    size = matrix.shape[1]
    return clarabel.DefaultSolver(
        csc_matrix((size, size)), np.zeros(size), sparse(matrix), right, cones, settings(reused=True)
    )
