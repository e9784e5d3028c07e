"""Motions through via points by quintic or trapezoidal segments, at rest in each or passing."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..common.arrays import Array, frozen_array
from ..model import Motion, Robot
from .point_to_point import random_points
from .segments import QUINTIC, Segment


@dataclass(frozen=True)
class ViaPoints:
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

    def motion(self, rate: float) -> Motion:
        """Sample the motion at ``rate`` [Hz]."""
        t = np.arange(int(self.duration * rate) + 1) / rate
        return Motion(t, *self.at(t))

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
    step = np.abs(np.diff(points, axis=0))
    top = np.array([joint.limits.speed for joint in robot.joints]) * speed
    strong = np.array([joint.limits.acceleration for joint in robot.joints])
    by_speed = segment.peak_speed * step / top
    by_acceleration = np.sqrt(segment.peak_acceleration * step / strong)
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
        count: number of points.
        seed: of the random numbers.
        speed: fraction of the speed limits to use.
        span: fraction of the position range to use, about its middle.
        segment: how the motion goes from point to point.

    Raises:
        ValueError: if a joint has no position limits.
    """
    points = random_points(robot, count, seed, span)
    return ViaPoints(points, shortest_durations(robot, points, speed, segment), segment=segment)
