"""Shipped arms close against what their makers publish: the reach, and the flange in a known pose."""

import math
from typing import NamedTuple

import casadi as ca
import numpy as np
import pytest
from dynident.model import Robot, forward_kinematics, load_robot, robot_names, robot_toml
from dynident.model.arrays import Array

REACH = {
    "kr6_r900": 0.901,
    "kr10_r1100": 1.101,
    "irb120": 0.580,
    "lrmate200id": 0.717,
    "gp7": 0.927,
    "gp8": 0.727,
    "tx2_60": 0.600,
    "tx2_90": 0.900,
    "iiwa14": 0.820,
}
"""Largest distance of the wrist centre from axis 1 by the data sheets [m]."""


class Known(NamedTuple):
    """Joint positions [deg], the flange's origin in frame 0 [m] and its z and x axes there."""

    q: tuple[float, ...]
    origin: tuple[float, float, float]
    z: tuple[float, float, float]
    x: tuple[float, float, float] | None = None


FORWARD, UP, DOWN = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)
ZERO = (0.0,) * 6
POSES = {
    # Home of the KR C4: A2 -90, A3 90; x of $FLANGE points down.
    "kr6_r900": Known((0, -90, 90, 0, 0, 0), (0.525, 0.0, 0.890), FORWARD, DOWN),
    "kr10_r1100": Known((0, -90, 90, 0, 0, 0), (0.620, 0.0, 0.995), FORWARD, DOWN),
    # Product specification: all axes at 0, upper arm upright, forearm level.
    "irb120": Known(ZERO, (0.374, 0.0, 0.630), FORWARD, DOWN),
    "lrmate200id": Known(ZERO, (0.465, 0.0, 0.695), FORWARD, UP),
    "gp7": Known(ZERO, (0.560, 0.0, 0.815), FORWARD, UP),
    "gp8": Known(ZERO, (0.460, 0.0, 0.715), FORWARD, UP),
    # All axes at 0: stretched upwards.
    "tx2_60": Known(ZERO, (0.0, 0.020, 1.045), UP, FORWARD),
    "tx2_90": Known(ZERO, (0.050, 0.050, 1.428), UP, FORWARD),
    "iiwa14": Known((0.0,) * 7, (0.0, 0.0, 1.306), UP, FORWARD),
    # ur_description/config/*/default_kinematics.yaml of the public ros-industrial/universal_robot at q = 0.
    "ur3e": Known(ZERO, (-0.45675, -0.22315, 0.0665), (0.0, -1.0, 0.0), FORWARD),
    "ur5e": Known(ZERO, (-0.8172, -0.2329, 0.0628), (0.0, -1.0, 0.0), FORWARD),
    "ur16e": Known(ZERO, (-0.8384, -0.2907, 0.06085), (0.0, -1.0, 0.0), FORWARD),
    "ur20": Known(ZERO, (-1.5907, -0.3553, 0.0770), (0.0, -1.0, 0.0), FORWARD),
    # Ready pose: the maker's (0.307, 0, 0.487) is 0.1034 m further, in the hand.
    "panda": Known((0, -45, 0, -135, 0, 90, 45), (0.307, 0.0, 0.487 + 0.1034), DOWN),
    "fr3": Known((0, -45, 0, -135, 0, 90, 45), (0.307, 0.0, 0.487 + 0.1034), DOWN),
}
ADDED = sorted(POSES)


def flange(robot: Robot, q: Array) -> tuple[Array, Array]:
    """Axes and origin of the flange in frame 0."""
    R, p = (np.array(value) for value in forward_kinematics(robot)(q))
    return R @ robot.flange.R, R @ robot.flange.p + p.ravel()


@pytest.mark.parametrize("name", ADDED)
def test_flange_in_a_published_pose(name: str) -> None:
    """To the millimetre the source is printed in, half of one for the rounded ready pose."""
    robot, known = load_robot(name), POSES[name]
    R, p = flange(robot, np.radians(known.q))
    np.testing.assert_allclose(p, known.origin, atol=6e-4 if name in ("panda", "fr3") else 1e-9)
    np.testing.assert_allclose(R[:, 2], known.z, atol=1e-9)
    if known.x:
        np.testing.assert_allclose(R[:, 0], known.x, atol=1e-9)


@pytest.mark.parametrize("name", sorted(REACH))
def test_published_reach(name: str) -> None:
    """The wrist centre's largest distance from axis 1, found by trying, is the data sheet's to a millimetre."""
    robot = load_robot(name)
    q = ca.SX.sym("q", robot.n)
    moved = ca.SX.zeros(robot.n)
    lifts, bends = (1, 3) if robot.n == 7 else (1, 2)
    moved[lifts], moved[bends] = q[0], q[1]
    R, p = forward_kinematics(robot)(moved)
    wrist = p - R[:, 2] * robot.joints[-1].r
    grid = np.radians(np.arange(-180.0, 180.0, 1.0))
    a, b = (values.ravel() for values in np.meshgrid(grid, grid))
    centre = ca.Function("wrist", [q[:2]], [wrist]).map(len(a))
    # Beside axis 1 as the arm's offset lies: the sheets' reach is in the plane of the arm.
    forward = np.abs(np.array(centre(np.vstack([a, b])))[0])
    assert forward.max() == pytest.approx(REACH[name], abs=1e-3)


@pytest.mark.parametrize("name", ADDED)
def test_every_added_arm_tells_its_source(name: str, root_text: dict[str, str]) -> None:
    robot, text = load_robot(name), root_text[name]
    assert "public" in text or "maker" in text
    assert "flange" in robot.payload_frame
    assert math.isfinite(robot.rated_payload)
    assert not robot.parameters
    for joint in robot.joints:
        assert math.isfinite(joint.limits.speed)
        assert joint.limits.position[0] < joint.limits.position[1]


@pytest.fixture(scope="module")
def root_text() -> dict[str, str]:
    from pathlib import Path

    folder = Path(__file__).parents[2] / "model/robots"
    return {path.stem: path.read_text(encoding="utf-8") for path in folder.glob("*.toml")}


def test_enough_arms() -> None:
    assert len(ADDED) >= 10
    assert set(ADDED) | {"rx90", "tx40", "ur10e"} == set(robot_names())


@pytest.mark.parametrize("name", robot_names())
def test_written_and_read_again(name: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    robot = load_robot(name)
    path = tmp_path_factory.mktemp("robot") / "again.toml"
    path.write_text(robot_toml(robot, 'a "quoted" source\nof two lines'), encoding="utf-8")
    again = load_robot(path)
    assert again.parameters == robot.parameters
    assert (again.drives, again.processing, again.flange, again.gravity, again.rated_payload) == (
        robot.drives, robot.processing, robot.flange, robot.gravity, robot.rated_payload
    )  # fmt: skip
    for ours, theirs in zip(again.joints, robot.joints, strict=True):
        assert (ours.kind, ours.d, ours.r) == (theirs.kind, theirs.d, theirs.r)
        assert (ours.alpha, ours.theta) == pytest.approx((theirs.alpha, theirs.theta), abs=1e-14)
        assert ours.limits.position == pytest.approx(theirs.limits.position, abs=1e-13)
        assert ours.limits.speed == pytest.approx(theirs.limits.speed, rel=1e-13)
