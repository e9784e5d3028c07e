"""Times of a motion with blends as free numbers, and its states in each phase: every blend fits into its moves.

A phase is the blend about point k, or the constant part of the move from it. With u the speed of the move to the
point and w that of the move from it, q - p, qd and qdd are a u + c w, with a and c that depend on the times alone.
"""

from typing import NamedTuple

import numpy as np

from ...common.arrays import Array

_STRAIGHT = 0.02  # of a fixed move's time: what blends leave at constant speed, at least
_SHORTEST = 0.05  # of the longest blend that fits between fixed times


class Times(NamedTuple):
    """Seconds at constant speed in each of the moves, (count - 1,), and in each point's blend, (count,)."""

    straight: Array
    blends: Array

    @property
    def between(self) -> Array:
        """Time from the middle of one blend to the middle of the next [s], shape (count - 1,)."""
        return np.asarray(self.straight + 0.5 * (self.blends[:-1] + self.blends[1:]))

    @property
    def durations(self) -> Array:
        """Time ``between``, the first counted from the start and the last to the end [s], shape (count - 1,)."""
        durations = self.between
        durations[0] += 0.5 * self.blends[0]
        durations[-1] += 0.5 * self.blends[-1]
        return durations

    @property
    def phases(self) -> Array:
        """Durations of the phases in order, blend, move, blend and so on [s], shape (2 count - 1,)."""
        phases = np.empty(2 * len(self.blends) - 1)
        phases[::2], phases[1::2] = self.blends, self.straight
        return phases

    def coefficients(self, s: Array) -> tuple[Array, Array]:
        """What multiplies the speeds to and from a phase's point in q - p, qd and qdd, each (3, phases, samples).

        Args:
            s: shares of a phase's time, shape (samples,).
        """
        b, straight = self.blends[:, None], self.straight[:, None]
        into, out = (np.zeros((3, 2 * len(b) - 1, len(s))) for _ in range(2))
        into[0, ::2], into[1, ::2], into[2, ::2] = b * (s - 0.5 - 0.5 * s**2), 1.0 - s, -1.0 / b
        out[0, ::2], out[1, ::2], out[2, ::2] = 0.5 * b * s**2, s, 1.0 / b
        out[0, 1::2], out[1, 1::2] = 0.5 * b[:-1] + straight * s, 1.0
        return into, out

    def pullback(self, s: Array, by_into: Array, by_out: Array) -> "Times":
        """Slopes in the times from those in the coefficients, each (3, phases, samples)."""
        by_straight, by_blends = np.zeros(len(self.straight)), np.zeros(len(self.blends))
        by_blends += by_into[0, ::2] @ (s - 0.5 - 0.5 * s**2) + by_out[0, ::2] @ (0.5 * s**2)
        by_blends += (by_into[2, ::2] - by_out[2, ::2]).sum(axis=1) / self.blends**2
        by_blends[:-1] += 0.5 * by_out[0, 1::2].sum(axis=1)
        by_straight += by_out[0, 1::2] @ s
        return Times(by_straight, by_blends)


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

    def pullback(self, z: Array, by_times: Times) -> Array:
        """Slopes of exponentials."""
        return np.asarray(np.exp(z) * np.concatenate(by_times))


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

    def pullback(self, z: Array, by_times: Times) -> Array:
        """Slopes that do not depend on z."""
        by_blends = by_times.blends.copy()
        by_blends[:-1] -= self._before * by_times.straight
        by_blends[1:] -= self._after * by_times.straight
        return np.asarray(self._longest * by_blends)


BlendTimes = FreeTimes | FixedTimes
"""Times that depend on a vector z within the bounds ``low`` and ``high``."""


def blend_times(count: int, durations: tuple[float, float], fixed: Array | None) -> BlendTimes:
    """Times of ``count`` points: free between the shortest and longest ``durations``, or ``fixed`` [s]."""
    return FreeTimes(count, durations) if fixed is None else FixedTimes(fixed)
