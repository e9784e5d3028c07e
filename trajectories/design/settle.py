"""Keeping the limits: an augmented Lagrangian whose intervals are drawn in until the fine grid shows none missed.

Augmented Lagrangian of limits low <= y <= high: Rockafellar; Nocedal and Wright, chapter 17.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ..motions.samples import Samples
from .limits import Limit, State, excess
from .problem import DesignProblem
from .score import FINER, TOLERANCE, Score, score_samples

WIDTH, FINE_WIDTH = 0.05, 0.01
"""rad/s or m/s: width of the smoothed sign while optimising, and at the end."""
_SAFETY = 1e-3  # of a limit: stays free on the fine grid
_ROOM = 5e-4  # of a limit: for what a motion does between the samples of the fine grid
_BEYOND = 0.2  # of a limit: what misses it by more is not mended by going slower
_EASES, _MORE = 14, 1.5  # each so many times as much as the last
_SMALL = 0.01  # in the limits' units: smaller violations are left to the multipliers
_SHRINK = 0.3  # what an update should leave of a violation
_STIFFER, _STIFFEST = 4.0, 1e4


class Multipliers:
    """One signed multiplier a value, and intervals drawn in so that the motion keeps the limits between samples.

    Attributes:
        drawn: per limit and value, by how much its interval is drawn in on either side, in the limit's units.
        stiffness: weight of squared violations.
    """

    def __init__(self, limits: Sequence[Limit], state: State, stiffness: float, margin: float) -> None:
        """All multipliers zero, all intervals drawn in by the same ``margin``."""
        self.limits, self.stiffness = tuple(limits), stiffness
        shapes = [limit.values(state).shape for limit in self.limits]
        self.drawn = [np.full(shape, margin) for shape in shapes]
        self._values = [np.zeros(shape) for shape in shapes]
        self._last = 0.0

    def __call__(self, state: State, into: State) -> float:
        """Value of the terms; their slopes are added to ``into``."""
        total = 0.0
        for limit, old, new in zip(self.limits, self._values, self._next(state), strict=True):
            total += float((new**2).sum() - (old**2).sum()) / (2.0 * self.stiffness)
            if new.any():
                limit.pullback(state, new, into)
        return total

    def update(self, state: State) -> None:
        """First-order update at a minimum; violations that do not shrink are weighted more from then on."""
        self._values = self._next(state)
        violation = self.violation(state)
        if violation > max(_SMALL, _SHRINK * self._last):
            self.stiffness = min(_STIFFER * self.stiffness, _STIFFEST)
        self._last = violation

    def violation(self, state: State) -> float:
        """Largest violation of the drawn-in intervals, in the limits' units."""
        worst = 0.0
        for limit, drawn in zip(self.limits, self.drawn, strict=True):
            worst = max(worst, float((excess(limit, limit.values(state)) + drawn).max()))
        return worst

    def settle(self, problem: DesignProblem, x: Array) -> bool:
        """Whether the fine grid shows every limit kept; if not, intervals are drawn in around where it is not."""
        fine, coarse = problem.state(x, 0.0, FINER), problem.state(x, FINE_WIDTH)
        nearest = _nearest(coarse.samples, fine.samples)
        all_kept = True
        for limit, drawn in zip(self.limits, self.drawn, strict=True):
            over, here = (excess(limit, limit.values(state)) for state in (fine, coarse))
            if over.max() <= TOLERANCE:
                continue
            all_kept = False
            worst = np.full(here.shape, -np.inf)
            np.maximum.at(worst, nearest if len(here) > 1 else np.zeros(len(over), dtype=int), over)
            # Between samples a motion goes further by worst - here; what is left is the solver's own error.
            needed = np.where(worst > 0.0, np.maximum(worst - here, 0.0) + _SAFETY, 0.0)
            again = np.where((worst > 0.0) & (drawn >= needed), drawn + worst, needed)
            drawn[...] = np.maximum(drawn, _with_neighbours(again))
        return all_kept

    def _next(self, state: State) -> list[Array]:
        shifted = []
        for limit, drawn, old in zip(self.limits, self.drawn, self._values, strict=True):
            z = old + self.stiffness * limit.values(state)
            low, high = limit.low + drawn, limit.high - drawn
            shifted.append(z - np.clip(z, self.stiffness * low, self.stiffness * high))
        return shifted


def _with_neighbours(values: Array) -> Array:
    """Largest of each sample's value and its neighbours', per column."""
    padded = np.pad(values, ((1, 1), (0, 0)), mode="edge")
    return np.asarray(np.maximum(values, np.maximum(padded[:-2], padded[2:])))


def _nearest(coarse: Samples, fine: Samples) -> NDArray[np.intp]:
    """Coarse sample within whose time each fine one lies."""
    middle = np.cumsum(fine.weight) - 0.5 * fine.weight
    place = np.searchsorted(np.cumsum(coarse.weight), middle)
    return np.asarray(np.minimum(place, len(coarse.weight) - 1))


def eased_within(problem: DesignProblem, x: Array) -> tuple[Array, Score]:
    """The motion made slower or smaller until there is room between fine samples too, if that helps; its score."""
    score = score_samples(problem, problem.family.sample(x, FINER))
    if score.max_violation > _BEYOND:
        return x, score
    slower, smaller = _overstepped(score)
    if slower == 1.0 and smaller == 1.0:
        return x, score
    eased = problem.family.eased(x, slower, smaller)
    after = score_samples(problem, problem.family.sample(eased, FINER))
    return (eased, after) if after.max_violation <= max(score.max_violation, TOLERANCE) else (x, score)


def drawn_back(problem: DesignProblem, x: Array) -> Array:
    """The motion slower and smaller by more and more until it keeps all limits; as it is where that never does."""
    slower, smaller = _overstepped(score_samples(problem, problem.family.sample(x, FINER)))
    for ease in range(_EASES):
        times = _MORE**ease
        eased = problem.family.eased(x, 1.0 + times * (slower - 1.0), smaller**times)
        if score_samples(problem, problem.family.sample(eased, FINER)).feasible:
            return eased
    return x


def _overstepped(score: Score) -> tuple[float, float]:
    """How many times slower and smaller a motion would have to be if all that it misses went with its size."""
    slower, smaller = 1.0, 1.0
    for limit in score.limits:
        if limit.room >= _ROOM:
            continue
        if limit.name == "position":
            smaller = min(smaller, 1.0 / (1.0 + _ROOM - limit.room))
        elif limit.name != "duration":
            slower = max(slower, 1.0 + _ROOM - limit.room)
    return slower, smaller
