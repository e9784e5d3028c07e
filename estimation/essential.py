"""Essential parameters: those that the torques show, by backward elimination (section III)."""

import numpy as np

from .estimate import Estimate
from .least_squares import solve_triangle
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
    R = triangular(problem.stacked(estimate.weights))
    effective = sum(problem.effective_rows)
    kept = list(problem.columns)
    last = kept.copy()
    first: float | None = None
    while kept:
        solution = solve_triangle(R, effective)
        error = float(np.linalg.norm(R[len(kept) :, -1]) / np.sqrt(solution.degrees_of_freedom))
        first = error if first is None else first
        if error >= stop * first:
            break
        last = kept.copy()
        with np.errstate(divide="ignore"):
            least = int(np.argmax(np.sqrt(np.diag(solution.covariance)) / np.abs(solution.values)))
        kept.pop(least)
        R = triangular(np.delete(R, least, axis=1))
    return tuple(last)
