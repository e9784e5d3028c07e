"""Augmented Lagrangian of limits low <= y <= high (Rockafellar; Nocedal and Wright, chapter 17)."""

from collections.abc import Sequence

import numpy as np

from ..model.arrays import Array
from .limits import Limit, Slopes, State

_SMALL = 0.01  # in the limits' units: smaller violations are left to the multipliers
_SHRINK = 0.3  # what an update should leave of a violation
_STIFFER, _STIFFEST = 4.0, 1e4


class Multipliers:
    """One signed multiplier a value, and intervals drawn in so that the motion keeps the limits between samples.

    Attributes:
        limits: the limits.
        stiffness: weight of squared violations.
        drawn: per limit and value, by how much its interval is drawn in on either side, in the limit's units.
    """

    def __init__(self, limits: Sequence[Limit], state: State, stiffness: float, margin: float) -> None:
        """All multipliers zero."""
        self.limits, self.stiffness = tuple(limits), stiffness
        self.drawn = [np.full(limit.values(state).shape, margin) for limit in self.limits]
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

    def violation(self, state: State) -> float:
        """Largest violation of the drawn-in intervals, in the limits' units."""
        worst = 0.0
        for limit, drawn in zip(self.limits, self.drawn, strict=True):
            y = limit.values(state)
            worst = max(worst, float(np.maximum(y - limit.high + drawn, limit.low + drawn - y).max()))
        return worst

    def _next(self, state: State) -> list[Array]:
        shifted = []
        for limit, drawn, old in zip(self.limits, self.drawn, self._values, strict=True):
            z = old + self.stiffness * limit.values(state)
            low, high = limit.low + drawn, limit.high - drawn
            shifted.append(z - np.clip(z, self.stiffness * low, self.stiffness * high))
        return shifted
