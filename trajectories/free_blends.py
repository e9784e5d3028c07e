"""Straight moves with blends as a family: points, times and blends are free, or the moves' durations are fixed."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.arrays import Array
from ..common.errors import InputError
from ..model import Robot
from .blend_phases import TIMES, coefficients, derivatives, lengths
from .blend_times import BlendTimes, FixedTimes, FreeTimes, Times, TimeSlopes
from .blends import BlendedPoints
from .bounds import JointBounds
from .drawn_points import as_drawn, reachable_points
from .free_via_points import checked_durations
from .samples import Clear, Jacobian, Samples, everywhere
from .segments import even

_SLOWER = 1.3  # start: so many times the shortest times
_SHARE = 0.5  # start: of the longest blends that fit between fixed times
_STRETCH, _STRAIGHT = 1.1, 0.1  # start: moves too short for their blends; at constant speed at least, of a move


class FreeBlends:
    """Moves at constant speed between parabolic blends, ``BlendedPoints``.

    x holds (p - middle) / half range of the points, then what the times depend on (blend_times.py). A phase is a
    blend or the constant part of a move, in turn; every phase has the same number of samples.
    """

    def __init__(
        self,
        robot: Robot,
        bounds: JointBounds,
        count: int,
        *,
        samples: int = 12,
        durations: tuple[float, float] = (0.1, 3.0),
        fixed: ArrayLike | None = None,
        start: Array | None = None,
    ) -> None:
        """Set up ``count`` points with ``samples`` parts between samples in a move and a blend together.

        Args:
            robot: the robot, n joints.
            bounds: its limits.
            count: number of points, the first and the last included.
            samples: parts between samples while optimising.
            durations: shortest and longest duration of a move [s].
            fixed: the moves' durations [s] instead, shape (count - 1,) or one for all; None for free.
            start: where the motion begins [rad or m], shape (n,); None for free.
        """
        if count < 2:
            raise InputError(f"{count} via points are no motion: give at least 2")
        self.robot, self.bounds, self.count = robot, bounds, count
        self._parts = max(samples // 2, 1)
        self._given = None if fixed is None else checked_durations(fixed, count)
        self._times: BlendTimes = FreeTimes(count, durations) if self._given is None else FixedTimes(self._given)
        self._fixed = 0 if start is None else 1
        self._start = None if start is None else np.asarray(start, dtype=float)
        self._linear = (count - self._fixed) * robot.n
        self.size, self.free_duration = self._linear + len(self._times.low), fixed is None
        self.low = np.concatenate([-np.ones(self._linear), self._times.low])
        self.high = np.concatenate([np.ones(self._linear), self._times.high])

    def random(self, draw: np.random.Generator, clear: Clear = everywhere) -> Array:
        """Random points, somewhat slower than the limits allow."""
        nearer = as_drawn if self._given is None else self._nearer
        points = reachable_points(self.bounds, self.count, draw, clear, self._start, nearer)
        x = np.empty(self.size)
        x[: self._linear] = ((points - self.bounds.middle) / self.bounds.half)[self._fixed :].ravel()
        x[self._linear :] = _SHARE if self._given is not None else np.log(np.concatenate(self._unhurried(points)))
        return np.asarray(np.clip(x, self.low, self.high))

    def _unhurried(self, points: Array) -> Times:
        """Times that the limits allow."""
        step = np.diff(points, axis=0)
        between = _SLOWER * (np.abs(step) / self.bounds.speed).max(axis=1)
        while True:
            still = np.zeros_like(step[:1])
            change = np.abs(np.diff(step / between[:, None], axis=0, prepend=still, append=still))
            blends = _SLOWER * (change / self.bounds.acceleration).max(axis=1)
            straight = between - 0.5 * (blends[:-1] + blends[1:])
            short = straight < _STRAIGHT * between
            if not short.any():
                return Times(straight, blends)
            between = np.where(short, _STRETCH * between, between)

    def _nearer(self, move: int, before: Array, point: Array) -> Array:
        """As far towards a point as the limits allow in the move's fixed time, whatever the next one does."""
        times = self._times.of(np.full(self.size - self._linear, _SHARE))
        strong = 0.5 * self.bounds.acceleration * times.blends[move : move + 2].min()
        speed = np.minimum(self.bounds.speed, strong) / _SLOWER
        share = (speed * times.between[move] / np.abs(point - before)).min()
        return np.asarray(before + min(1.0, float(share)) * (point - before))

    def sample(self, x: Array, finer: int = 1) -> Samples:
        """States in every phase, its ends included: both sides of each step of the acceleration."""
        p, times = self._unpacked(x)
        s, share = self._grid(finer)
        k, u, w = self._phases(p, times)
        into, out = coefficients(times, s)
        states = np.einsum("ofs,fj->ofsj", into, u) + np.einsum("ofs,fj->ofsj", out, w)
        states[0] += p[k, None]
        q, qd, qdd = states.reshape(3, -1, self.robot.n)
        return Samples(np.outer(lengths(times), share).ravel(), q, qd, qdd)

    def pullback(self, x: Array, slope: Samples) -> Array:
        """The Jacobian transposed times the slopes."""
        _, share = self._grid(1)
        by_length = slope.weight.reshape(-1, len(share)) @ share
        own, slopes = self.jacobian(x), self._times.slopes(x[self._linear :])
        by_x = own.transposed(slope)
        np.add.at(by_x, self._linear + slopes.in_blends, by_length[::2, None] * slopes.blends)
        np.add.at(by_x, self._linear + slopes.in_straight, by_length[1::2, None] * slopes.straight)
        return by_x

    def jacobian(self, x: Array) -> Jacobian:
        """A joint's states depend on its own at up to three points, and on the times about its phase."""
        p, times = self._unpacked(x)
        s, _ = self._grid(1)
        k, u, w = self._phases(p, times)
        by_points, by_times = derivatives(times, s, u, w)
        slopes = self._times.slopes(x[self._linear :])
        parts = [self._in_point(k, step, by_points[step + 1]) for step in (-1, 0, 1)]
        for (step, straight), value in zip(TIMES, by_times, strict=True):
            parts.append(self._in_time(k, step, straight, value, slopes))
        columns = np.concatenate([column for column, _ in parts], axis=2)
        shape, size = (len(k), len(s), *columns.shape[1:]), (-1, *columns.shape[1:])
        wide = np.broadcast_to(columns[:, None], shape).reshape(size)
        full = np.concatenate([np.broadcast_to(v, (3, *shape[:3], v.shape[-1])) for _, v in parts], axis=4)
        q, qd, qdd = (np.where(wide < self.size, by_x.reshape(size), 0.0) for by_x in full)
        return Jacobian(wide, q, qd, qdd, self.size)

    def _in_point(self, k: NDArray[np.intp], step: int, value: Array) -> tuple[NDArray[np.intp], Array]:
        """Columns (phases, n, 1) and derivatives in the points ``step`` from those of the phases."""
        own = np.arange(self.robot.n)
        place = (k[:, None] + step - self._fixed) * self.robot.n + own
        there = self._there(k, step, self.count)[:, None] & (place >= 0)
        columns = np.where(there, place, self.size)[..., None]
        return columns, value[..., None, None] * self.bounds.half[:, None]

    def _in_time(
        self, k: NDArray[np.intp], step: int, straight: int, value: Array, slopes: TimeSlopes
    ) -> tuple[NDArray[np.intp], Array]:
        """Columns (phases, n, ...) and derivatives in what a time ``step`` from the phases' points depends on."""
        count = self.count - straight
        places, slope = slopes[:2] if straight else slopes[2:]
        at = np.clip(k + step, 0, count - 1)
        column = np.where(self._there(k, step, count)[:, None], self._linear + places[at], self.size)
        columns = np.broadcast_to(column[:, None], (len(k), self.robot.n, column.shape[1]))
        return columns, value[..., None] * slope[at][:, None, None]

    def _there(self, k: NDArray[np.intp], step: int, count: int) -> NDArray[np.bool_]:
        """Whether there is such a point or time, and the phase depends on it: no move does on what was before."""
        is_blend = np.arange(len(k)) % 2 == 0
        return np.asarray((k + step >= 0) & (k + step < count) & (is_blend | (step >= 0)))

    def plan(self, x: Array) -> BlendedPoints:
        """The motion."""
        p, times = self._unpacked(x)
        return BlendedPoints(p, times.durations if self._given is None else self._given, times.blends)

    def eased(self, x: Array, slower: float, smaller: float) -> Array:
        """Slower by longer times, smaller about the middle of the range or the start; with fixed times smaller."""
        free = self._given is None
        eased, share = x.copy(), smaller if free else smaller / slower
        about = np.zeros(self._linear)
        if self._start is not None:
            about = np.tile((self._start - self.bounds.middle) / self.bounds.half, self.count - 1)
        eased[: self._linear] = about + share * (x[: self._linear] - about)
        if free:
            eased[self._linear :] += np.log(slower)
        return np.asarray(np.clip(eased, self.low, self.high))

    def _grid(self, finer: int) -> tuple[Array, Array]:
        """Shares of a phase's time at its samples, and the time each stands for, shape (parts + 1,)."""
        parts = self._parts * finer
        return np.linspace(0.0, 1.0, parts + 1), even(parts)

    def _unpacked(self, x: Array) -> tuple[Array, Times]:
        """Points (count, n) and times."""
        p = np.empty((self.count, self.robot.n))
        p[self._fixed :] = self.bounds.middle + self.bounds.half * x[: self._linear].reshape(-1, self.robot.n)
        if self._start is not None:
            p[0] = self._start
        return p, self._times.of(x[self._linear :])

    def _phases(self, p: Array, times: Times) -> tuple[NDArray[np.intp], Array, Array]:
        """Each phase's point, and the speeds of the moves to and from it, (phases, n); 0 where there is none."""
        still = np.zeros_like(p[:1])
        speed = np.vstack([still, np.diff(p, axis=0) / times.between[:, None], still])
        k = np.arange(2 * self.count - 1) // 2
        return k, speed[k], speed[k + 1]
