"""Augmented Lagrangian of limits low <= y <= high (Rockafellar; Nocedal and Wright, chapter 17)."""

from collections.abc import Sequence

import numpy as np

from ..common.arrays import Array
from .limits import Limit, Slopes, State
from .margins import Margins

_SMALL = 0.01  # in the limits' units: smaller violations are left to the multipliers
_SHRINK = 0.3  # what an update should leave of a violation
_STIFFER, _STIFFEST = 4.0, 1e4


class Multipliers(Margins):
    """One signed multiplier a value, and intervals drawn in so that the motion keeps the limits between samples.

    Attributes:
        stiffness: weight of squared violations.
    """

    def __init__(self, limits: Sequence[Limit], state: State, stiffness: float, margin: float) -> None:
        """All multipliers zero."""
        super().__init__(limits, state, margin)
        self.stiffness = stiffness
        self._values = [np.zeros(limit.values(state).shape) for limit in self.limits]
        self._last = 0.0

    def add(self, state: State, into: Slopes) -> float:
        """The terms' value; their slopes are added to ``into``."""
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

    def _next(self, state: State) -> list[Array]:
        shifted = []
        for limit, (low, high), old in zip(self.limits, self.intervals(), self._values, strict=True):
            z = old + self.stiffness * limit.values(state)
            shifted.append(z - np.clip(z, self.stiffness * low, self.stiffness * high))
        return shifted
