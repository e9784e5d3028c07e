"""The state of a search for a motion: the best so far, and how far it has come."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..common.arrays import Array
from .margins import Margins
from .problem import DesignProblem
from .score import Score
from .settle import WIDTH, eased_within

MARGIN = 0.01
"""Of a limit, between samples; the settling adapts it."""
_ASTRAY = 0.1  # in the limits' units: what violates more after the first look seldom comes back


class Step(NamedTuple):
    """Where the solver is.

    Attributes:
        text: what was done.
        best: criterion of the best motion so far that keeps all limits; None before there is one.
        evaluations: of criterion and gradient.
    """

    text: str
    best: float | None
    evaluations: int


@dataclass
class Search:
    """The best motion so far.

    Attributes:
        problem: what was asked.
        draw: random numbers of the starts.
        starts: number of random starts.
        progress: called after each stage.
        evaluations: of criterion and gradient.
        best: the motion and its score.
    """

    problem: DesignProblem
    draw: np.random.Generator
    starts: int
    progress: Callable[[Step], None]
    evaluations: int = 0
    best: tuple[Array, Score] | None = None

    def random(self) -> Array:
        """A motion to start from."""
        return self.problem.family.random(self.draw, self.problem.clear)

    def consider(self, x: Array, text: str) -> None:
        """Judge a motion, made slower or smaller if that is enough to keep the limits; remember the best."""
        x, score = eased_within(self.problem, x)
        if self.best is None or _rank(score) < _rank(self.best[1]):
            self.best = (x, score)
        kept = self.best[1]
        self.progress(Step(text, kept.value if kept.feasible else None, self.evaluations))

    def astray(self, x: Array, margins: Margins) -> bool:
        """Whether a motion misses its limits by so much that another start is better."""
        return margins.violation(self.problem.state(x, WIDTH)) > _ASTRAY


def _rank(score: Score) -> tuple[float, float]:
    """Feasible motions by their value, the others after them by what they miss."""
    return (0.0, score.value) if score.feasible else (score.max_violation, score.value)
