"""Motions through points and samples: within the limits, at rest at the ends, derivatives exact; or refused."""

from itertools import pairwise

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.model import Motion, load_robot
from dynident.tests.report.motions.motion_parsers import trapezoid_time
from dynident.trajectories import (
    SampledTrajectory,
    plan_point_to_point,
    random_via_points,
)
from dynident.trajectories.motions.point_to_point import plan_stops
from dynident.trajectories.motions.sampled import joined
from dynident.trajectories.motions.via_points import random_points
from hypothesis import given, settings
from hypothesis import strategies as st

RX90 = load_robot("rx90")
LIMITS = [joint.limits for joint in RX90.joints]
TOP, STRONG = np.array([(limits.speed, limits.acceleration) for limits in LIMITS]).T


def peaks(motion: Motion) -> tuple[float, float]:
    """Largest share of a joint's speed and of its acceleration."""
    return float((np.abs(motion.qd) / TOP).max()), float((np.abs(motion.qdd) / STRONG).max())


def assert_derivatives(t: Array, *states: Array, share: float) -> None:
    for value, slope in pairwise(states):
        difference = np.gradient(value, t, axis=0)
        assert np.abs(difference - slope)[5:-5].max() < share * np.abs(slope).max()


@given(st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_random_via_points_keep_the_limits(seed: int) -> None:
    motion = random_via_points(RX90, 8, seed, speed=0.5).motion(500.0)
    low, high = np.array([limits.position for limits in LIMITS]).T
    assert (low <= motion.q).all()
    assert (motion.q <= high).all()
    speed, acceleration = peaks(motion)
    assert speed <= 0.5 * (1 + 1e-9)
    assert acceleration <= 1 + 1e-9


@given(
    seed=st.integers(0, 10_000),
    speed=st.floats(0.1, 1.0),
    acceleration=st.floats(0.1, 1.0),
    blend=st.floats(0.0, 1.0),
    smoothing=st.floats(0.05, 0.5),
)
def test_moves_from_point_to_point_keep_the_limits(
    seed: int, speed: float, acceleration: float, blend: float, smoothing: float
) -> None:
    """A blend cuts corners, it never goes beyond the points."""
    points = random_points(RX90, 8, seed)
    motion = plan_point_to_point(RX90, points, speed, acceleration, blend, smoothing).motion(500.0)
    assert (points.min(axis=0) - 1e-9 <= motion.q).all()
    assert (motion.q <= points.max(axis=0) + 1e-9).all()
    fastest, strongest = peaks(motion)
    assert fastest <= speed * (1 + 1e-9)
    assert strongest <= acceleration * (1 + 1e-9)


@pytest.mark.parametrize("blend", [0.0, 0.3, 1.0])
def test_starts_and_ends_at_rest_and_derivatives_are_derivatives(blend: float) -> None:
    points = random_points(RX90, 6, 3)
    plan = plan_point_to_point(RX90, points, blend=blend)
    t = np.linspace(0.0, plan.duration, 200_001)
    q, qd, qdd = plan.at(t)
    assert np.allclose(q[[0, -1]], points[[0, -1]], atol=1e-11)
    assert np.allclose(qd[[0, -1]], 0.0, atol=1e-11)
    assert np.allclose(qdd[[0, -1]], 0.0, atol=1e-9)
    assert_derivatives(t, q, qd, qdd, share=2e-3)
    beyond = plan.at(np.array([-1.0, plan.duration + 1.0]))
    assert np.allclose(beyond[0], points[[0, -1]], atol=1e-11)


def test_stops_run_each_move_by_its_own_law() -> None:
    """Speeds and accelerations reached in every move are its own; without smoothing it is a trapezoid's time."""
    points, draw = random_points(RX90, 6, 2), np.random.default_rng(0)
    speed, acceleration = draw.uniform(0.1, 1.0, (2, 5, 1))
    plan = plan_stops(RX90, points, speed, acceleration)
    ends = np.concatenate([[0.0], np.cumsum(plan.durations + plan.ramps[:, 0])])
    assert plan.duration == pytest.approx(ends[-1])
    for k in range(5):
        t = np.linspace(ends[k], ends[k + 1], 20_001)
        q, qd, qdd = plan.at(t)
        assert np.allclose(q[[0, -1]], points[k : k + 2], atol=1e-9)
        assert np.allclose(qd[[0, -1]], 0.0, atol=1e-6)
        shares = np.array(peaks(Motion(t, q, qd, qdd))) / (speed[k, 0], acceleration[k, 0])
        assert shares.max() <= 1.0 + 1e-9
        assert shares[1] == pytest.approx(1.0, abs=1e-3)
    sharp = plan_stops(RX90, points, speed, acceleration, smoothing=1e-6)
    step = np.abs(np.diff(points, axis=0))
    times = [trapezoid_time(step[k], speed[k] * TOP, acceleration[k] * STRONG) for k in range(5)]
    assert sharp.duration >= sum(times) * (1.0 - 1e-9)
    assert sharp.duration == pytest.approx(sum(times), rel=0.05), "one law for all joints is hardly slower"


T = np.linspace(0.0, 2.0, 201)


def bump(t: Array) -> tuple[Array, Array, Array]:
    """(1 - cos)^2 and its derivatives: at rest at 0 and 2 s."""
    c, s, w, shape = np.cos(np.pi * t), np.sin(np.pi * t), np.pi, np.array([0.5, -0.3])
    q, qd = (1.0 - c) ** 2, 2.0 * w * s * (1.0 - c)
    qdd = 2.0 * w**2 * (c * (1.0 - c) + s**2)
    return np.outer(q, shape), np.outer(qd, shape), np.outer(qdd, shape)


@pytest.mark.parametrize(
    ("derivatives", "tolerances"), [(1, (1e-9, 1e-7, 1e-4)), (2, (1e-7, 1e-5, 5e-3)), (3, (1e-11, 1e-9, 1e-6))]
)
def test_between_samples_it_is_the_motion(derivatives: int, tolerances: tuple[float, ...]) -> None:
    """With positions alone, with speeds, and with accelerations too; it rests before and after."""
    q, qd, qdd = bump(T)
    trajectory = SampledTrajectory(T + 5.0, q, qd if derivatives > 1 else None, qdd if derivatives > 2 else None)
    assert trajectory.duration == pytest.approx(2.0)
    fine = np.linspace(0.0, 2.0, 3001)
    for values, true, tolerance in zip(trajectory.at(fine), bump(fine), tolerances, strict=True):
        assert np.abs(values - true).max() < tolerance * np.abs(true).max()
    q, qd, qdd = trajectory.at(np.array([-1.0, 3.0]))
    assert np.allclose(q, bump(np.array([0.0, 2.0]))[0])
    assert not qd.any()
    assert not qdd.any()


@pytest.mark.parametrize("rate", [50.0, 1000.0])
def test_sparse_samples_are_joined_to_the_motion(rate: float) -> None:
    """Every sample stays, none lies farther from the next than asked; dense ones are left as they are."""
    few = np.unique(np.concatenate([T[::5], [0.731, 1.999]]))
    motion = Motion(few + 3.0, *bump(few))
    dense = joined(motion, rate)
    stays = np.isin(dense.t, motion.t)
    assert stays.sum() == len(few)
    for own, more in zip((motion.q, motion.qd, motion.qdd), (dense.q, dense.qd, dense.qdd), strict=True):
        assert np.allclose(own, more[stays], atol=1e-12)
    assert np.diff(dense.t).max() <= (1.0 + 1e-5) / rate
    for values, true, tolerance in zip(
        (dense.q, dense.qd, dense.qdd), bump(dense.t - 3.0), (1e-6, 1e-5, 1e-3), strict=True
    ):
        assert np.abs(values - true).max() < tolerance * np.abs(true).max()
    assert joined(dense, rate) is dense


def test_samples_within_the_limits_are_taken() -> None:
    motion = plan_point_to_point(RX90, random_points(RX90, 4, 0), speed=1.0, acceleration=0.9).motion(250.0)
    SampledTrajectory(motion.t, motion.q, motion.qd, motion.qdd).check_limits(RX90)
