"""Via-point motions: through the points, at rest there, within the limits, derivatives exact."""

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.model import Joint, Robot, load_robot
from dynident.trajectories import Task, ViaPoints, random_via_points, run_experiment
from dynident.trajectories.motions.via_points import quickest
from dynident.trajectories.simulation.disturbances import no_disturbances
from hypothesis import given, settings
from hypothesis import strategies as st


@given(st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_random_motions_keep_the_limits(seed: int) -> None:
    robot = load_robot("rx90")
    motion = random_via_points(robot, 8, seed, speed=0.5).motion(500.0)
    for j, joint in enumerate(robot.joints):
        low, high = joint.limits.position
        assert low <= motion.q[:, j].min()
        assert motion.q[:, j].max() <= high
        assert np.abs(motion.qd[:, j]).max() <= 0.5 * joint.limits.speed * (1 + 1e-9)
        assert np.abs(motion.qdd[:, j]).max() <= joint.limits.acceleration * (1 + 1e-9)


def test_some_limit_is_reached() -> None:
    robot = load_robot("rx90")
    motion = random_via_points(robot, 8, 0).motion(2000.0)
    top = np.array([joint.limits.speed for joint in robot.joints])
    strong = np.array([joint.limits.acceleration for joint in robot.joints])
    share = max((np.abs(motion.qd) / (0.5 * top)).max(), (np.abs(motion.qdd) / strong).max())
    assert share == pytest.approx(1.0, abs=1e-3)


def test_passes_the_points_at_rest_and_derivatives_are_derivatives() -> None:
    via = ViaPoints(np.array([[0.0, 1.0], [1.0, -1.0], [0.5, 0.0]]), np.array([1.0, 2.0]))
    motion = via.motion(1000.0)
    for k, point in ((0, via.points[0]), (1000, via.points[1]), (3000, via.points[2])):
        assert np.allclose(motion.q[k], point, atol=1e-12)
        assert np.allclose(motion.qd[k], 0.0, atol=1e-12)
    for value, slope in ((motion.q, motion.qd), (motion.qd, motion.qdd)):
        difference = np.gradient(value, motion.t, axis=0)
        assert np.abs(difference - slope)[5:-5].max() < 2e-2 * np.abs(slope).max()


def test_same_seed_same_motion() -> None:
    robot = load_robot("rx90")
    assert np.array_equal(random_via_points(robot, 5, 3).points, random_via_points(robot, 5, 3).points)
    assert not np.array_equal(random_via_points(robot, 5, 3).points, random_via_points(robot, 5, 4).points)


def test_what_cannot_be_a_motion_is_refused() -> None:
    with pytest.raises(ValueError, match="two points"):
        ViaPoints(np.zeros((1, 2)), np.zeros(0))
    with pytest.raises(ValueError, match="positive durations"):
        ViaPoints(np.zeros((2, 2)), np.zeros(1))
    with pytest.raises(ValueError, match="no speed or acceleration limit"):
        quickest(np.zeros((1, 6)), np.ones(6), np.ones(6))
    with pytest.raises(ValueError, match="without position limits"):
        random_via_points(Robot("free", (Joint(),)), 5, 0)


def test_a_motion_of_too_many_samples_is_refused() -> None:
    """Before memory is asked for."""
    robot = load_robot("rx90")
    motion = random_via_points(robot, 3, seed=0)
    with pytest.raises(InputError, match="more than 10000000 samples"):
        motion.motion(1e12)
    slow = ViaPoints(motion.points, np.full(2, 1e9))
    with pytest.raises(InputError, match="more than 10000000 samples"):
        run_experiment(robot, [Task("slow", slow)], no_disturbances(6))
