"""From a motion that keeps the limits at its samples to one that keeps them everywhere."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from ..common.arrays import Array
from .limits import excess
from .margins import Margins
from .problem import DesignProblem
from .samples import Samples
from .score import FINER, TOLERANCE, Score, score_samples

WIDTH, FINE_WIDTH = 0.05, 0.01
"""rad/s or m/s: width of the smoothed sign while optimising, and at the end."""
_SAFETY = 1e-3  # of a limit: stays free on the fine grid
_ROOM = 5e-4  # of a limit: for what a motion does between the samples of the fine grid
_BEYOND = 0.2  # of a limit: what misses it by more is not mended by going slower


def settled(problem: DesignProblem, x: Array, limits: Margins) -> bool:
    """Whether the fine grid shows every limit kept; if not, intervals are drawn in around where it is not."""
    fine, coarse = problem.state(x, 0.0, FINER), problem.state(x, FINE_WIDTH)
    nearest = _nearest(coarse.samples, fine.samples)
    kept = True
    for limit, drawn in zip(limits.limits, limits.drawn, strict=True):
        over, here = (excess(limit, limit.values(state)) for state in (fine, coarse))
        if over.max() <= TOLERANCE:
            continue
        kept = False
        worst = np.full(here.shape, -np.inf)
        np.maximum.at(worst, nearest if len(here) > 1 else np.zeros(len(over), dtype=int), over)
        # Between samples a motion goes further by worst - here; what is left is the solver's own error.
        wanted = np.where(worst > 0.0, np.maximum(worst - here, 0.0) + _SAFETY, 0.0)
        again = np.where((worst > 0.0) & (drawn >= wanted), drawn + worst, wanted)
        drawn[...] = np.maximum(drawn, maximum_filter1d(again, 3, axis=0))
    return kept


def _nearest(coarse: Samples, fine: Samples) -> NDArray[np.intp]:
    """Coarse sample within whose time each fine one lies."""
    middle = np.cumsum(fine.weight) - 0.5 * fine.weight
    found = np.searchsorted(np.cumsum(coarse.weight), middle)
    return np.asarray(np.minimum(found, len(coarse.weight) - 1))


def eased_within(problem: DesignProblem, x: Array) -> tuple[Array, Score]:
    """The motion made slower or smaller until there is room between fine samples too, if that helps; its score."""
    score = score_samples(problem, problem.family.sample(x, FINER))
    if score.max_violation > _BEYOND:
        return x, score
    slower, smaller = 1.0, 1.0
    for limit in score.limits:
        if limit.room >= _ROOM:
            continue
        if limit.name == "position":
            smaller = min(smaller, 1.0 / (1.0 + _ROOM - limit.room))
        elif limit.name != "duration":
            slower = max(slower, 1.0 + _ROOM - limit.room)
    if slower == 1.0 and smaller == 1.0:
        return x, score
    eased = problem.family.eased(x, slower, smaller)
    after = score_samples(problem, problem.family.sample(eased, FINER))
    return (eased, after) if after.max_violation <= max(score.max_violation, TOLERANCE) else (x, score)
