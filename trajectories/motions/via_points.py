"""Motions through via points by quintic or trapezoidal segments, at rest in each or passing.

Segments give q, T qd and T^2 qdd at s = t / T as constant matrices times the states at their ends: what multiplies
p0, T v0, T^2 a0, T^2 a1, T v1 and p1.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array, frozen_array
from ...common.brief import Brief
from ...common.errors import InputError
from ...model import Robot
from .family import LONGEST, Clear, JointBounds, Plan, Samples, checked_start, everywhere

_MOST = 500  # points: a search takes half an hour then
_TRIES = 200  # to find a point that can be reached
_SPAN = 0.75  # of the position range that random points use
_SLOWER = 1.3  # start: so many times the shortest durations
_POWERS = np.array([0.0, 1.0, 2.0, 2.0, 1.0, 0.0])  # of T, that a segment's ends are multiplied with

# Quintic Hermite polynomials on 0 <= s <= 1: row k holds the coefficients of 1, s, ..., s^5 that multiply
# p0, T v0, T^2 a0, T^2 a1, T v1, p1.
_HERMITE = np.array(
    [
        [1.0, 0.0, 0.0, -10.0, 15.0, -6.0],
        [0.0, 1.0, 0.0, -6.0, 8.0, -3.0],
        [0.0, 0.0, 0.5, -1.5, 1.5, -0.5],
        [0.0, 0.0, 0.0, 0.5, -1.0, 0.5],
        [0.0, 0.0, 0.0, -4.0, 7.0, -3.0],
        [0.0, 0.0, 0.0, 10.0, -15.0, 6.0],
    ]
)

Basis = tuple[Array, Array, Array]
"""Factors of the ends' states: in q, in T qd and in T^2 qdd, each (N, 6)."""
Grid = tuple[Array, Basis]
"""Samples of a segment: the fraction of its time that each stands for, shape (N,), and the basis there."""


def _even(parts: int) -> Array:
    """Weights of the trapezoidal rule over unit time in even parts, shape (parts + 1,)."""
    weights = np.full(parts + 1, 1.0 / parts)
    weights[[0, -1]] *= 0.5
    return weights


@dataclass(frozen=True)
class Quintic:
    """Quintic segment between position, speed and acceleration at both ends."""

    name = "quintic"
    passes = True
    peak_speed = 15.0 / 8.0
    peak_acceleration = 10.0 / 3.0**0.5

    def basis(self, s: Array) -> Basis:
        """Evaluate the Hermite polynomials."""
        powers = s[:, None] ** np.arange(6)
        k = np.arange(1, 6)
        first = np.hstack([np.zeros((len(s), 1)), k * powers[:, :5]])
        second = np.hstack([np.zeros((len(s), 2)), k[1:] * k[:4] * powers[:, :4]])
        return powers @ _HERMITE.T, first @ _HERMITE.T, second @ _HERMITE.T

    def grid(self, parts: int) -> Grid:
        """Divide the segment into even parts."""
        return _even(parts), self.basis(np.linspace(0.0, 1.0, parts + 1))


QUINTIC = Quintic()


@dataclass(frozen=True)
class Trapezoid:
    """Trapezoidal segment: a ramp to constant speed and a ramp down, as in a controller's synchronised joint move.

    It rests at both ends. All joints follow one law q0 + (q1 - q0) f(t / T). Its acceleration is constant in each
    phase and steps between them.

    Attributes:
        ramp: fraction of the time that each of the two ramps takes, above 0, at most 0.5 (no constant speed then).

    Raises:
        InputError: if the ramp is out of range.
    """

    ramp: float = 0.25

    name = "trapezoid"
    passes = False

    def __post_init__(self) -> None:
        """Check the ramp."""
        if not 0.0 < self.ramp <= 0.5:
            raise InputError(f"a ramp of {self.ramp:g} of a move's time: give a share above 0, at most 0.5")

    @property
    def peak_speed(self) -> float:
        """Peak speed, reached over the whole constant phase."""
        return 1.0 / (1.0 - self.ramp)

    @property
    def peak_acceleration(self) -> float:
        """Peak acceleration, held over the whole ramps."""
        return 1.0 / (self.ramp * (1.0 - self.ramp))

    def basis(self, s: Array) -> Basis:
        """Evaluate the basis: at a step of the acceleration its value after the step, at s = 1 that before."""
        return self._in_phase(s, np.searchsorted([self.ramp, 1.0 - self.ramp], s, side="right"))

    def grid(self, parts: int) -> Grid:
        """Divide each phase into even parts; both sides of every step of the acceleration are sampled."""
        s, phase, weights = [], [], []
        for k, (begin, end) in enumerate(pairwise((0.0, self.ramp, 1.0 - self.ramp, 1.0))):
            if end > begin:
                count = max(round(parts * (end - begin)), 2)
                s.append(np.linspace(begin, end, count + 1))
                phase.append(np.full(count + 1, k))
                weights.append(_even(count) * (end - begin))
        return np.concatenate(weights), self._in_phase(np.concatenate(s), np.concatenate(phase))

    def _in_phase(self, s: Array, phase: NDArray[np.int_]) -> Basis:
        """Values f, f' and f'' in the ramp up (0), at constant speed (1) and in the ramp down (2)."""
        v, a, left = self.peak_speed, self.peak_acceleration, 1.0 - s
        up, down = phase == 0, phase == 2
        f = np.select([up, down], [0.5 * a * s**2, 1.0 - 0.5 * a * left**2], v * (s - 0.5 * self.ramp))
        slope = np.select([up, down], [a * s, a * left], v)
        curve = np.select([up, down], [a, -a], 0.0)
        between = np.array([-1.0, 0.0, 0.0, 0.0, 0.0, 1.0])
        still = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
        return still + f[:, None] * between, slope[:, None] * between, curve[:, None] * between


Segment = Quintic | Trapezoid
"""Segment between points: its name, whether it ``passes`` points in motion, and the peak speed and acceleration
of a step of 1 in unit time, at rest at both ends."""


@dataclass(frozen=True, repr=False)
class ViaPoints(Plan, Brief):
    """Motion through via points: the durations between them, and the speeds and accelerations there.

    Attributes:
        points: positions [rad or m], shape (points, n).
        durations: of the segments [s], shape (points - 1,).
        speeds: at the points [rad/s or m/s], shape (points, n); None for rest in each.
        accelerations: at the points [rad/s^2 or m/s^2], shape (points, n); None for zero.
        segment: how it goes from point to point.
    """

    points: Array
    durations: Array
    speeds: Array | None = None
    accelerations: Array | None = None
    segment: Segment = QUINTIC

    def __post_init__(self) -> None:
        """Lock the arrays and check them."""
        object.__setattr__(self, "points", frozen_array(self.points, (None, None), "points"))
        count = len(self.points) - 1
        object.__setattr__(self, "durations", frozen_array(self.durations, (count,), "durations"))
        if count < 1 or not (self.durations > 0.0).all():
            raise ValueError("a motion needs two points and positive durations")
        for name in ("speeds", "accelerations"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, frozen_array(getattr(self, name), self.points.shape, name))
        if not (self.rests or self.segment.passes):
            raise ValueError(f"a {self.segment.name} rests in every point: leave speeds and accelerations out")

    @property
    def duration(self) -> float:
        """Time from the first to the last point [s]."""
        return float(self.durations.sum())

    @property
    def rests(self) -> bool:
        """True if the robot rests in every point."""
        return not any(x is not None and x.any() for x in (self.speeds, self.accelerations))

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Position, speed and acceleration at times [s], each (N, n); at rest before 0 and after ``duration``."""
        knots = np.concatenate([[0.0], np.cumsum(self.durations)])
        moves = ((t >= 0.0) & (t <= knots[-1]))[:, None]
        t = np.clip(t, 0.0, knots[-1])
        k = np.clip(np.searchsorted(knots, t, side="right") - 1, 0, len(self.durations) - 1)
        T = self.durations[k][:, None]
        still = np.zeros_like(self.points)
        speeds = still if self.speeds is None else self.speeds
        accelerations = still if self.accelerations is None else self.accelerations
        ends = _ends(self.points, speeds, accelerations, self.durations)
        # The step alone enters the polynomials, so that a joint that stays put does so exactly.
        start = self.points[:-1]
        ends[:, 0], ends[:, 5] = 0.0, ends[:, 5] - start
        s = np.clip((t - knots[k]) / T[:, 0], 0.0, 1.0)
        q, qd, qdd = (np.einsum("Nk,Nkn->Nn", b, ends[k]) for b in self.segment.basis(s))
        return start[k] + q, qd / T, qdd / T**2 * moves


def _ends(p: Array, v: Array, a: Array, T: Array) -> Array:
    """States p0, T v0, T^2 a0, T^2 a1, T v1, p1 at the ends of each segment, (count - 1, 6, n)."""
    t = T[:, None]
    return np.stack([p[:-1], t * v[:-1], t**2 * a[:-1], t**2 * a[1:], t * v[1:], p[1:]], axis=1)


@dataclass(frozen=True)
class ViaPointShape:
    """Shape of a motion through via points.

    Attributes:
        passing: whether it passes the inner points, or rests in each.
        samples: parts of a segment between samples while optimising, about.
        durations: shortest and longest time from point to point [s].
        fixed: the times from point to point themselves [s], count - 1 of them or one for all; None for free.
        longest: time that the whole motion may take [s]; None for any.
        start: where it begins [rad or m], n numbers; None for anywhere.
        segment: ``Quintic()``, or ``Trapezoid(ramp)``, which rests in each point.
    """

    count: int = 14
    passing: bool = True
    samples: int = 12
    durations: tuple[float, float] = (0.1, 3.0)
    fixed: float | tuple[float, ...] | None = None
    segment: Segment = QUINTIC
    longest: float | None = None
    start: tuple[float, ...] | None = None

    def family(self, robot: Robot, bounds: JointBounds) -> "FreeViaPoints":
        """Make the family of motions of this shape."""
        return FreeViaPoints(bounds, self)


class FreeViaPoints:
    """Family of segments whose q, qd and qdd are linear in the points' states for given durations.

    x holds (p - middle) / half range of the points, v / speed limit and a / acceleration limit of the inner ones,
    then log(T / 1 s) of the segments unless their durations are fixed. A given start is the first point and is not
    free. First and last point are at rest.
    """

    def __init__(self, bounds: JointBounds, shape: ViaPointShape) -> None:
        """Lay out x.

        Raises:
            InputError: if points and durations do not fit, or if the segments cannot pass points, and should; for a
                start beyond limits.
        """
        start = checked_start(bounds, shape.start)
        self.segment, self._passing, self._count = shape.segment, shape.passing, shape.count
        self._bounds, self._start, self._samples = bounds, start, shape.samples
        self.reach = bounds.low, bounds.high
        _check_count(self._count)
        self._fixed: Array | None = None
        if shape.fixed is not None:
            if shape.longest is not None:
                raise InputError(
                    "the durations of the moves are fixed: leave the longest duration of the motion out"
                )
            times, moves = np.asarray(shape.fixed, dtype=float), self._count - 1
            if times.shape not in ((), (moves,)) or not ((times > 0.0) & (times <= LONGEST)).all():
                seconds = ", ".join(f"{time:g}" for time in times.ravel())
                raise InputError(
                    f"fixed durations {seconds}: {self._count} via points need {moves} positive ones [s], or one "
                    "for all"
                )
            self._fixed = np.broadcast_to(times, (moves,)).copy()
        if self._passing and not self.segment.passes:
            raise InputError(f"a {self.segment.name} rests in every via point: set passing to False")
        self.free_duration, self._first, n = self._fixed is None, int(start is not None), len(bounds.low)
        inner = (self._count - 2) * n if self._passing else 0
        own = (self._count - self._first) * n
        self._ends = np.cumsum([own, inner, inner, self._count - 1 if self.free_duration else 0])
        self.size = int(self._ends[-1])
        self.low, self.high = -np.ones(self.size), np.ones(self.size)
        self.low[self._ends[2] :], self.high[self._ends[2] :] = np.log(shape.durations)
        self._grids: dict[int, Grid] = {}

    def random(self, draw: np.random.Generator, clear: Clear = everywhere) -> Array:
        """Draw random points, at rest in each, somewhat slower than the limits allow.

        Each is reached from the one before on a straight line if ``_TRIES`` points contain one.
        """
        bounds, n = self._bounds, len(self._bounds.low)
        on_line = np.linspace(0.0, 1.0, 21)[:, None]
        points = np.empty((self._count, n))
        if self._start is not None:
            points[0] = self._start
        for k in range(self._first, self._count):
            for _ in range(_TRIES):
                points[k] = bounds.middle + _SPAN * bounds.half * draw.uniform(-1.0, 1.0, n)
                before = points[max(k - 1, 0)]
                if self._fixed is not None and k > 0:  # as near to it as the limits allow in the time
                    T, step = self._fixed[k - 1] / _SLOWER, np.abs(points[k] - before)
                    by_speed = bounds.speed * T / (self.segment.peak_speed * step)
                    by_acceleration = bounds.acceleration * T**2 / (self.segment.peak_acceleration * step)
                    fraction = min(1.0, float(by_speed.min()), float(by_acceleration.min()))
                    points[k] = before + fraction * (points[k] - before)
                if clear(before + on_line * (points[k] - before)):
                    break
        x = np.zeros(self.size)
        x[: self._ends[0]] = ((points - bounds.middle) / bounds.half)[self._first :].ravel()
        if self.free_duration:
            times = quickest(np.diff(points, axis=0), bounds.speed, bounds.acceleration, self.segment)
            x[self._ends[2] :] = np.log(times * _SLOWER)
        return np.asarray(np.clip(x, self.low, self.high))

    def sample(self, x: Array, finer: int = 1) -> Samples:
        """Evaluate states at times of each segment, its ends included: accelerations have corners there."""
        p, v, a, T = self._unpacked(x)
        ends = _ends(p, v, a, T)
        weights, (B, Bd, Bdd) = self._grid(finer)
        step = T[:, None, None]
        q, qd, qdd = B @ ends, (Bd @ ends) / step, (Bdd @ ends) / step**2
        n = ends.shape[2]
        weight = T[:, None] * weights
        return Samples(weight.ravel(), q.reshape(-1, n), qd.reshape(-1, n), qdd.reshape(-1, n))

    def pullback(self, x: Array, slope: Samples) -> Array:
        """Apply the Jacobian transposed to the slopes."""
        p, v, a, T = self._unpacked(x)
        ends = _ends(p, v, a, T)
        weights, (B, Bd, Bdd) = self._grid(1)
        shape, step = (len(T), len(weights), ends.shape[2]), T[:, None, None]
        q, qd, qdd = slope.q.reshape(shape), slope.qd.reshape(shape) / step, slope.qdd.reshape(shape) / step**2
        by_ends = B.T @ q + Bd.T @ qd + Bdd.T @ qdd
        by_T = slope.weight.reshape(len(T), -1) @ weights
        by_T -= np.einsum("kij,kij->k", Bd.T @ qd + 2.0 * (Bdd.T @ qdd), ends) / T
        by_T += np.einsum("kij,kij,i->k", by_ends, ends, _POWERS) / T
        t, gradient = T[:, None], np.empty(self.size)
        first, second, third = self._ends[:3]
        by_p = np.zeros((len(T) + 1, by_ends.shape[2]))
        by_p[:-1] += by_ends[:, 0]
        by_p[1:] += by_ends[:, 5]
        gradient[:first] = (by_p * self._bounds.half)[self._first :].ravel()
        if self._passing:
            by_v = (t * by_ends[:, 4])[:-1] + (t * by_ends[:, 1])[1:]
            by_a = (t**2 * by_ends[:, 3])[:-1] + (t**2 * by_ends[:, 2])[1:]
            gradient[first:second] = (by_v * self._bounds.speed).ravel()
            gradient[second:third] = (by_a * self._bounds.acceleration).ravel()
        gradient[third:] = by_T * T if self.free_duration else 0.0
        return gradient

    def plan(self, x: Array) -> ViaPoints:
        """Make the motion."""
        p, v, a, T = self._unpacked(x)
        return ViaPoints(p, T, v, a) if self._passing else ViaPoints(p, T, segment=self.segment)

    def eased(self, x: Array, slower: float, smaller: float) -> Array:
        """Slow the motion by longer durations, shrink it about start or middle; at fixed durations shrink it."""
        eased, ratio = x.copy(), smaller if self.free_duration else smaller / slower
        first, second, third = self._ends[:3]
        eased[:first] = ratio * x[:first]
        if self._start is not None:
            start = (self._start - self._bounds.middle) / self._bounds.half
            eased[:first] += (1.0 - ratio) * np.tile(start, self._count - 1)
        eased[first:second] *= smaller / slower
        eased[second:third] *= smaller / slower**2 if self.free_duration else ratio
        eased[third:] += np.log(slower)
        return np.asarray(np.clip(eased, self.low, self.high)) if self.free_duration else eased

    def _grid(self, finer: int) -> Grid:
        if finer not in self._grids:
            self._grids[finer] = self.segment.grid(self._samples * finer)
        return self._grids[finer]

    def _unpacked(self, x: Array) -> tuple[Array, Array, Array, Array]:
        """Unpack points, speeds and accelerations there (count, n), durations (count - 1,)."""
        first, second, third = self._ends[:3]
        bounds, n = self._bounds, len(self._bounds.low)
        p = np.empty((self._count, n))
        p[self._first :] = bounds.middle + bounds.half * x[:first].reshape(-1, n)
        if self._start is not None:
            p[0] = self._start
        v, a = np.zeros_like(p), np.zeros_like(p)
        if self._passing:
            v[1:-1] = bounds.speed * x[first:second].reshape(-1, n)
            a[1:-1] = bounds.acceleration * x[second:third].reshape(-1, n)
        return p, v, a, np.exp(x[third:]) if self._fixed is None else self._fixed


def quickest(step: Array, speed: Array, acceleration: Array, segment: Segment = QUINTIC) -> Array:
    """Compute durations in which steps (K, n) at rest at both ends keep speeds and accelerations (n,), shape (K,).

    Raises:
        ValueError: if no limit bounds a step.
    """
    # In a time T speeds fall as 1/T and accelerations as 1/T^2.
    by_speed = segment.peak_speed * np.abs(step) / speed
    by_acceleration = np.sqrt(segment.peak_acceleration * np.abs(step) / acceleration)
    durations = np.maximum(by_speed, by_acceleration).max(axis=1)
    if not (durations > 0.0).all():
        raise ValueError("no speed or acceleration limit bounds a segment, or two points are the same")
    return np.asarray(durations)


def _check_count(count: int) -> None:
    if not 2 <= count <= _MOST:
        raise InputError(f"{count} via points: give 2 to {_MOST}, more take longer than anybody waits")


def random_points(robot: Robot, count: int, seed: int, span: float = 0.8) -> Array:
    """Draw random positions within the limits, shape (count, n).

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


def random_via_points(
    robot: Robot,
    count: int,
    seed: int,
    speed: float = 0.5,
    span: float = 0.8,
    segment: Segment = QUINTIC,
) -> ViaPoints:
    """Draw random points within the position limits, with the shortest durations.

    Args:
        robot: its joints need position and speed limits.
        speed: fraction of the speed limits to use.
        span: fraction of the position range to use, about its middle.

    Raises:
        ValueError: if a joint has no position limits.
    """
    points = random_points(robot, count, seed, span)
    limits = [joint.limits for joint in robot.joints]
    top, strong = speed * np.array([x.speed for x in limits]), np.array([x.acceleration for x in limits])
    return ViaPoints(points, quickest(np.diff(points, axis=0), top, strong, segment), segment=segment)
