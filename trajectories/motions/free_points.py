"""Points to pass as free numbers, and random ones to start a search from."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Robot
from .bounds import JointBounds
from .samples import LONGEST, Clear

_MOST = 500  # points: a search takes half an hour then
_TRIES = 200  # to find a point that can be reached
_SPAN = 0.75  # of the position range that random points use

Nearer = Callable[[int, Array, Array], Array]
"""Move's number, where it starts and where it ends -> an end as near as the move's time allows."""


class FreePoints:
    """Coordinates (p - middle) / half range of a motion's points; a given start is the first and is not free.

    Attributes:
        count: number of points, the first and the last included.
        first: the first point that is free, 0 or 1.
        size: number of coordinates.
        fixed: durations of the moves between the points [s], shape (count - 1,); None where they are free.
    """

    def __init__(
        self,
        bounds: JointBounds,
        count: int,
        fixed: ArrayLike | None = None,
        start: Array | None = None,
        longest: float | None = None,
    ) -> None:
        """Check the points and times asked for.

        Args:
            fixed: durations of the moves [s], one for all or one each; None for free.
            start: where the motion begins [rad or m], shape (n,); None for anywhere.
            longest: longest duration of the motion [s], which fixed ones leave no place for.

        Raises:
            InputError: if they do not fit.
        """
        _check_count(count)
        if fixed is not None and longest is not None:
            raise InputError("the durations of the moves are fixed: leave the longest duration of the motion out")
        self.count, self._bounds, self._start = count, bounds, start
        self.first = 0 if start is None else 1
        self.size = (count - self.first) * len(bounds.low)
        self.fixed = None if fixed is None else _checked_durations(fixed, count)

    def positions(self, x: Array) -> Array:
        """Points at coordinates x [rad or m], shape (count, n)."""
        bounds = self._bounds
        points = np.empty((self.count, len(bounds.low)))
        points[self.first :] = bounds.middle + bounds.half * x.reshape(-1, len(bounds.low))
        if self._start is not None:
            points[0] = self._start
        return points

    def coordinates(self, points: Array) -> Array:
        """Coordinates of points (count, n)."""
        scaled = (points - self._bounds.middle) / self._bounds.half
        return np.asarray(scaled[self.first :].ravel())

    def pullback(self, by_points: Array) -> Array:
        """Slopes in the coordinates from those in the points, (count, n)."""
        return np.asarray((by_points * self._bounds.half)[self.first :].ravel())

    def shrunk(self, x: Array, share: float) -> Array:
        """Coordinates of a motion ``share`` times as large about the start, or else the middle of the range."""
        if self._start is None:
            return share * x
        start = (self._start - self._bounds.middle) / self._bounds.half
        return np.asarray(share * x + (1.0 - share) * np.tile(start, self.count - 1))

    def random(self, draw: np.random.Generator, clear: Clear, nearer: Nearer | None = None) -> Array:
        """Random points, each reached from the one before on a straight line if ``_TRIES`` points contain one.

        Positions [rad or m], shape (count, n); ``nearer`` brings points closer where a move's duration is given.
        """
        middle, reach = self._bounds.middle, _SPAN * self._bounds.half
        on_line = np.linspace(0.0, 1.0, 21)[:, None]
        points = np.empty((self.count, len(middle)))
        if self._start is not None:
            points[0] = self._start
        for k in range(self.first, self.count):
            for _ in range(_TRIES):
                points[k] = middle + reach * draw.uniform(-1.0, 1.0, len(middle))
                before = points[max(k - 1, 0)]
                if nearer is not None and k > 0:
                    points[k] = nearer(k - 1, before, points[k])
                if clear(before + on_line * (points[k] - before)):
                    break
        return points


def random_points(robot: Robot, count: int, seed: int, span: float = 0.8) -> Array:
    """Random positions within the limits, shape (count, n).

    Args:
        robot: its joints need position limits.
        span: fraction of the position range to use, about its middle.

    Raises:
        ValueError: if a joint has no position limits, or for a count that makes no motion.
    """
    _check_count(count)
    ranges = np.array([joint.limits.position for joint in robot.joints])
    if not np.isfinite(ranges).all():
        raise ValueError(f"robot {robot.name!r} has joints without position limits")
    middle, half = ranges.mean(axis=1), 0.5 * span * np.diff(ranges, axis=1)[:, 0]
    draw = np.random.default_rng(seed)
    return np.asarray(middle + half * draw.uniform(-1.0, 1.0, (count, robot.n)))


def _check_count(count: int) -> None:
    if not 2 <= count <= _MOST:
        raise InputError(f"{count} via points: give 2 to {_MOST}, more take longer than anybody waits")


def _checked_durations(fixed: ArrayLike, count: int) -> Array:
    """Durations of the moves between ``count`` points [s], shape (count - 1,); a number stands for all.

    Raises:
        InputError: if there is another number of them, or one is not positive.
    """
    times = np.asarray(fixed, dtype=float)
    if times.shape not in ((), (count - 1,)) or not ((times > 0.0) & (times <= LONGEST)).all():
        seconds = ", ".join(f"{time:g}" for time in times.ravel())
        raise InputError(
            f"fixed durations {seconds}: {count} via points need {count - 1} positive ones [s], or one for all"
        )
    return np.broadcast_to(times, (count - 1,)).copy()
