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

from ..common.arrays import Array, frozen_array
from ..common.errors import InputError
from ..model import Motion

_ROUNDING = 1e-9  # of a move's time: blends that overlap by less do fit


@dataclass(frozen=True)
class BlendedPoints:
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
        """Of the moves [rad/s or m/s], shape (points - 1, n)."""
        return np.asarray(np.diff(self.points, axis=0) / self._between[:, None])

    @cached_property
    def accelerations(self) -> Array:
        """In the blends [rad/s^2 or m/s^2], shape (points, n)."""
        still = np.zeros_like(self.speeds[:1])
        return np.asarray(np.diff(self.speeds, axis=0, prepend=still, append=still) / self.blends[:, None])

    @property
    def _between(self) -> Array:
        """From the middle of one blend to the middle of the next, the first and the last included."""
        between = self.durations.copy()
        between[0] -= 0.5 * self.blends[0]
        between[-1] -= 0.5 * self.blends[-1]
        return between

    def motion(self, rate: float) -> Motion:
        """Sample the motion at ``rate`` [Hz]."""
        t = np.arange(int(self.duration * rate) + 1) / rate
        return Motion(t, *self.at(t))

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
