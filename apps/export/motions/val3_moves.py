"""Speeds, accelerations and blends that a movej is given for each move, and what a controller may make of them."""

import math
from typing import NamedTuple

import numpy as np

from ....common.arrays import Array
from ....model import forward_kinematics
from ....trajectories import BlendedPoints, PointToPoint, Trapezoid, ViaPoints, plan_point_to_point
from ....trajectories.motions.point_to_point import plan_stops
from .written import WrittenMotion

_BLEND = 1.0 / 3.0  # of the distance to the nearer neighbour: where a passing quintic's point is left and rejoined
_NEAREST = 0.1  # mm: smallest leave and reach of a point that is passed


class Descriptor(NamedTuple):
    """How one point is approached: percentages; ``leave`` and ``reach`` [mm], 0 for no blending there."""

    accel: int
    vel: int
    decel: int
    leave: float = 0.0
    reach: float = 0.0


def descriptors_of(written: WrittenMotion, plan: ViaPoints | BlendedPoints) -> list[Descriptor]:
    """A descriptor for each move, into its second point."""
    return _blended(written, plan) if isinstance(plan, BlendedPoints) else _through(written, plan)


def val3_replay(written: WrittenMotion) -> PointToPoint:
    """What a controller does with these moves if its profiles are trapezoidal: an estimate to be scored.

    Raises:
        ValueError: if two neighbouring points are the same.
    """
    plan = written.plan
    assert isinstance(plan, ViaPoints | BlendedPoints)
    moves = descriptors_of(written, plan)
    speed = 0.01 * np.array([[move.vel] for move in moves])
    into, out = (
        0.01 * np.array([[x] for x in own]) for own in zip(*((m.accel, m.decel) for m in moves), strict=True)
    )
    if plan.rests:
        return plan_stops(written.described, plan.points, speed, into)
    at_points = np.minimum(np.vstack([into, out[-1:]]), np.vstack([into[:1], out]))
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


def _through(written: WrittenMotion, plan: ViaPoints) -> list[Descriptor]:
    """Acceleration of a move: of trapezoidal segments by the ramp, of quintic ones as large as the limits allow.

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
        descriptors.append(Descriptor(accel, vel, accel, leave[k + 1], leave[k + 1]))
    return descriptors


def _blended(written: WrittenMotion, plan: BlendedPoints) -> list[Descriptor]:
    """Speeds of the moves and accelerations of the blends at their ends, rounded within the limits.

    A point is left where the blend about it begins and reached again where it ends.
    """
    nominal, half = _nominal(written), 0.5 * plan.blends[:, None]
    vel = [_percent(x + 0.005) for x in (np.abs(plan.speeds) / nominal.speed).max(axis=1)]
    accel = [_percent(x + 0.005) for x in (np.abs(plan.accelerations) / nominal.acceleration).max(axis=1)]
    leave, reach = np.zeros((2, len(plan.points)))
    inner = plan.points[1:-1]
    leave[1:-1] = _rounded(_apart(written, inner, inner - half[1:-1] * plan.speeds[:-1]))
    reach[1:-1] = _rounded(_apart(written, inner, inner + half[1:-1] * plan.speeds[1:]))
    return [
        Descriptor(
            min(accel[k], nominal.most_acceleration),
            min(speed, nominal.most_speed),
            min(accel[k + 1], nominal.most_acceleration),
            leave[k + 1],
            reach[k + 1],
        )
        for k, speed in enumerate(vel)
    ]


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


def _rounded(distance: Array) -> Array:
    """Down to 0.1 mm; no less than that, which would be a stop."""
    return np.asarray(np.maximum(np.floor(10.0 * distance) / 10.0, _NEAREST))


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
