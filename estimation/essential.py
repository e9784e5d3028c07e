"""Essential parameters: those that the torques show, by backward elimination (section III)."""

import numpy as np

from ..model.arrays import Array
from .estimate import Estimate
from .least_squares import solve
from .problem import ReducedProblem, triangular

STOP_RATIO = 1.02


def essential_parameters(problem: ReducedProblem, estimate: Estimate, stop: float = STOP_RATIO) -> tuple[str, ...]:
    """Names that remain after the least certain ones have been cancelled, one at a time.

    At each step the parameter with the largest relative standard deviation goes; the procedure ends before
    the error's standard deviation reaches ``stop`` times that of all parameters.

    Args:
        problem: the problem that was solved.
        estimate: its weighted estimate; the weights stay as they are.
        stop: ratio of error standard deviations at which to stop.
    """
    factor = triangular(problem.stacked(estimate.weights))
    kept = list(problem.columns)
    rows, effective = problem.equations, sum(problem.effective_rows)
    first: float | None = None
    last: list[str] = kept.copy()
    while kept:
        places = [problem.columns.index(name) for name in kept]
        solution = solve(factor[:, [*places, -1]], tuple(kept), rows, effective)
        error = _error(factor, places, solution.values) / np.sqrt(solution.degrees_of_freedom)
        first = error if first is None else first
        if error >= stop * first:
            break
        last = kept.copy()
        sigma = np.sqrt(np.diag(solution.covariance))
        with np.errstate(divide="ignore"):
            kept.pop(int(np.argmax(sigma / np.abs(solution.values))))
    return tuple(last)


def _error(factor: Array, places: list[int], values: Array) -> float:
    return float(np.linalg.norm(factor[:, -1] - factor[:, places] @ values))
