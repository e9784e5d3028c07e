"""From a motion that keeps the limits at its samples to one that keeps them everywhere."""

import numpy as np

from ..model.arrays import Array
from .lagrangian import Multipliers
from .limits import excess
from .problem import DesignProblem
from .score import FINER, TOLERANCE, Score, score_samples

_SAFETY = 5e-4  # of a limit: stays free on the fine grid


def settled(problem: DesignProblem, x: Array, limits: Multipliers) -> bool:
    """Whether the fine grid shows every limit kept; if not, intervals are drawn in where it is not."""
    fine, coarse = problem.state(x, 0.0, FINER), problem.state(x, 0.0)
    kept = True
    for limit, drawn in zip(limits.limits, limits.drawn, strict=True):
        over = excess(limit, limit.values(fine)).max(axis=0)
        here = excess(limit, limit.values(coarse)).max(axis=0)
        if (over > TOLERANCE).any():
            kept = False
            # Between samples a motion goes further by over - here; what is left is the solver's own error.
            wanted = np.maximum(over - here, 0.0) + np.maximum(over, 0.0) + _SAFETY
            drawn[...] = np.where(over > 0.0, np.maximum(drawn + 0.5 * np.maximum(over, 0.0), wanted), drawn)
    return kept


def eased_within(problem: DesignProblem, x: Array) -> tuple[Array, Score]:
    """The motion made slower or smaller by what it oversteps its limits, if that mends it; and its score."""
    score = score_samples(problem, problem.family.sample(x, FINER))
    if score.feasible or score.max_violation > 0.2:
        return x, score
    slower, smaller = 1.0, 1.0
    for limit in score.limits:
        if limit.name == "position":
            smaller = min(smaller, 1.0 / (1.0 + limit.relative + _SAFETY))
        elif limit.relative > 0.0:
            slower = max(slower, 1.0 + limit.relative + _SAFETY)
    eased = problem.family.eased(x, slower, smaller)
    after = score_samples(problem, problem.family.sample(eased, FINER))
    return (eased, after) if after.max_violation < score.max_violation else (x, score)
