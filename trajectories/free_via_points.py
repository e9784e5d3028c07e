"""Via-point motions as a family: points, speeds and accelerations there, and durations are free or fixed."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.arrays import Array
from ..common.errors import InputError
from ..model import Robot
from .bounds import JointBounds
from .drawn_points import as_drawn, reachable_points
from .samples import Clear, Jacobian, Samples, everywhere
from .segments import QUINTIC, Grid, Segment
from .via_points import ViaPoints, shortest_durations

_SLOWER = 1.3  # start: so many times the shortest durations
_POWERS = np.array([0.0, 1.0, 2.0, 2.0, 1.0, 0.0])  # of T, that a segment's ends are multiplied with


class FreeViaPoints:
    """Segments whose q, qd and qdd are linear in the points' states for given durations.

    x holds (p - middle) / half range, v / speed limit and a / acceleration limit of the points, then
    log(T / 1 s) of the segments unless their durations are fixed. First and last point are at rest.
    """

    def __init__(
        self,
        robot: Robot,
        bounds: JointBounds,
        count: int,
        *,
        passing: bool = True,
        samples: int = 12,
        durations: tuple[float, float] = (0.1, 3.0),
        fixed: ArrayLike | None = None,
        segment: Segment = QUINTIC,
        start: Array | None = None,
    ) -> None:
        """Set up ``count`` points with ``samples`` samples a segment.

        Args:
            robot: the robot, n joints.
            bounds: its limits.
            count: number of points, the first and the last included.
            passing: whether speeds and accelerations at the inner points are free, or zero.
            samples: parts of a segment between samples while optimising, about.
            durations: shortest and longest duration of a segment [s].
            fixed: the segments' durations [s] instead, shape (count - 1,) or one for all; None for free.
            segment: how the motion goes from point to point.
            start: where the motion begins and ends not necessarily [rad or m], shape (n,); None for free.
        """
        if count < 2:
            raise InputError(f"{count} via points are no motion: give at least 2")
        if passing and not segment.passes:
            raise InputError(f"a {segment.name} rests in every via point: set passing to False, or use BlendShape")
        self.robot, self.bounds, self.count, self.samples, self.passing = robot, bounds, count, samples, passing
        self.segment = segment
        self._times = None if fixed is None else checked_durations(fixed, count)
        self._fixed = 0 if start is None else 1
        self._start = None if start is None else np.asarray(start, dtype=float)
        n, inner = robot.n, (count - 2 if passing else 0)
        sizes = [(count - self._fixed) * n, inner * n, inner * n, count - 1 if fixed is None else 0]
        self._ends = np.cumsum(sizes)
        self.size, self.free_duration = int(self._ends[-1]), fixed is None
        self.low, self.high = -np.ones(self.size), np.ones(self.size)
        self.low[self._ends[2] :], self.high[self._ends[2] :] = np.log(durations)
        self._grids: dict[int, Grid] = {}

    def random(self, draw: np.random.Generator, clear: Clear = everywhere) -> Array:
        """Random points, at rest in each, somewhat slower than the limits allow."""
        nearer = as_drawn if self._times is None else self._nearer
        points = reachable_points(self.bounds, self.count, draw, clear, self._start, nearer)
        x = np.zeros(self.size)
        x[: self._ends[0]] = ((points - self.bounds.middle) / self.bounds.half)[self._fixed :].ravel()
        if self._times is None:
            times = shortest_durations(self.bounds.on(self.robot), points, segment=self.segment)
            x[self._ends[2] :] = np.log(times * _SLOWER)
        return np.asarray(np.clip(x, self.low, self.high))

    def _nearer(self, move: int, before: Array, point: Array) -> Array:
        """As far towards a point as the limits allow in the move's fixed time."""
        assert self._times is not None
        T, step = self._times[move] / _SLOWER, np.abs(point - before)
        by_speed = self.bounds.speed * T / (self.segment.peak_speed * step)
        by_acceleration = self.bounds.acceleration * T**2 / (self.segment.peak_acceleration * step)
        share = min(1.0, float(by_speed.min()), float(by_acceleration.min()))
        return np.asarray(before + share * (point - before))

    def sample(self, x: Array, finer: int = 1) -> Samples:
        """States at times of each segment, its ends included: accelerations have corners there."""
        ends, T = self._segments(x)
        share, (B, Bd, Bdd) = self._grid(finer)
        step = T[:, None, None]
        q, qd, qdd = B @ ends, (Bd @ ends) / step, (Bdd @ ends) / step**2
        n = self.robot.n
        weight = T[:, None] * share
        return Samples(weight.ravel(), q.reshape(-1, n), qd.reshape(-1, n), qdd.reshape(-1, n))

    def pullback(self, x: Array, slope: Samples) -> Array:
        """The Jacobian transposed times the slopes."""
        ends, T = self._segments(x)
        share, (B, Bd, Bdd) = self._grid(1)
        shape, step = (len(T), len(share), self.robot.n), T[:, None, None]
        q, qd, qdd = slope.q.reshape(shape), slope.qd.reshape(shape) / step, slope.qdd.reshape(shape) / step**2
        by_ends = B.T @ q + Bd.T @ qd + Bdd.T @ qdd
        by_T = slope.weight.reshape(len(T), -1) @ share
        by_T -= np.einsum("kij,kij->k", Bd.T @ qd + 2.0 * (Bdd.T @ qdd), ends) / T
        by_T += np.einsum("kij,kij,i->k", by_ends, ends, _POWERS) / T
        return self._gathered(by_ends, by_T, T)

    def jacobian(self, x: Array) -> Jacobian:
        """A joint's states depend on its own at both ends of the segment, and on the duration."""
        ends, T = self._segments(x)
        share, basis = self._grid(1)
        t, size = T[:, None, None], (len(T), len(share), self.robot.n, 7)
        b, one = self.bounds, np.ones_like(t)
        scale = np.stack([b.half * one, t * b.speed, t**2 * b.acceleration], axis=3)[:, :, :, [0, 1, 2, 2, 1, 0]]
        derivatives = []
        for order, B in enumerate(basis):
            by_x = np.empty(size)
            by_x[..., :6] = B[:, None, :] * (scale / t[..., None] ** order)
            by_x[..., 6] = (B @ (_POWERS[:, None] * ends) - order * (B @ ends)) / t**order  # d/d log T
            derivatives.append(by_x.reshape(-1, *size[2:]))
        columns = np.broadcast_to(self._columns()[:, None], size).reshape(derivatives[0].shape)
        q, qd, qdd = (np.where(columns < self.size, by_x, 0.0) for by_x in derivatives)
        return Jacobian(columns, q, qd, qdd, self.size)

    def _columns(self) -> NDArray[np.intp]:
        """Where p0, v0, a0, a1, v1, p1 and T of each segment stand in x, (count - 1, n, 7)."""
        n, (first, second, third) = self.robot.n, self._ends[:3]
        p, v, a = (np.full((self.count, n), self.size) for _ in range(3))
        p[self._fixed :] = np.arange(first).reshape(-1, n)
        if self.passing:
            v[1:-1], a[1:-1] = (np.arange(*part).reshape(-1, n) for part in ((first, second), (second, third)))
        T = np.arange(third, third + self.count - 1) if self._times is None else np.full(self.count - 1, self.size)
        ends = [p[:-1], v[:-1], a[:-1], a[1:], v[1:], p[1:], np.broadcast_to(T[:, None], (self.count - 1, n))]
        return np.stack(ends, axis=2)

    def plan(self, x: Array) -> ViaPoints:
        """The motion."""
        p, v, a, T = self._unpacked(x)
        return ViaPoints(p, T, v, a) if self.passing else ViaPoints(p, T, segment=self.segment)

    def eased(self, x: Array, slower: float, smaller: float) -> Array:
        """Slower by longer durations, smaller about the middle of the range.

        With fixed durations smaller instead of slower, about the start if there is one.
        """
        if self._times is not None:
            return self._shrunk(x, smaller / slower)
        eased = x.copy()
        first, second, third = self._ends[:3]
        eased[:first] *= smaller if self._start is None else 1.0
        eased[first:second] *= smaller / slower
        eased[second:third] *= smaller / slower**2
        eased[third:] += np.log(slower)
        return np.asarray(np.clip(eased, self.low, self.high))

    def _shrunk(self, x: Array, share: float) -> Array:
        shrunk, first = share * x, self._ends[0]
        if self._start is not None:
            start = (self._start - self.bounds.middle) / self.bounds.half
            shrunk[:first] += (1.0 - share) * np.tile(start, self.count - 1)
        return shrunk

    def _grid(self, finer: int) -> Grid:
        if finer not in self._grids:
            self._grids[finer] = self.segment.grid(self.samples * finer)
        return self._grids[finer]

    def _unpacked(self, x: Array) -> tuple[Array, Array, Array, Array]:
        """Points, speeds and accelerations there (count, n), durations (count - 1,)."""
        n, first, second, third = self.robot.n, *self._ends[:3]
        p, v, a = np.empty((self.count, n)), np.zeros((self.count, n)), np.zeros((self.count, n))
        p[self._fixed :] = self.bounds.middle + self.bounds.half * x[:first].reshape(-1, n)
        if self._start is not None:
            p[0] = self._start
        if self.passing:
            v[1:-1] = self.bounds.speed * x[first:second].reshape(-1, n)
            a[1:-1] = self.bounds.acceleration * x[second:third].reshape(-1, n)
        return p, v, a, np.exp(x[third:]) if self._times is None else self._times

    def _segments(self, x: Array) -> tuple[Array, Array]:
        """p0, T v0, T^2 a0, T^2 a1, T v1, p1 of each segment (count - 1, 6, n), and T."""
        p, v, a, T = self._unpacked(x)
        t = T[:, None]
        ends = np.stack([p[:-1], t * v[:-1], t**2 * a[:-1], t**2 * a[1:], t * v[1:], p[1:]], axis=1)
        return ends, T

    def _gathered(self, by_ends: Array, by_T: Array, T: Array) -> Array:
        """Slopes in x from those in the segments' ends and in T."""
        n, t = self.robot.n, T[:, None]
        slope = np.empty(self.size)
        first, second, third = self._ends[:3]
        by_p = np.zeros((self.count, n))
        by_p[:-1] += by_ends[:, 0]
        by_p[1:] += by_ends[:, 5]
        slope[:first] = (by_p * self.bounds.half)[self._fixed :].ravel()
        if self.passing:
            by_v = (t * by_ends[:, 4])[:-1] + (t * by_ends[:, 1])[1:]
            by_a = (t**2 * by_ends[:, 3])[:-1] + (t**2 * by_ends[:, 2])[1:]
            slope[first:second] = (by_v * self.bounds.speed).ravel()
            slope[second:third] = (by_a * self.bounds.acceleration).ravel()
        if self._times is None:
            slope[third:] = by_T * T
        return slope


def checked_durations(fixed: ArrayLike, count: int) -> Array:
    """Durations of the segments between ``count`` points [s], shape (count - 1,); a number stands for all.

    Raises:
        InputError: if there is another number of them, or one is not positive.
    """
    times = np.asarray(fixed, dtype=float)
    if times.shape not in ((), (count - 1,)) or not ((times > 0.0) & np.isfinite(times)).all():
        given = ", ".join(f"{time:g}" for time in times.ravel())
        raise InputError(
            f"fixed durations {given}: {count} via points need {count - 1} positive ones [s], or one for all"
        )
    return np.broadcast_to(times, (count - 1,)).copy()
