"""Via-point motions as a family: points, speeds and accelerations there, and durations are free."""

import numpy as np

from ..model import InputError, Robot
from ..model.arrays import Array
from .bounds import JointBounds
from .samples import Clear, Samples, everywhere
from .via_points import ViaPoints, quintic_basis, shortest_durations

_SLOWER = 1.3  # start: so many times the shortest durations
_TRIES = 200  # to find a point that can be reached
_SPAN = 0.75  # of the position range that random points use


class FreeViaPoints:
    """Quintic segments; for given durations q, qd and qdd are linear in the points' states.

    x holds (p - middle) / half range, v / speed limit and a / acceleration limit of the points, then
    log(T / 1 s) of the segments. First and last point are at rest.
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
        start: Array | None = None,
    ) -> None:
        """Set up ``count`` points with ``samples`` samples a segment.

        Args:
            robot: the robot, n joints.
            bounds: its limits.
            count: number of points, the first and the last included.
            passing: whether speeds and accelerations at the inner points are free, or zero.
            samples: parts of a segment between samples while optimising.
            durations: shortest and longest duration of a segment [s].
            start: where the motion begins and ends not necessarily [rad or m], shape (n,); None for free.
        """
        if count < 2:
            raise InputError(f"{count} via points are no motion: give at least 2")
        self.robot, self.bounds, self.count, self.samples, self.passing = robot, bounds, count, samples, passing
        self._fixed = 0 if start is None else 1
        self._start = None if start is None else np.asarray(start, dtype=float)
        n, inner = robot.n, (count - 2 if passing else 0)
        sizes = [(count - self._fixed) * n, inner * n, inner * n, count - 1]
        self._ends = np.cumsum(sizes)
        self.size, self.free_duration = int(self._ends[-1]), True
        self.low, self.high = -np.ones(self.size), np.ones(self.size)
        self.low[self._ends[2] :], self.high[self._ends[2] :] = np.log(durations)
        self._bases: dict[int, tuple[Array, Array, Array]] = {}

    def random(self, draw: np.random.Generator, clear: Clear = everywhere) -> Array:
        """Random points, at rest in each, somewhat slower than the limits allow."""
        middle, half = self.bounds.middle, self.bounds.half
        points = self._random_points(draw, clear)
        times = shortest_durations(self.bounds.on(self.robot), points) * _SLOWER
        x = np.zeros(self.size)
        x[: self._ends[0]] = ((points - middle) / half)[self._fixed :].ravel()
        x[self._ends[2] :] = np.log(times)
        return np.asarray(np.clip(x, self.low, self.high))

    def _random_points(self, draw: np.random.Generator, clear: Clear) -> Array:
        """Each point can be reached from the one before on a straight line, unless _TRIES points cannot."""
        middle, reach = self.bounds.middle, _SPAN * self.bounds.half
        on_line = np.linspace(0.0, 1.0, 21)[:, None]
        points = np.empty((self.count, self.robot.n))
        for k in range(self.count):
            if k == 0 and self._start is not None:
                points[0] = self._start
                continue
            for _ in range(_TRIES):
                points[k] = middle + reach * draw.uniform(-1.0, 1.0, self.robot.n)
                before = points[max(k - 1, 0)]
                if clear(before + on_line * (points[k] - before)):
                    break
        return points

    def sample(self, x: Array, finer: int = 1) -> Samples:
        """States at even times of each segment, its ends included: accelerations have corners there."""
        ends, T = self._segments(x)
        B, Bd, Bdd = self._basis(finer)
        step = T[:, None, None]
        q, qd, qdd = B @ ends, (Bd @ ends) / step, (Bdd @ ends) / step**2
        n = self.robot.n
        weight = T[:, None] * self._share(finer)
        return Samples(weight.ravel(), q.reshape(-1, n), qd.reshape(-1, n), qdd.reshape(-1, n))

    def pullback(self, x: Array, slope: Samples) -> Array:
        """The Jacobian transposed times the slopes."""
        ends, T = self._segments(x)
        B, Bd, Bdd = self._basis(1)
        shape, step = (len(T), self.samples + 1, self.robot.n), T[:, None, None]
        q, qd, qdd = slope.q.reshape(shape), slope.qd.reshape(shape) / step, slope.qdd.reshape(shape) / step**2
        by_ends = B.T @ q + Bd.T @ qd + Bdd.T @ qdd
        by_T = slope.weight.reshape(len(T), -1) @ self._share(1)
        by_T -= np.einsum("kij,kij->k", Bd.T @ qd + 2.0 * (Bdd.T @ qdd), ends) / T
        # ends holds T v and T^2 a
        powers = np.array([0.0, 1.0, 2.0, 2.0, 1.0, 0.0])
        by_T += np.einsum("kij,kij,i->k", by_ends, ends, powers) / T
        return self._gathered(by_ends, by_T, T)

    def jacobian(self, x: Array) -> tuple[Array, Array, Array]:
        """Derivatives of q, qd and qdd, each (N, n, size)."""
        ends, T = self._segments(x)
        m = self.samples + 1
        shape = (len(T) * m, self.robot.n, self.size)
        derivative = [np.zeros(shape) for _ in range(3)]
        linear = int(self._ends[2])
        zero = np.zeros(self.size)
        zero[linear:] = x[linear:]
        base = self.sample(zero)
        for k in range(linear):
            unit = zero.copy()
            unit[k] = 1.0
            here = self.sample(unit)
            for into, a, b in zip(derivative, here[1:], base[1:], strict=True):
                into[:, :, k] = a - b
        powers = np.array([0.0, 1.0, 2.0, 2.0, 1.0, 0.0])[:, None]
        for order, (into, B) in enumerate(zip(derivative, self._basis(1), strict=True)):
            for k, t in enumerate(T):
                part = slice(k * m, (k + 1) * m)
                # d/d log T
                into[part, :, linear + k] = (B @ (powers * ends[k]) - order * (B @ ends[k])) / t**order
        return derivative[0], derivative[1], derivative[2]

    def plan(self, x: Array) -> ViaPoints:
        """The motion."""
        p, v, a, T = self._unpacked(x)
        return ViaPoints(p, T, v, a) if self.passing else ViaPoints(p, T)

    def eased(self, x: Array, slower: float, smaller: float) -> Array:
        """Slower by longer durations, smaller about the middle of the range."""
        eased = x.copy()
        first, second, third = self._ends[:3]
        eased[:first] *= smaller if self._start is None else 1.0
        eased[first:second] *= smaller / slower
        eased[second:third] *= smaller / slower**2
        eased[third:] += np.log(slower)
        return np.asarray(np.clip(eased, self.low, self.high))

    def _basis(self, finer: int) -> tuple[Array, Array, Array]:
        if finer not in self._bases:
            self._bases[finer] = quintic_basis(np.linspace(0.0, 1.0, self.samples * finer + 1))
        return self._bases[finer]

    def _share(self, finer: int) -> Array:
        """Share of a segment's time that each of its samples stands for (trapezoidal rule)."""
        m = self.samples * finer
        share = np.full(m + 1, 1.0 / m)
        share[[0, -1]] *= 0.5
        return share

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
        return p, v, a, np.exp(x[third:])

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
        slope[third:] = by_T * T
        return slope
