"""Intervals of limits, drawn in so that a motion keeps them between samples."""

from collections.abc import Sequence

import numpy as np

from ..common.arrays import Array
from .limits import Limit, State


class Margins:
    """By how much each limit is drawn in at each value.

    Attributes:
        limits: the limits.
        drawn: per limit and value, by how much its interval is drawn in on either side, in the limit's units.
    """

    def __init__(self, limits: Sequence[Limit], state: State, margin: float) -> None:
        """The same ``margin`` everywhere."""
        self.limits = tuple(limits)
        self.drawn = [np.full(limit.values(state).shape, margin) for limit in self.limits]

    def violation(self, state: State) -> float:
        """Largest violation of the drawn-in intervals, in the limits' units."""
        worst = 0.0
        for limit, drawn in zip(self.limits, self.drawn, strict=True):
            y = limit.values(state)
            worst = max(worst, float(np.maximum(y - limit.high + drawn, limit.low + drawn - y).max()))
        return worst

    def intervals(self) -> list[tuple[Array, Array]]:
        """low and high of each limit's values, drawn in."""
        return [(limit.low + d, limit.high - d) for limit, d in zip(self.limits, self.drawn, strict=True)]
