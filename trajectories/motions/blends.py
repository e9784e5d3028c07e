"""Straight moves through joint space with parabolic blends at the via points (LSPB).

Every joint moves at constant speed from point to point; at an inner point the speed changes from one move's to the
next one's under constant acceleration, over a time that is half before the point and half after. The motion passes
an inner point at a distance of b (v_k - v_k-1) / 8; it starts and ends in the first and last point, at rest.
Sources: Craig, Introduction to Robotics, 7.3, linear function with parabolic blends for a path with via points;
Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots, chapter 3, trapezoidal trajectory
through a sequence of points.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array, frozen_array
from ...common.errors import InputError
from ...model import Robot
from .blend_times import Times, blend_times
from .bounds import JointBounds
from .free_points import FreePoints
from .samples import Clear, Plan, Samples, everywhere
from .segments import even

_ROUNDING = 1e-9  # of a move's time: blends that overlap by less do fit
_SLOWER = 1.3  # start: so many times the shortest times
_SHARE = 0.5  # start: of the longest blends that fit between fixed times
_STRETCH, _STRAIGHT = 1.1, 0.1  # start: moves too short for their blends; at constant speed at least, of a move


@dataclass(frozen=True)
class BlendedPoints(Plan):
    """Points to pass by, the times between them, and how long the speed changes at each.

    Attributes:
        points: positions [rad or m], shape (points, n).
        durations: from the middle of one point's blend to the middle of the next one's; the first counts from the
            start, the last to the end [s], shape (points - 1,).
        blends: durations of the blends [s], shape (points,); the first and the last are the ramps from and to rest.

    Raises:
        InputError: if two blends do not fit into the move between them.
    """

    points: Array
    durations: Array
    blends: Array

    def __post_init__(self) -> None:
        """Lock the arrays and check them."""
        object.__setattr__(self, "points", frozen_array(self.points, (None, None), "points"))
        count = len(self.points)
        object.__setattr__(self, "durations", frozen_array(self.durations, (count - 1,), "durations"))
        object.__setattr__(self, "blends", frozen_array(self.blends, (count,), "blends"))
        if count < 2 or not (self.durations > 0.0).all() or not (self.blends > 0.0).all():
            raise ValueError("a motion needs two points, positive durations and positive blends")
        short = np.flatnonzero(self.straight < -_ROUNDING * self.durations)
        if len(short):
            k = int(short[0])
            raise InputError(
                f"move {k + 1} takes {self.durations[k]:.6g} s, {-self.straight[k]:.3g} s less than its blends of "
                f"{self.blends[k]:.6g} and {self.blends[k + 1]:.6g} s need: give it more time, or shorter blends"
            )

    @property
    def duration(self) -> float:
        """Time from the first to the last point [s]."""
        return float(self.durations.sum())

    @property
    def rests(self) -> bool:
        """Whether the robot rests in every point: with two points."""
        return len(self.points) == 2

    @cached_property
    def straight(self) -> Array:
        """Time at constant speed in each move [s], shape (points - 1,)."""
        return np.asarray(self._between - 0.5 * (self.blends[:-1] + self.blends[1:]))

    @cached_property
    def speeds(self) -> Array:
        """Speeds of the moves [rad/s or m/s], shape (points - 1, n)."""
        return np.asarray(np.diff(self.points, axis=0) / self._between[:, None])

    @cached_property
    def accelerations(self) -> Array:
        """Accelerations in the blends [rad/s^2 or m/s^2], shape (points, n)."""
        still = np.zeros_like(self.speeds[:1])
        return np.asarray(np.diff(self.speeds, axis=0, prepend=still, append=still) / self.blends[:, None])

    @property
    def _between(self) -> Array:
        """From the middle of one blend to the middle of the next, the first and the last included."""
        between = self.durations.copy()
        between[0] -= 0.5 * self.blends[0]
        between[-1] -= 0.5 * self.blends[-1]
        return between

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Position, speed and acceleration at times [s], each (N, n); at rest before 0 and after ``duration``.

        At a step of the acceleration its value after the step, at the end that before.
        """
        knots, q, qd, qdd = self._pieces
        moves = ((t >= 0.0) & (t <= self.duration))[:, None]
        t = np.clip(t, 0.0, self.duration)
        k = np.clip(np.searchsorted(knots, t, side="right") - 1, 0, len(knots) - 2)
        h = (t - knots[k])[:, None]
        speed = qd[k] + h * qdd[k]
        return q[k] + 0.5 * h * (qd[k] + speed), speed * moves, qdd[k] * moves

    @cached_property
    def _pieces(self) -> tuple[Array, Array, Array, Array]:
        """Knots (2 points,), and at the beginning of each piece q, qd and qdd: blend, move, blend and so on."""
        count, n = self.points.shape
        lengths = np.empty(2 * count - 1)
        lengths[::2], lengths[1::2] = self.blends, np.maximum(self.straight, 0.0)
        knots = np.concatenate([[0.0], np.cumsum(lengths)])
        knots[-1] = self.duration
        q, qd, qdd = (np.zeros((2 * count - 1, n)) for _ in range(3))
        qd[1::2], qd[2::2], qdd[::2] = self.speeds, self.speeds, self.accelerations
        half = 0.5 * self.blends[:, None]
        q[::2] = self.points - half * qd[::2]
        q[1::2] = self.points[:-1] + half[:-1] * self.speeds
        return knots, q, qd, qdd


@dataclass(frozen=True)
class BlendShape:
    """Moves at constant speed that blend into each other about the via points, ``BlendedPoints``.

    Attributes:
        samples: parts of a move and a blend together between samples while optimising.
        durations: shortest and longest time from point to point [s].
        fixed: the times from point to point themselves [s], count - 1 of them or one for all; None for free.
    """

    count: int = 14
    samples: int = 12
    durations: tuple[float, float] = (0.1, 3.0)
    fixed: float | tuple[float, ...] | None = None

    def family(
        self, robot: Robot, bounds: JointBounds, duration: float | None = None, start: Array | None = None
    ) -> "FreeBlends":
        """Motions of this shape; see ``Shape``."""
        return FreeBlends(bounds, self, FreePoints(bounds, self.count, self.fixed, start, duration))


class FreeBlends:
    """Moves at constant speed between parabolic blends, ``BlendedPoints``.

    x holds the points' coordinates, then what the times depend on (blend_times.py). A phase is a blend or the
    constant part of a move, in turn; every phase has the same number of samples.
    """

    def __init__(self, bounds: JointBounds, shape: BlendShape, points: FreePoints) -> None:
        """Lay out x."""
        self._bounds, self._points, self._parts = bounds, points, max(shape.samples // 2, 1)
        self.free_duration = points.fixed is None
        self.reach, self._times = (bounds.low, bounds.high), blend_times(shape.count, shape.durations, points.fixed)
        self.size = points.size + len(self._times.low)
        self.low = np.concatenate([-np.ones(points.size), self._times.low])
        self.high = np.concatenate([np.ones(points.size), self._times.high])

    def random(self, draw: np.random.Generator, clear: Clear = everywhere) -> Array:
        """Random points, somewhat slower than the limits allow."""
        points = self._points.random(draw, clear, None if self.free_duration else self._nearer)
        times = np.full(len(self._times.low), _SHARE)
        if self.free_duration:
            times = np.log(np.concatenate(self._unhurried(points)))
        return np.asarray(np.clip(np.concatenate([self._points.coordinates(points), times]), self.low, self.high))

    def _unhurried(self, points: Array) -> Times:
        """Times that the limits allow."""
        step = np.diff(points, axis=0)
        between = _SLOWER * (np.abs(step) / self._bounds.speed).max(axis=1)
        while True:
            still = np.zeros_like(step[:1])
            change = np.abs(np.diff(step / between[:, None], axis=0, prepend=still, append=still))
            blends = _SLOWER * (change / self._bounds.acceleration).max(axis=1)
            straight = between - 0.5 * (blends[:-1] + blends[1:])
            short = straight < _STRAIGHT * between
            if not short.any():
                return Times(straight, blends)
            between = np.where(short, _STRETCH * between, between)

    def _nearer(self, move: int, before: Array, point: Array) -> Array:
        """An end as near to a point as the limits allow in the move's fixed time, whatever the next move does."""
        times = self._times.of(np.full(len(self._times.low), _SHARE))
        strong = 0.5 * self._bounds.acceleration * times.blends[move : move + 2].min()
        speed = np.minimum(self._bounds.speed, strong) / _SLOWER
        share = (speed * times.between[move] / np.abs(point - before)).min()
        return np.asarray(before + min(1.0, float(share)) * (point - before))

    def sample(self, x: Array, finer: int = 1) -> Samples:
        """States in every phase, its ends included: both sides of each step of the acceleration."""
        p, times = self._unpacked(x)
        s, share = self._grid(finer)
        k, u, w = self._phases(p, times)
        into, out = times.coefficients(s)
        states = np.einsum("ofs,fj->ofsj", into, u) + np.einsum("ofs,fj->ofsj", out, w)
        states[0] += p[k, None]
        q, qd, qdd = states.reshape(3, -1, p.shape[1])
        return Samples(np.outer(times.phases, share).ravel(), q, qd, qdd)

    def pullback(self, x: Array, slope: Samples) -> Array:
        """The Jacobian transposed times the slopes: through the states, the speeds of the moves and the times."""
        p, times = self._unpacked(x)
        s, share = self._grid(1)
        k, u, w = self._phases(p, times)
        into, out = times.coefficients(s)
        by_state = np.stack(slope[1:]).reshape(3, len(k), len(s), -1)
        by_speed, by_p = np.zeros((len(p) + 1, p.shape[1])), np.zeros_like(p)
        np.add.at(by_speed, k, np.einsum("ofs,ofsj->fj", into, by_state))
        np.add.at(by_speed, k + 1, np.einsum("ofs,ofsj->fj", out, by_state))
        np.add.at(by_p, k, by_state[0].sum(axis=1))
        by_step = by_speed[1:-1] / times.between[:, None]
        by_p[1:] += by_step
        by_p[:-1] -= by_step
        by_between = -(by_step * w[::2][:-1]).sum(axis=1)
        by_straight, by_blends = times.pullback(
            s, np.einsum("ofsj,fj->ofs", by_state, u), np.einsum("ofsj,fj->ofs", by_state, w)
        )
        by_phase = slope.weight.reshape(len(k), -1) @ share
        by_straight += by_between + by_phase[1::2]
        by_blends += by_phase[::2]
        by_blends[:-1] += 0.5 * by_between
        by_blends[1:] += 0.5 * by_between
        by_times = self._times.pullback(x[self._points.size :], Times(by_straight, by_blends))
        return np.concatenate([self._points.pullback(by_p), by_times])

    def plan(self, x: Array) -> BlendedPoints:
        """The motion."""
        p, times = self._unpacked(x)
        return BlendedPoints(p, times.durations if self._points.fixed is None else self._points.fixed, times.blends)

    def eased(self, x: Array, slower: float, smaller: float) -> Array:
        """Slower by longer times, smaller about the middle of the range or the start; with fixed times smaller."""
        eased, points = x.copy(), self._points.size
        eased[:points] = self._points.shrunk(x[:points], smaller if self.free_duration else smaller / slower)
        if self.free_duration:
            eased[points:] += np.log(slower)
        return np.asarray(np.clip(eased, self.low, self.high))

    def _grid(self, finer: int) -> tuple[Array, Array]:
        """Shares of a phase's time at its samples, and the time each stands for, shape (parts + 1,)."""
        parts = self._parts * finer
        return np.linspace(0.0, 1.0, parts + 1), even(parts)

    def _unpacked(self, x: Array) -> tuple[Array, Times]:
        """Points (count, n) and times."""
        return self._points.positions(x[: self._points.size]), self._times.of(x[self._points.size :])

    def _phases(self, p: Array, times: Times) -> tuple[NDArray[np.intp], Array, Array]:
        """Each phase's point, and the speeds of the moves to and from it, (phases, n); 0 where there is none."""
        still = np.zeros_like(p[:1])
        speed = np.vstack([still, np.diff(p, axis=0) / times.between[:, None], still])
        k = np.arange(2 * len(p) - 1) // 2
        return k, speed[k], speed[k + 1]
