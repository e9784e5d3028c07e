"""Poses, mounting and frames a user knows."""

import math
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from dynident.model import Pose, Robot, mounted, with_tool

RPY = [(0.3, -0.7, 2.0), (0.0, math.pi / 2, 0.0), (0.4, -math.pi / 2, 1.1), (math.pi, 0.0, math.pi / 2)]


@pytest.mark.parametrize("rpy", RPY)
def test_roll_pitch_yaw_as_pinocchio_reads_them(rpy: tuple[float, float, float]) -> None:
    pose = Pose.from_rpy((0.1, 0.2, 0.3), rpy)
    np.testing.assert_allclose(pose.R, pin.rpy.rpyToMatrix(*rpy), atol=1e-14)
    np.testing.assert_allclose(Pose.from_rpy(pose.origin, pose.rpy).R, pose.R, atol=1e-14)


def test_poses_compose_like_transforms() -> None:
    a, b = Pose.from_rpy((0.1, -0.2, 0.3), RPY[0]), Pose.from_rpy((1.0, 0.0, -0.5), RPY[2])
    theirs = pin.SE3(a.R, a.p) * pin.SE3(b.R, b.p)
    np.testing.assert_allclose((a @ b).R, theirs.rotation, atol=1e-14)
    np.testing.assert_allclose((a @ b).p, theirs.translation, atol=1e-12)
    assert (Pose() @ Pose().inverse()).is_identity
    assert not a.is_identity


@pytest.mark.parametrize(
    ("rpy_deg", "gravity"),
    [
        ((0, 0, 0), (0.0, 0.0, -9.81)),
        ((180, 0, 0), (0.0, 0.0, 9.81)),
        ((0, 90, 0), (9.81, 0.0, 0.0)),
        ((90, 0, 0), (0.0, -9.81, 0.0)),
        ((0, 0, 77), (0.0, 0.0, -9.81)),
    ],
)
def test_mounting_turns_gravity(
    rx90: Robot, rpy_deg: tuple[float, ...], gravity: tuple[float, float, float]
) -> None:
    """Gravity as the base sees it: down in the world, by the transposed rotation of the base."""
    roll, pitch, yaw = (math.radians(angle) for angle in rpy_deg)
    assert mounted(rx90, (roll, pitch, yaw)).gravity == pytest.approx(gravity, abs=1e-12)
    # Where frame 0 is not the base, gravity goes through both rotations.
    base = Pose.from_rpy((0.0, 0.0, 0.2), (math.pi / 2, 0.0, 0.0))
    turned = mounted(replace(rx90, base=base), (roll, pitch, yaw))
    assert turned.gravity == pytest.approx(tuple(base.R @ np.array(gravity)), abs=1e-12)
    assert turned.base == base


def test_tool_frames_add_up(rx90: Robot) -> None:
    tool = Pose.from_rpy((0.0, 0.0, 0.1), RPY[0])
    gripper = with_tool(rx90, tool, "gripper")
    two = with_tool(gripper, tool, "finger")
    assert two.flange == tool @ tool
    finger = Pose.from_rpy((0.02, 0.0, -0.1), RPY[2])
    assert (
        with_tool(gripper, finger, "finger").flange == tool @ finger != finger @ tool
    )  # a tool stands in the flange
    assert (gripper.last_frame, gripper.payload_frame, two.payload_frame) == (
        "frame 6 (modified DH)",
        "gripper",
        "finger",
    )
    assert rx90.last_frame == rx90.payload_frame
