"""Motions through via points, at rest in each, by quintic segments."""

from dataclasses import dataclass

import numpy as np

from ..model import Motion, Robot
from ..model.arrays import Array, frozen_array
from .point_to_point import random_points

_PEAK_SPEED = 15.0 / 8.0  # of a quintic from 0 to 1 in unit time
_PEAK_ACCELERATION = 10.0 / np.sqrt(3.0)


@dataclass(frozen=True)
class ViaPoints:
    """Points to pass and the durations between them.

    Attributes:
        points: positions [rad or m], shape (points, n).
        durations: of the segments [s], shape (points - 1,).
    """

    points: Array
    durations: Array

    def __post_init__(self) -> None:
        """Lock the arrays and check them."""
        object.__setattr__(self, "points", frozen_array(self.points, (None, None), "points"))
        count = len(self.points) - 1
        object.__setattr__(self, "durations", frozen_array(self.durations, (count,), "durations"))
        if count < 1 or not (self.durations > 0.0).all():
            raise ValueError("a motion needs two points and positive durations")

    def motion(self, rate: float) -> Motion:
        """Sample the motion at ``rate`` [Hz]; it starts and ends at rest."""
        knots = np.concatenate([[0.0], np.cumsum(self.durations)])
        t = np.arange(int(knots[-1] * rate) + 1) / rate
        k = np.clip(np.searchsorted(knots, t, side="right") - 1, 0, len(self.durations) - 1)
        T = self.durations[k][:, None]
        s = ((t - knots[k])[:, None]) / T
        step = np.diff(self.points, axis=0)[k]
        q = self.points[k] + step * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        qd = step / T * 30.0 * s**2 * (1.0 - s) ** 2
        qdd = step / T**2 * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s)
        return Motion(t, q, qd, qdd)


def shortest_durations(robot: Robot, points: Array, speed: float = 1.0) -> Array:
    """Durations in which quintic segments keep the speed and acceleration limits, shape (points - 1,).

    Args:
        robot: its joints' limits; a joint without limits sets no bound.
        points: positions [rad or m], shape (points, n).
        speed: fraction of the speed limits to use.

    Raises:
        ValueError: if no limit bounds a segment.
    """
    step = np.abs(np.diff(points, axis=0))
    top = np.array([joint.limits.speed for joint in robot.joints]) * speed
    strong = np.array([joint.limits.acceleration for joint in robot.joints])
    by_speed = _PEAK_SPEED * step / top
    by_acceleration = np.sqrt(_PEAK_ACCELERATION * step / strong)
    durations = np.maximum(by_speed, by_acceleration).max(axis=1)
    if not (durations > 0.0).all():
        raise ValueError("no speed or acceleration limit bounds a segment, or two points are the same")
    return np.asarray(durations)


def random_via_points(robot: Robot, count: int, seed: int, speed: float = 0.5, span: float = 0.8) -> ViaPoints:
    """Random points within the position limits, with the shortest durations.

    Args:
        robot: its joints need position and speed limits.
        count: number of points.
        seed: of the random numbers.
        speed: fraction of the speed limits to use.
        span: fraction of the position range to use, about its middle.

    Raises:
        ValueError: if a joint has no position limits.
    """
    points = random_points(robot, count, seed, span)
    return ViaPoints(points, shortest_durations(robot, points, speed))
