"""Point-to-point motions: within the limits, at rest at the ends, derivatives exact, points passed or reached."""

import numpy as np
import pytest
from dynident.model import Joint, Limits, Robot, load_robot
from dynident.tests.report.motions.motion_parsers import trapezoid_time
from dynident.trajectories import PointToPoint, plan_point_to_point
from dynident.trajectories.motions.point_to_point import plan_stops
from dynident.trajectories.motions.via_points import random_points
from hypothesis import given
from hypothesis import strategies as st

RX90 = load_robot("rx90")


@given(
    seed=st.integers(0, 10_000),
    speed=st.floats(0.1, 1.0),
    acceleration=st.floats(0.1, 1.0),
    blend=st.floats(0.0, 1.0),
    smoothing=st.floats(0.05, 0.5),
)
def test_limits_are_kept(seed: int, speed: float, acceleration: float, blend: float, smoothing: float) -> None:
    points = random_points(RX90, 8, seed)
    motion = plan_point_to_point(RX90, points, speed, acceleration, blend, smoothing).motion(500.0)
    for j, joint in enumerate(RX90.joints):
        # A blend cuts corners, it never goes beyond the points.
        assert points[:, j].min() - 1e-9 <= motion.q[:, j].min()
        assert motion.q[:, j].max() <= points[:, j].max() + 1e-9
        assert np.abs(motion.qd[:, j]).max() <= speed * joint.limits.speed * (1 + 1e-9)
        assert np.abs(motion.qdd[:, j]).max() <= acceleration * joint.limits.acceleration * (1 + 1e-9)


def test_a_motion_is_as_quick_as_some_limit_allows() -> None:
    motion = plan_point_to_point(RX90, random_points(RX90, 8, 0), speed=0.5, acceleration=0.5).motion(2000.0)
    top = np.array([joint.limits.speed for joint in RX90.joints])
    strong = np.array([joint.limits.acceleration for joint in RX90.joints])
    assert (np.abs(motion.qd) / (0.5 * top)).max() == pytest.approx(1.0, abs=1e-3)
    assert (np.abs(motion.qdd) / (0.5 * strong)).max() == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("blend", [0.0, 0.3, 1.0])
def test_starts_and_ends_at_rest_and_derivatives_are_derivatives(blend: float) -> None:
    points = random_points(RX90, 6, 3)
    plan = plan_point_to_point(RX90, points, blend=blend)
    t = np.linspace(0.0, plan.duration, 200_001)
    q, qd, qdd = plan.at(t)
    assert np.allclose(q[[0, -1]], points[[0, -1]], atol=1e-11)
    assert np.allclose(qd[[0, -1]], 0.0, atol=1e-11)
    assert np.allclose(qdd[[0, -1]], 0.0, atol=1e-9)
    for value, slope in ((q, qd), (qd, qdd)):
        difference = np.gradient(value, t, axis=0)
        assert np.abs(difference - slope)[1:-1].max() < 2e-3 * np.abs(slope).max()
    beyond = plan.at(np.array([-1.0, plan.duration + 1.0]))
    assert np.allclose(beyond[0], points[[0, -1]], atol=1e-11)


def test_stops_run_each_move_by_its_own_law() -> None:
    """Speeds and accelerations reached in every move are its own; without smoothing it is a trapezoid's time."""
    points, draw = random_points(RX90, 6, 2), np.random.default_rng(0)
    speed, acceleration = draw.uniform(0.1, 1.0, (2, 5, 1))
    limits = [joint.limits for joint in RX90.joints]
    V, A = np.array([x.speed for x in limits]), np.array([x.acceleration for x in limits])
    plan = plan_stops(RX90, points, speed, acceleration)
    ends = np.concatenate([[0.0], np.cumsum(plan.durations + plan.ramps[:, 0])])
    assert plan.duration == pytest.approx(ends[-1])
    for k in range(5):
        q, qd, qdd = plan.at(np.linspace(ends[k], ends[k + 1], 20_001))
        assert np.allclose(q[[0, -1]], points[k : k + 2], atol=1e-9)
        assert np.allclose(qd[[0, -1]], 0.0, atol=1e-6)
        shares = (np.abs(qd) / V).max() / speed[k, 0], (np.abs(qdd) / A).max() / acceleration[k, 0]
        assert max(shares) <= 1.0 + 1e-9
        assert shares[1] == pytest.approx(1.0, abs=1e-3)
    sharp = plan_stops(RX90, points, speed, acceleration, smoothing=1e-6)
    step = np.abs(np.diff(points, axis=0))
    times = [trapezoid_time(step[k], speed[k] * V, acceleration[k] * A) for k in range(5)]
    assert sharp.duration >= sum(times) * (1.0 - 1e-9)
    assert sharp.duration == pytest.approx(sum(times), rel=0.05), "one law for all joints is hardly slower"


def test_without_blending_every_point_is_reached_at_rest() -> None:
    points = random_points(RX90, 6, 1)
    plan = plan_point_to_point(RX90, points, blend=0.0)
    q, qd, _ = plan.at(np.linspace(0.0, plan.duration, 100_001))
    for point in points:
        nearest = np.abs(q - point).max(axis=1).argmin()
        assert np.abs(q[nearest] - point).max() < 1e-5
        assert np.abs(qd[nearest]).max() < 1e-2


def test_blending_saves_time_and_does_not_stop() -> None:
    points = random_points(RX90, 6, 1)
    slow, quick = (plan_point_to_point(RX90, points, blend=blend) for blend in (0.0, 1.0))
    assert quick.duration < slow.duration
    inside = np.linspace(0.1 * quick.duration, 0.9 * quick.duration, 5000)
    assert np.abs(quick.at(inside)[1]).max(axis=1).min() > 0.05


def test_short_moves_are_made_longer_than_their_ramps() -> None:
    points = np.array([[0.0] * 6, [1e-3] * 6, [0.0] * 6])
    plan = plan_point_to_point(RX90, points)
    assert (plan.durations >= 0.5 * (plan.ramps[1:] + plan.ramps[:-1])).all()


def test_torque_does_not_jump() -> None:
    """The acceleration is continuous."""
    plan = plan_point_to_point(RX90, random_points(RX90, 6, 2))
    qdd = plan.motion(20_000.0).qdd
    assert np.abs(np.diff(qdd, axis=0)).max() < 0.01 * np.abs(qdd).max()


def test_what_cannot_be_a_motion_is_refused() -> None:
    with pytest.raises(ValueError, match="two points and positive ramps"):
        PointToPoint(np.zeros((1, 2)), np.zeros(0), np.ones(1))
    with pytest.raises(ValueError, match="shorter than its ramps"):
        PointToPoint(np.zeros((2, 2)), np.ones(1), np.full(2, 3.0))
    with pytest.raises(ValueError, match="blend must be"):
        PointToPoint(np.zeros((2, 2)), np.ones(1), np.ones(2), blend=1.5)
    with pytest.raises(ValueError, match="two points are the same"):
        plan_point_to_point(RX90, np.zeros((2, 6)))
    free = Robot("free", (Joint(limits=Limits(speed=1.0)),))
    with pytest.raises(ValueError, match="bounds a move"):
        plan_point_to_point(free, np.array([[0.0], [1.0]]))
    with pytest.raises(ValueError, match="without position limits"):
        random_points(free, 5, 0)
