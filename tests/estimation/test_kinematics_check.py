"""Proof of the kinematics from a log: tool poses, and readings ranked by the unloaded residual."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.estimation.diagnosis.kinematics import Reading, Readings, ToolPoses, check_pose, rank_readings
from dynident.model import Pose, Recording, Robot, load_robot
from dynident.model.frames import frames_at
from dynident.trajectories import Simulator, random_via_points

WORLD = Pose.from_rpy((1.0, -0.5, 0.3), (0.2, -0.1, 2.0))
TOOL = Pose.from_rpy((0.05, -0.02, 0.15), (0.5, 0.4, -1.0))


def logged(robot: Robot, q: Array) -> ToolPoses:
    """Tool poses as a controller would log them: seen from another frame, at a tool."""
    poses = [WORLD @ frames_at(robot, row)[-1] @ TOOL for row in q]
    return ToolPoses("log", q, np.array([pose.p for pose in poses]), np.array([pose.R for pose in poses]))


@pytest.fixture(scope="module")
def log() -> Recording:
    """An RX90's unloaded recording with some noise."""
    robot = load_robot("rx90")
    motion = random_via_points(robot, 8, seed=5).motion(100.0)
    return Simulator(robot).record(motion, None, (3.0, 4.0, 1.5, 0.7, 0.9, 0.3), 1)


@pytest.fixture
def moves(rx90: Robot) -> Array:
    return np.random.default_rng(2).uniform(-1.5, 1.5, (60, 6))


@pytest.mark.parametrize("name", ["rx90", "kr6_r900", "panda"])
def test_pose_of_a_right_log(name: str) -> None:
    """Base and tool come back; residual at rounding."""
    robot = load_robot(name)
    q = np.random.default_rng(2).uniform(-1.5, 1.5, (60, robot.n))
    poses = logged(robot, q)
    check = check_pose(robot, poses)
    assert check.reproduced
    assert check.readings is None
    assert check.rms < 1e-8
    assert check.rms_angle is not None
    assert check.rms_angle < 1e-6
    assert check.as_is > 0.1
    np.testing.assert_allclose(check.base.R, WORLD.R, atol=1e-7)
    np.testing.assert_allclose(check.base.p, WORLD.p, atol=1e-7)
    np.testing.assert_allclose(check.tool.p, TOOL.p, atol=1e-7)
    np.testing.assert_allclose(check.tool.R, TOOL.R, atol=1e-7)
    assert check_pose(robot, poses._replace(rotations=None)).rms_angle is None


def test_pose_of_a_wrong_length(rx90: Robot, moves: Array) -> None:
    """20 mm on the forearm are seen as such, not hidden in base and tool."""
    poses = logged(rx90, moves)._replace(rotations=None)
    joints = list(rx90.joints)
    joints[3] = replace(joints[3], r=joints[3].r + 0.02)
    check = check_pose(replace(rx90, joints=tuple(joints)), poses)
    assert 0.003 < check.rms < 0.02
    assert check.readings is not None
    assert check.readings.suggested is None


def spoilt(recording: Recording, truth: Reading) -> Recording:
    """The log that reads as ``recording`` under ``truth``."""
    q, torque = np.empty_like(recording.q), np.empty_like(recording.q)
    for j, column in enumerate(truth.order):
        own = recording.q[:, j] - truth.along[j] * recording.q[:, j - 1]
        q[:, column] = (own - truth.quarters[j] * pi / 2) * truth.sign[j]
        torque[:, column] = recording.torque[:, j] * truth.sign[j] * truth.torque[j]
    return Recording(recording.t, q, torque, None, "spoilt")


RIGHT = Reading.as_recorded(6)
PLAIN = replace(load_robot("rx90").processing, decimate=1)
SPOILT = {
    "a torque": RIGHT._replace(torque=(1, 1, -1, 1, 1, 1)),
    "from the horizontal": RIGHT._replace(along=(0, 0, 1, 0, 0, 0)),
    "three things": RIGHT._replace(order=(0, 1, 3, 2, 4, 5), sign=(1, -1, 1, 1, 1, 1), quarters=(0, 0, 0, 0, 2, 0)),
}


@pytest.fixture(scope="module")
def right(log: Recording) -> Readings:
    """The ranking of the log that is right."""
    return rank_readings(load_robot("rx90"), [log], PLAIN)


def test_a_right_log_is_taken_as_it_stands(right: Readings) -> None:
    """Gravity does not see joint 1: its other zeros are listed as alike, and none is suggested."""
    assert right.suggested is None
    assert next(iter(right.residuals)) == RIGHT
    assert {(k, 0, 0, 0, 0, 0) for k in (1, 2, 3)} <= {candidate.quarters for candidate in right.alike}
    assert len(right.residuals) > 100


@pytest.mark.parametrize("truth", SPOILT.values(), ids=SPOILT.keys())
def test_suggestion_restores_the_log(log: Recording, right: Readings, truth: Reading) -> None:
    """It explains the torques as well as the right reading does: what it leaves open, no torque tells."""
    ranking = rank_readings(load_robot("rx90"), [spoilt(log, truth)], PLAIN)
    assert ranking.suggested is not None
    assert ranking.residuals[ranking.suggested] == pytest.approx(right.as_recorded, rel=0.02)
    # What is left out or added moves no more than what can be told.
    assert ranking.suggested.order == truth.order
    assert (ranking.suggested.torque, ranking.suggested.along) == (truth.torque, truth.along)
