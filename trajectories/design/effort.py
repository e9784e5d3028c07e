"""How long a search goes on, and how it descends."""

from dataclasses import dataclass
from typing import NamedTuple

from ..motions.near import FreeNear
from ..motions.via_points import FreeViaPoints
from .problem import DesignProblem
from .score import Score

_MOST = 400  # numbers whose curvature is kept as a matrix


class Effort(NamedTuple):
    """How long a search goes on.

    Attributes:
        first: iterations from a start, shared by the surrogate's orders.
        refined: iterations of each stage after that.
        settled: iterations of each turn of settling.
        stages: of refinement; the last has the fine sign.
        turns: of settling at most.
        by_matrix: whether descents go on from the curvature that the last one has learnt, kept as a matrix.
        gain: of the criterion, a stage that gains less is the last of its kind; None where a better may follow.
    """

    first: int
    refined: int
    settled: int
    stages: int
    turns: int
    by_matrix: bool
    gain: float | None = None


_NEAR, _VIA = Effort(150, 50, 40, 3, 8, True, 2e-3), Effort(100, 100, 50, 2, 14, True)
_FRESH = Effort(160, 150, 60, 4, 8, False)
"""Where each descent learns the curvature anew: many numbers, many minima, or a surrogate that changes."""


def effort_of(problem: DesignProblem) -> Effort:
    """The effort with which motions of a problem's family come out best for the time it takes."""
    family = problem.family
    if family.size <= _MOST and isinstance(family, FreeNear):
        return _NEAR
    if family.size <= _MOST and isinstance(family, FreeViaPoints) and problem.criterion.weighted:
        return _VIA
    return _FRESH


@dataclass
class Worth:
    """Whether stages of a search still gain.

    Attributes:
        gain: a stage that gains less is the last of its kind; None where any may be followed by a better one.
        value: the last motion's criterion; None where it did not keep its limits.
    """

    gain: float | None
    value: float | None = None

    def __call__(self, score: Score) -> bool:
        """Whether to go on: the last motion or this one misses a limit, or this one is clearly better."""
        before, self.value = self.value, score.value if score.feasible else None
        if self.gain is None or before is None or self.value is None:
            return True
        return before - self.value > self.gain
