"""Speeds and accelerations that a movej is given for each move, and what a controller may make of them."""

import math
from typing import NamedTuple

import numpy as np

from ....common.arrays import Array
from ....model import forward_kinematics
from ....trajectories import PointToPoint, Trapezoid, ViaPoints, plan_point_to_point
from ....trajectories.motions import plan_stops
from .written import WrittenMotion

_BLEND = 1.0 / 3.0  # of the distance to the nearer neighbour: where a passing quintic's point is left and rejoined


class Descriptor(NamedTuple):
    """How one point is approached: percentages; it is left and reached again at ``leave`` [mm], 0 for a stop."""

    accel: int
    vel: int
    leave: float = 0.0


def val3_replay(written: WrittenMotion) -> PointToPoint:
    """What a controller does with these moves if its profiles are trapezoidal: an estimate to be scored.

    Raises:
        ValueError: if two neighbouring points are the same.
    """
    plan = written.plan
    assert isinstance(plan, ViaPoints)
    moves = descriptors_of(written, plan)
    speed = 0.01 * np.array([[move.vel] for move in moves])
    accel = 0.01 * np.array([[move.accel] for move in moves])
    if plan.rests:
        return plan_stops(written.described, plan.points, speed, accel)
    at_points = np.minimum(np.vstack([accel, accel[-1:]]), np.vstack([accel[:1], accel]))
    return plan_point_to_point(written.described, plan.points, speed, at_points)


class _Nominal(NamedTuple):
    """What percentages are of, each (n,), and the most of it that the design's limits allow, in percent."""

    speed: Array
    acceleration: Array
    most_speed: int
    most_acceleration: int


def _nominal(written: WrittenMotion) -> _Nominal:
    limits = [joint.limits for joint in written.described.joints]
    top = np.array([limit.speed for limit in limits])
    strong = np.array([limit.acceleration for limit in limits])
    most = min(float((written.bounds.acceleration / strong).min()), 1.0)
    return _Nominal(top, strong, _percent(float((written.bounds.speed / top).min())), _percent(most))


def descriptors_of(written: WrittenMotion, plan: ViaPoints) -> list[Descriptor]:
    """A descriptor for each move, into its second point.

    Acceleration of a move: of trapezoidal segments by the ramp, of quintic ones as large as the limits allow.

    Speeds so that a trapezoidal profile takes the segment's time. Whole percentages, those of trapezoidal segments
    rounded within the limits, the others rounded down.
    """
    nominal = _nominal(written)
    leave = np.zeros(len(plan.points)) if plan.rests else _leave(written, plan.points)
    descriptors = []
    for k, (T, step) in enumerate(zip(plan.durations, np.abs(np.diff(plan.points, axis=0)), strict=True)):
        # As the slowest joint has them; the others follow its law.
        by_speed, by_acceleration = float((step / nominal.speed).max()), float((step / nominal.acceleration).max())
        accel, rounding = nominal.most_acceleration, 0.0
        if isinstance(plan.segment, Trapezoid):
            percent, rounding = by_acceleration * plan.segment.peak_acceleration / T**2, 0.005
            accel = min(_percent(percent + rounding), accel)
        speed = _speed(by_speed, by_acceleration / (0.01 * accel), T) if plan.rests else by_speed / T
        vel = min(_percent(speed + rounding), nominal.most_speed)
        descriptors.append(Descriptor(accel, vel, leave[k + 1]))
    return descriptors


def _speed(by_speed: float, by_acceleration: float, T: float) -> float:
    """Fraction v of the nominal speed with which a trapezoid rests at both ends and takes T; 1 if none does.

    A joint that travels d takes d / (v V) + v V / A; d / V and d / A are given.
    """
    root = T * T - 4.0 * by_acceleration  # of a / v + v b / a = T
    if root < 0.0 or by_acceleration == 0.0:
        return 1.0
    fraction = (T - math.sqrt(root)) * by_speed / (2.0 * by_acceleration)
    return min(max(fraction, 0.01), 1.0)


def _leave(written: WrittenMotion, points: Array) -> Array:
    """Distance at which each inner point is left and rejoined [mm], shape (points,)."""
    gap = _apart(written, points[:-1], points[1:])
    nearer = np.concatenate([[0.0], np.minimum(gap[:-1], gap[1:]), [0.0]])
    return np.asarray(np.floor(_BLEND * nearer))


def _apart(written: WrittenMotion, points: Array, others: Array) -> Array:
    """Distance of the last frame's origin between two poses [mm], for each of (count, n)."""
    kinematics = forward_kinematics(written.robot)
    place, other_place = (
        np.array([kinematics(q)[1].full().ravel() for q in x]).reshape(-1, 3) for x in (points, others)
    )
    return np.asarray(1000.0 * np.linalg.norm(other_place - place, axis=1))


def _percent(fraction: float) -> int:
    """Rounded down, and at least 1."""
    return max(int(100.0 * fraction + 1e-9), 1)
