"""Motions through via points by quintic or trapezoidal segments, at rest in each or passing."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array, frozen_array
from ...common.errors import InputError
from ...model import Robot
from .bounds import JointBounds
from .free_points import FreePoints, random_points
from .samples import Clear, Plan, Samples, everywhere
from .segments import QUINTIC, Grid, Segment

_SLOWER = 1.3  # start: so many times the shortest durations
_POWERS = np.array([0.0, 1.0, 2.0, 2.0, 1.0, 0.0])  # of T, that a segment's ends are multiplied with


@dataclass(frozen=True)
class ViaPoints(Plan):
    """Points to pass, the durations between them, and the speeds and accelerations there.

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
        """Whether the robot rests in every point."""
        return not any(x is not None and x.any() for x in (self.speeds, self.accelerations))

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Position, speed and acceleration at times [s], each (N, n); at rest before 0 and after ``duration``."""
        knots = np.concatenate([[0.0], np.cumsum(self.durations)])
        moves = ((t >= 0.0) & (t <= knots[-1]))[:, None]
        t = np.clip(t, 0.0, knots[-1])
        k = np.clip(np.searchsorted(knots, t, side="right") - 1, 0, len(self.durations) - 1)
        T = self.durations[k][:, None]
        # The step alone enters the polynomials, so that a joint that stays put does so exactly.
        start = self.points[k]
        ends = np.stack([np.zeros_like(start), *self._inner(k, T), np.diff(self.points, axis=0)[k]])
        s = np.clip((t - knots[k]) / T[:, 0], 0.0, 1.0)
        q, qd, qdd = (np.einsum("Nk,kNn->Nn", b, ends) for b in self.segment.basis(s))
        return start + q, qd / T, qdd / T**2 * moves

    def _inner(self, k: NDArray[np.intp], T: Array) -> tuple[Array, Array, Array, Array]:
        """T v0, T^2 a0, T^2 a1, T v1 of the segments ``k``."""
        still = np.zeros_like(self.points)
        v = still if self.speeds is None else self.speeds
        a = still if self.accelerations is None else self.accelerations
        return T * v[k], T**2 * a[k], T**2 * a[k + 1], T * v[k + 1]


@dataclass(frozen=True)
class ViaPointShape:
    """A motion through via points.

    Attributes:
        passing: whether it passes the inner points, or rests in each.
        samples: parts of a segment between samples while optimising, about.
        durations: shortest and longest time from point to point [s].
        fixed: the times from point to point themselves [s], count - 1 of them or one for all; None for free.
        segment: ``Quintic()``, or ``Trapezoid(ramp)``, which rests in each point.
    """

    count: int = 14
    passing: bool = True
    samples: int = 12
    durations: tuple[float, float] = (0.1, 3.0)
    fixed: float | tuple[float, ...] | None = None
    segment: Segment = QUINTIC

    def family(
        self, robot: Robot, bounds: JointBounds, duration: float | None = None, start: Array | None = None
    ) -> "FreeViaPoints":
        """Motions of this shape; see ``Shape``."""
        return FreeViaPoints(bounds, self, FreePoints(bounds, self.count, self.fixed, start, duration))


class FreeViaPoints:
    """Segments whose q, qd and qdd are linear in the points' states for given durations.

    x holds the points' coordinates, v / speed limit and a / acceleration limit of the points, then
    log(T / 1 s) of the segments unless their durations are fixed. First and last point are at rest.
    """

    def __init__(self, bounds: JointBounds, shape: ViaPointShape, points: FreePoints) -> None:
        """Lay out x.

        Raises:
            InputError: if the segments cannot pass points, and should.
        """
        self.segment, self._passing, count = shape.segment, shape.passing, shape.count
        if self._passing and not self.segment.passes:
            raise InputError(f"a {self.segment.name} rests in every via point: set passing to False")
        self._bounds, self._points, self._samples, self.reach = (
            bounds,
            points,
            shape.samples,
            (bounds.low, bounds.high),
        )
        self.free_duration = points.fixed is None
        inner = (count - 2) * len(bounds.low) if self._passing else 0
        self._ends = np.cumsum([points.size, inner, inner, count - 1 if self.free_duration else 0])
        self.size = int(self._ends[-1])
        self.low, self.high = -np.ones(self.size), np.ones(self.size)
        self.low[self._ends[2] :], self.high[self._ends[2] :] = np.log(shape.durations)
        self._grids: dict[int, Grid] = {}

    def random(self, draw: np.random.Generator, clear: Clear = everywhere) -> Array:
        """Random points, at rest in each, somewhat slower than the limits allow."""
        points = self._points.random(draw, clear, None if self.free_duration else self._nearer)
        x = np.zeros(self.size)
        x[: self._ends[0]] = self._points.coordinates(points)
        if self.free_duration:
            times = quickest(np.diff(points, axis=0), self._bounds.speed, self._bounds.acceleration, self.segment)
            x[self._ends[2] :] = np.log(times * _SLOWER)
        return np.asarray(np.clip(x, self.low, self.high))

    def _nearer(self, move: int, before: Array, point: Array) -> Array:
        """An end as near to a point as the limits allow in the move's fixed time."""
        assert self._points.fixed is not None
        T, step = self._points.fixed[move] / _SLOWER, np.abs(point - before)
        by_speed = self._bounds.speed * T / (self.segment.peak_speed * step)
        by_acceleration = self._bounds.acceleration * T**2 / (self.segment.peak_acceleration * step)
        share = min(1.0, float(by_speed.min()), float(by_acceleration.min()))
        return np.asarray(before + share * (point - before))

    def sample(self, x: Array, finer: int = 1) -> Samples:
        """States at times of each segment, its ends included: accelerations have corners there."""
        ends, T = self._segments(x)
        share, (B, Bd, Bdd) = self._grid(finer)
        step = T[:, None, None]
        q, qd, qdd = B @ ends, (Bd @ ends) / step, (Bdd @ ends) / step**2
        n = ends.shape[2]
        weight = T[:, None] * share
        return Samples(weight.ravel(), q.reshape(-1, n), qd.reshape(-1, n), qdd.reshape(-1, n))

    def pullback(self, x: Array, slope: Samples) -> Array:
        """The Jacobian transposed times the slopes."""
        ends, T = self._segments(x)
        share, (B, Bd, Bdd) = self._grid(1)
        shape, step = (len(T), len(share), ends.shape[2]), T[:, None, None]
        q, qd, qdd = slope.q.reshape(shape), slope.qd.reshape(shape) / step, slope.qdd.reshape(shape) / step**2
        by_ends = B.T @ q + Bd.T @ qd + Bdd.T @ qdd
        by_T = slope.weight.reshape(len(T), -1) @ share
        by_T -= np.einsum("kij,kij->k", Bd.T @ qd + 2.0 * (Bdd.T @ qdd), ends) / T
        by_T += np.einsum("kij,kij,i->k", by_ends, ends, _POWERS) / T
        return self._gathered(by_ends, by_T, T)

    def plan(self, x: Array) -> ViaPoints:
        """The motion."""
        p, v, a, T = self._unpacked(x)
        return ViaPoints(p, T, v, a) if self._passing else ViaPoints(p, T, segment=self.segment)

    def eased(self, x: Array, slower: float, smaller: float) -> Array:
        """Slower by longer durations, smaller about the start or the middle of the range; smaller at fixed ones."""
        eased, share = x.copy(), smaller if self.free_duration else smaller / slower
        first, second, third = self._ends[:3]
        eased[:first] = self._points.shrunk(x[:first], share)
        eased[first:second] *= smaller / slower
        eased[second:third] *= smaller / slower**2 if self.free_duration else share
        eased[third:] += np.log(slower)
        return np.asarray(np.clip(eased, self.low, self.high)) if self.free_duration else eased

    def _grid(self, finer: int) -> Grid:
        if finer not in self._grids:
            self._grids[finer] = self.segment.grid(self._samples * finer)
        return self._grids[finer]

    def _unpacked(self, x: Array) -> tuple[Array, Array, Array, Array]:
        """Points, speeds and accelerations there (count, n), durations (count - 1,)."""
        first, second, third = self._ends[:3]
        p = self._points.positions(x[:first])
        v, a = np.zeros_like(p), np.zeros_like(p)
        if self._passing:
            v[1:-1] = self._bounds.speed * x[first:second].reshape(-1, p.shape[1])
            a[1:-1] = self._bounds.acceleration * x[second:third].reshape(-1, p.shape[1])
        return p, v, a, np.exp(x[third:]) if self._points.fixed is None else self._points.fixed

    def _segments(self, x: Array) -> tuple[Array, Array]:
        """p0, T v0, T^2 a0, T^2 a1, T v1, p1 of each segment (count - 1, 6, n), and T."""
        p, v, a, T = self._unpacked(x)
        t = T[:, None]
        ends = np.stack([p[:-1], t * v[:-1], t**2 * a[:-1], t**2 * a[1:], t * v[1:], p[1:]], axis=1)
        return ends, T

    def _gathered(self, by_ends: Array, by_T: Array, T: Array) -> Array:
        """Slopes in x from those in the segments' ends and in T."""
        t, slope = T[:, None], np.empty(self.size)
        first, second, third = self._ends[:3]
        by_p = np.zeros((len(T) + 1, by_ends.shape[2]))
        by_p[:-1] += by_ends[:, 0]
        by_p[1:] += by_ends[:, 5]
        slope[:first] = self._points.pullback(by_p)
        if self._passing:
            by_v = (t * by_ends[:, 4])[:-1] + (t * by_ends[:, 1])[1:]
            by_a = (t**2 * by_ends[:, 3])[:-1] + (t**2 * by_ends[:, 2])[1:]
            slope[first:second] = (by_v * self._bounds.speed).ravel()
            slope[second:third] = (by_a * self._bounds.acceleration).ravel()
        slope[third:] = by_T * T if self.free_duration else 0.0
        return slope


def shortest_durations(robot: Robot, points: Array, speed: float = 1.0, segment: Segment = QUINTIC) -> Array:
    """Durations in which segments at rest at both ends keep the speed and acceleration limits, shape (points - 1,).

    Args:
        robot: its joints' limits; a joint without limits sets no bound.
        points: positions [rad or m], shape (points, n).
        speed: fraction of the speed limits to use.
        segment: how the motion goes from point to point.

    Raises:
        ValueError: if no limit bounds a segment.
    """
    top = np.array([joint.limits.speed for joint in robot.joints]) * speed
    strong = np.array([joint.limits.acceleration for joint in robot.joints])
    return quickest(np.diff(points, axis=0), top, strong, segment)


def quickest(step: Array, speed: Array, acceleration: Array, segment: Segment = QUINTIC) -> Array:
    """Durations in which steps (K, n) at rest at both ends keep speeds and accelerations (n,), shape (K,).

    Raises:
        ValueError: if no limit bounds a step.
    """
    by_speed = segment.peak_speed * np.abs(step) / speed
    by_acceleration = np.sqrt(segment.peak_acceleration * np.abs(step) / acceleration)
    durations = np.maximum(by_speed, by_acceleration).max(axis=1)
    if not (durations > 0.0).all():
        raise ValueError("no speed or acceleration limit bounds a segment, or two points are the same")
    return np.asarray(durations)


def random_via_points(
    robot: Robot,
    count: int,
    seed: int,
    speed: float = 0.5,
    span: float = 0.8,
    segment: Segment = QUINTIC,
) -> ViaPoints:
    """Random points within the position limits, with the shortest durations.

    Args:
        robot: its joints need position and speed limits.
        speed: fraction of the speed limits to use.
        span: fraction of the position range to use, about its middle.

    Raises:
        ValueError: if a joint has no position limits.
    """
    points = random_points(robot, count, seed, span)
    return ViaPoints(points, shortest_durations(robot, points, speed, segment), segment=segment)
