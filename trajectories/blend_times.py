"""Times of a motion with blends as free numbers: whatever they are, every blend fits into its moves."""

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..common.arrays import Array

_STRAIGHT = 0.02  # of a fixed move's time: what blends leave at constant speed, at least
_SHORTEST = 0.05  # of the longest blend that fits between fixed times


class Times(NamedTuple):
    """Seconds at constant speed in each of the moves, (count - 1,), and in each point's blend, (count,)."""

    straight: Array
    blends: Array

    @property
    def between(self) -> Array:
        """From the middle of one blend to the middle of the next [s], shape (count - 1,)."""
        return np.asarray(self.straight + 0.5 * (self.blends[:-1] + self.blends[1:]))

    @property
    def durations(self) -> Array:
        """The same, the first from the start and the last to the end [s]."""
        durations = self.between
        durations[0] += 0.5 * self.blends[0]
        durations[-1] += 0.5 * self.blends[-1]
        return durations


class TimeSlopes(NamedTuple):
    """Derivatives of times in z, as far as they are not zero.

    Attributes:
        in_straight, in_blends: which entries of z each time depends on, (count - 1, ...) and (count, ...).
        straight, blends: the derivatives in them.
    """

    in_straight: NDArray[np.intp]
    straight: Array
    in_blends: NDArray[np.intp]
    blends: Array


class BlendTimes(Protocol):
    """Times that depend on a vector z.

    Attributes:
        low, high: bounds of z.
    """

    low: Array
    high: Array

    def of(self, z: Array) -> Times:
        """The times."""

    def slopes(self, z: Array) -> TimeSlopes:
        """Their derivatives."""


class FreeTimes:
    """z holds the logs of the times at constant speed, then those of the blends.

    Bounds are such that every move takes at least the shortest and at most the longest duration.
    """

    def __init__(self, count: int, durations: tuple[float, float]) -> None:
        """``count`` points; shortest and longest of the ``durations`` of a move [s]."""
        self._moves = count - 1
        ends = np.ones(count)
        ends[[0, -1]] = 0.5  # the first and last move hold a whole ramp and half a blend
        shortest, longest = durations
        self.low = np.log(shortest * np.concatenate([np.full(count - 1, 0.2), 0.8 * ends]))
        self.high = np.log(longest * np.concatenate([np.full(count - 1, 0.5), 0.5 * ends]))

    def of(self, z: Array) -> Times:
        """Exponentials."""
        times = np.exp(z)
        return Times(times[: self._moves], times[self._moves :])

    def slopes(self, z: Array) -> TimeSlopes:
        """Each depends on its own entry."""
        own, times = np.arange(len(z))[:, None], np.exp(z)[:, None]
        return TimeSlopes(own[: self._moves], times[: self._moves], own[self._moves :], times[self._moves :])


class FixedTimes:
    """The moves' durations are given; z holds each blend's share of the longest that fits.

    No blend goes beyond the middle of a move, so that any two fit.
    """

    def __init__(self, durations: Array) -> None:
        """``durations`` of the moves as ``BlendedPoints`` counts them [s], shape (count - 1,)."""
        self._durations = durations
        inner = np.minimum(durations[:-1], durations[1:])
        self._longest = np.concatenate([[0.5 * durations[0]], inner, [0.5 * durations[-1]]])
        self._before, self._after = (np.full(len(durations), 0.5) for _ in range(2))
        self._before[0] = self._after[-1] = 1.0  # of a blend in its move: the ramps from and to rest are whole
        self.low, self.high = (np.full(len(self._longest), share) for share in (_SHORTEST, 1.0 - _STRAIGHT))

    def of(self, z: Array) -> Times:
        """What blends leave of each move is at constant speed."""
        blends = self._longest * z
        return Times(self._durations - self._before * blends[:-1] - self._after * blends[1:], blends)

    def slopes(self, z: Array) -> TimeSlopes:
        """Constant."""
        own = np.arange(len(z))[:, None]
        taken = np.column_stack([-self._before * self._longest[:-1], -self._after * self._longest[1:]])
        return TimeSlopes(np.hstack([own[:-1], own[1:]]), taken, own, self._longest[:, None])
