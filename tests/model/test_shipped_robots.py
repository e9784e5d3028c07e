"""Shipped arms against the chains of joints that public descriptions of them publish."""

import math
from dataclasses import replace

import numpy as np
import pytest
from dynident import model
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.model.files.robot_file import robot_toml
from dynident.model.stand_in import cylinder_radius, cylinders, rehearsed
from dynident.tests.reference.chains import CHAINS, Chain
from scipy.spatial.transform import Rotation

ADDED = sorted(CHAINS)
ROUNDED = {"gp7", "gp8"}
"""Their axis 6 is rounded down to 360 degrees and 1000 deg/s, as their files say."""


def flange(robot: model.Robot, q: Array) -> tuple[Array, Array]:
    """Axes and origin of the flange in frame 0."""
    R, p = (np.array(value) for value in model.forward_kinematics(robot)(q))
    return R @ robot.flange.R, R @ robot.flange.p + p.ravel()


def published(chain: Chain, q: Array) -> tuple[Array, Array]:
    """Frames of the published chain, by another library's rotations."""
    R, p = Rotation.identity(), np.zeros(3)
    angles = chain.angles or ((0.0, 0.0, 0.0),) * len(q)
    for place, turn, axis, value in zip(chain.places, angles, chain.axes, q, strict=True):
        p = p + R.apply(place)
        R = R * Rotation.from_euler("xyz", turn) * Rotation.from_rotvec(value * np.array(axis))
    p = p + R.apply(chain.flange[0])
    return (R * Rotation.from_euler("xyz", chain.flange[1])).as_matrix(), p


@pytest.mark.parametrize("name", ADDED)
def test_flange_as_published(name: str) -> None:
    """At all zero and at 20 random joint vectors."""
    robot, draw = model.load_robot(name), np.random.default_rng(1)
    for q in (np.zeros(robot.n), *draw.uniform(-np.pi, np.pi, (20, robot.n))):
        for ours, theirs in zip(flange(robot, q), published(CHAINS[name], q), strict=True):
            np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("name", ADDED)
def test_limits_as_published(name: str) -> None:
    """Ranges and speeds to the rounding of the source."""
    robot, chain = model.load_robot(name), CHAINS[name]
    ranges = np.degrees([joint.limits.position for joint in robot.joints])
    speeds = np.degrees([joint.limits.speed for joint in robot.joints])
    low, high, fastest = (np.array(chain.in_degrees(values)) for values in (chain.low, chain.high, chain.speeds))
    if name in ROUNDED:
        low[5], high[5], fastest[5] = np.ceil(low[5]), np.floor(high[5]), 1000.0
    np.testing.assert_allclose(ranges, np.column_stack([low, high]), rtol=0.0, atol=0.01)
    np.testing.assert_allclose(speeds, fastest, rtol=1e-4)


@pytest.mark.parametrize("name", model.robot_names())
def test_written_and_read_again(name: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    robot = model.load_robot(name)
    path = tmp_path_factory.mktemp("robot") / "again.toml"
    path.write_text(robot_toml(robot, 'a "quoted" source\nof two lines'), encoding="utf-8")
    again = model.load_robot(path)
    assert again.parameters == robot.parameters
    assert (again.drives, again.processing, again.flange, again.gravity, again.rated_payload) == (
        robot.drives, robot.processing, robot.flange, robot.gravity, robot.rated_payload
    )  # fmt: skip
    for ours, theirs in zip(again.joints, robot.joints, strict=True):
        assert (ours.kind, ours.d, ours.r) == (theirs.kind, theirs.d, theirs.r)
        assert (ours.alpha, ours.theta) == pytest.approx((theirs.alpha, theirs.theta), abs=1e-14)
        assert ours.limits.position == pytest.approx(theirs.limits.position, abs=1e-13)
        assert ours.limits.speed == pytest.approx(theirs.limits.speed, rel=1e-13)


LOOKED_UP = {"position", "speed"}
"""Found for every arm; what of the rest was assumed stands in the docs."""


@pytest.mark.parametrize("name", model.robot_names())
def test_every_limit_is_there_with_its_source(name: str) -> None:
    robot = model.load_robot(name)
    limits = [joint.limits for joint in robot.joints]
    numbers = [(*limit.position, limit.speed, limit.acceleration, limit.torque) for limit in limits]
    assert np.isfinite(numbers).all()
    assert robot.mass is not None
    assert math.isfinite(robot.rated_payload)
    needed = {"position", "speed", "acceleration", "torque", "mass", "rated_payload"}
    assert needed <= set(robot.sources)
    assert not LOOKED_UP & set(robot.assumed())
    assert bool(robot.joint_names) == ("joint_names" in robot.sources)
    assert (robot.flange_pose is not None) == ("flange" in robot.sources)
    assert robot.drives.friction


@pytest.mark.parametrize("name", model.robot_names())
def test_a_stand_in_weighs_as_real_arms_do(name: str) -> None:
    """Links that can exist, rotors and friction, and first moments like those of arms that were identified."""
    robot = model.with_stand_in(model.load_robot(name))
    for link in range(1, robot.n + 1):
        body = model.InertialParameters(np.array([robot.parameters[f"{kind}{link}"] for kind in model.INERTIAL]))
        assert body.min_pseudo_inertia_eigenvalue > 0.0
        assert robot.parameters[f"FS{link}"] > 0.0
        assert robot.parameters[f"FV{link}"] > 0.0
    base = model.base_parameters(robot)
    values = dict(zip(base.columns, base.value(robot.parameters), strict=True))
    moments = sum(
        math.hypot(values.get(f"MX{j}", 0.0), values.get(f"MY{j}", 0.0))
        for j in ((2, 4, 6) if robot.n == 7 else (2, 3))
    )
    assert robot.mass is not None
    length = sum(math.hypot(joint.d, joint.r) for joint in robot.joints[1:])
    assert 0.18 < moments / (robot.mass * length) < 0.32


@pytest.mark.parametrize("name", model.robot_names())
def test_links_that_are_not_known_are_cylinders_of_one_density(name: str) -> None:
    """Second moments over the mass: r^2 / 4, and l^2 / 12 along a rod that reaches a radius beyond both joints."""
    robot = model.load_robot(name)
    radius, bodies = cylinder_radius(robot), cylinders(robot, 12.0)
    lengths = np.array([2.0 * (np.linalg.norm(body.com) + radius) for body in bodies])
    assert [body.mass for body in bodies] == pytest.approx(12.0 * lengths / lengths.sum())
    for body, length in zip(bodies, lengths, strict=True):
        second = (0.5 * np.trace(body.inertia_com) * np.eye(3) - body.inertia_com) / body.mass
        expected = sorted((radius**2 / 4.0, radius**2 / 4.0, length**2 / 12.0))
        assert np.linalg.eigvalsh(second) == pytest.approx(expected, rel=1e-9)
        assert second @ body.com == pytest.approx(length**2 / 12.0 * body.com, abs=1e-12)


def test_no_stand_in_out_of_nothing() -> None:
    robot = replace(model.load_robot("ur10e"), mass=None)
    with pytest.raises(InputError, match="mass_kg"):
        model.with_stand_in(robot)
    assert rehearsed(robot) is robot
