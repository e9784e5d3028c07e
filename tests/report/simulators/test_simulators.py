"""Whole robots: each simulator reads the same numbers back, and MuJoCo moves them as the model says."""

import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.export.simulators import FORMATS
from dynident.common.arrays import Array
from dynident.estimation import Estimate
from dynident.estimation.fit.estimate import Fit
from dynident.estimation.possible.prior import robot_prior, solve_constrained_prior
from dynident.estimation.possible.whole_robot import BODY_NUMBERS, WholeRobot, whole_robot
from dynident.model import (
    Drives,
    Robot,
    Spring,
    base_parameters,
    inverse_dynamics,
    load_robot,
    robot_names,
    standard_columns,
    with_stand_in,
)
from dynident.model.base.rank import random_states
from dynident.tests.model.urdf_files import dressed_urdf
from dynident.tests.report.simulators.readers import Read, by_drake, by_mujoco, by_pinocchio, by_usd

RandomParameters = Callable[[Robot, int], dict[str, float]]
SPRING = Spring(2, 4000.0, 0.2, (0.35, 0.15), 0.4)
ARMS = [*robot_names(), "rx90 with spring", "crooked", "stanford", "from a URDF"]
SINGLE = 1e-6
"""Relative: what single precision leaves."""


@pytest.fixture
def whole(arm: str, prismatic: dict[str, Robot], random_parameters: RandomParameters, tmp_path: Path) -> WholeRobot:
    """A robot of every kind with a number for everything."""
    if arm in robot_names():
        robot = load_robot(arm).with_offsets(True)
    elif arm == "rx90 with spring":
        rx90 = load_robot("rx90").with_offsets(True)
        robot = replace(rx90, drives=replace(rx90.drives, spring=SPRING), base=rx90.base)
    elif arm == "from a URDF":
        path = tmp_path / "arm.urdf"
        path.write_text(dressed_urdf(load_robot("irb120"), seed=1), encoding="utf-8")
        robot = load_robot(path).with_offsets(True)
    else:
        robot = prismatic[arm]
    if arm in robot_names():
        robot = with_stand_in(robot)
        offsets = {f"OFF{j}": 0.1 * j for j in range(1, robot.n + 1)}
        return whole_robot(robot, dict(robot.parameters) | offsets, "a stand-in")
    values = random_parameters(robot, 3)
    if robot.coupling is not None:
        j, k = robot.coupling.joints
        values |= {f"{kind}{j}": values[f"{kind}{j}"] + 3.0 for kind in ("IA", "FV")} | {f"FV{k}": 4.0}
    return whole_robot(robot, values, "a table")


@pytest.mark.parametrize("arm", ARMS)
def test_mujoco_moves_it_as_the_regressor_says(whole: WholeRobot) -> None:
    """Motors' torques by mj_inverse and actuators against Newton-Euler, dry friction apart; in N·m."""
    mujoco = pytest.importorskip("mujoco")
    robot = whole.robot
    model = mujoco.MjModel.from_xml_string(FORMATS["mjcf"].text(whole))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    assert model.dof_frictionloss.any() == robot.drives.friction
    model.dof_frictionloss[:] = 0.0
    model.tendon_frictionloss[:] = 0.0
    values = {name: label.value for link in whole.links for name, label in link.parameters.items()}
    dry = {name: 0.0 for name in values if name.startswith("FS")}
    chi = np.array([(values | dry)[name] for name in standard_columns(robot)])
    dynamics, data = inverse_dynamics(robot), mujoco.MjData(model)
    for state in zip(*random_states(robot, 20, seed=2), strict=True):
        expected = np.array(dynamics(*state, chi)).ravel()
        data.qpos, data.qvel, data.qacc = state
        mujoco.mj_inverse(model, data)
        inverse = data.qfrc_inverse.copy()
        model.actuator_ctrlrange[:] = 1e9 * np.array([-1.0, 1.0])
        data.ctrl = expected
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(inverse, data.qfrc_actuator, rtol=0.0, atol=1e-9)


READERS: dict[str, tuple[str, Callable[[str, Path], Read], float]] = {
    "mujoco reads mjcf": ("mjcf", lambda text, _: by_mujoco(text), 1e-9),
    "mujoco reads urdf": ("urdf", lambda text, _: by_mujoco(text), 1e-9),
    "drake reads urdf": ("urdf", lambda text, _: by_drake(text, "urdf"), 1e-9),
    "drake reads sdf": ("sdf", lambda text, _: by_drake(text, "sdf"), 1e-9),
    "pinocchio reads urdf": ("urdf", lambda text, _: by_pinocchio(text), 1e-9),
    "usd-core reads usd": ("usd", by_usd, SINGLE),
}
HELD = {
    "mujoco reads mjcf": {"armature", "damping", "friction", "offset", "low", "high", "torque"},
    "mujoco reads urdf": {"damping", "friction", "low", "high"},
    "drake reads urdf": {"armature", "damping", "torque", "low", "high", "speed", "acceleration"},
    "drake reads sdf": {"armature", "damping", "torque", "low", "high", "speed", "acceleration"},
    "pinocchio reads urdf": {"damping", "friction", "torque", "low", "high", "speed"},
    "usd-core reads usd": {"armature", "damping", "friction", "torque", "low", "high", "speed"},
}
"""What each simulator is to hold of a joint."""


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("arm", ARMS)
def test_simulators_read_the_same_numbers_back(whole: WholeRobot, reader: str, tmp_path: Path) -> None:
    form, read, tolerance = READERS[reader]
    content = read(FORMATS[form].text(whole), tmp_path)
    by_joint = reader.startswith("pinocchio")
    for joint, link in zip(whole.joint_names, whole.links, strict=True):
        body = content.bodies[joint if by_joint else link.link]
        np.testing.assert_allclose(body.mass, link.body.mass, rtol=tolerance)
        np.testing.assert_allclose(body.com, link.body.com, atol=tolerance)
        size = float(np.abs(link.body.inertia_com).max())
        np.testing.assert_allclose(body.inertia, link.body.inertia_com, atol=tolerance * max(size, 1e-3))
    drives = whole.drives if form == "mjcf" else whole.apart
    for j, (name, drive) in enumerate(zip(whole.joint_names, drives, strict=True)):
        expected = {quantity: max(label.value, 0.0) for quantity, label in drive.items() if quantity != "offset"}
        expected |= {"offset": drive["offset"].value} if "offset" in drive else {}
        expected |= limits(whole.robot, j)
        for quantity in HELD[reader] & expected.keys():
            assert content.drives[name][quantity] == pytest.approx(
                expected[quantity], rel=tolerance, abs=tolerance
            ), quantity


def limits(robot: Robot, j: int) -> dict[str, float]:
    """Limits that a joint has."""
    limit = robot.joints[j].limits
    low, high = limit.position
    both = {"low": low, "high": high} if math.isfinite(low) and math.isfinite(high) else {}
    values = {"speed": limit.speed, "acceleration": limit.acceleration, "torque": limit.torque}
    return both | {quantity: value for quantity, value in values.items() if math.isfinite(value)}


@pytest.mark.parametrize("arm", ["rx90 with spring"])
def test_what_a_format_cannot_hold_is_said(whole: WholeRobot) -> None:
    for name, form in FORMATS.items():
        text = " ".join(form.head(form, whole))
        assert ("No place for the spring on joint_2" in text) == (name != "mjcf")
        assert ("No place for the drive that turns with the sum of joint_5 and joint_6" in text) == (name != "mjcf")
        assert ("No place for offset" in text) == (name != "mjcf")
        assert ("No place for limits of acceleration" in text) == (name in ("mjcf", "usd"))
        assert ("No place for limits of speed" in text) == (name == "mjcf")
    table = replace(whole.robot.drives, spring=Spring(2, table=((-2.0, 1.0), (2.0, 3.0))))
    tabled = replace(whole, robot=replace(whole.robot, drives=table))
    assert "No place for the spring on joint_2 (a table)" in " ".join(FORMATS["mjcf"].head(FORMATS["mjcf"], tabled))
    assert "<spatial" not in FORMATS["mjcf"].text(tabled)
    printed = replace(whole, robot=whole.robot.with_coulomb("paper"))
    assert "as the paper prints it: it is left out" in " ".join(FORMATS["mjcf"].head(FORMATS["mjcf"], printed))
    assert len(re.findall('name="coupled_drive"[^>]*frictionloss', FORMATS["mjcf"].text(printed))) == 0


@pytest.mark.parametrize("arm", ["ur10e"])
def test_what_is_not_known_is_left_out_with_a_line(whole: WholeRobot) -> None:
    """No rotor, no friction and no negative number is made up."""
    blind = replace(whole.robot, drives=Drives.on_link_side())
    values = {name: label.value for link in whole.links for name, label in link.parameters.items()}
    known = {name: values[name] for name in standard_columns(blind)}
    bare = whole_robot(blind, known, "a table")
    negative = whole_robot(whole.robot, values | {"FV2": -3.0}, "a table")
    for form in FORMATS.values():
        text = " ".join(form.head(form, bare))
        assert "Rotor inertias (armature) are left out: torque sensors behind the gears do not show them" in text
        assert "Friction is left out" in text
        assert "armature=" not in form.text(bare)
        text = " ".join(form.head(form, negative))
        assert "written as zero: shoulder_lift_joint damping" in text
        assert 'damping="-' not in form.text(negative)
        assert "<damping>-" not in form.text(negative)


def test_a_spring_hangs_where_its_law_says() -> None:
    """Length of the tendon at every angle: L^2 = a^2 + b^2 + 2 a b cos(q - q0)."""
    mujoco = pytest.importorskip("mujoco")
    rx90 = load_robot("rx90")
    robot = replace(rx90, drives=replace(rx90.drives, spring=SPRING))
    model = mujoco.MjModel.from_xml_string(FORMATS["mjcf"].text(whole_robot(robot, robot.parameters, "its file")))
    data, (a, b) = mujoco.MjData(model), SPRING.arms
    for q in np.linspace(-2.0, 2.0, 9):
        data.qpos[1] = q
        mujoco.mj_forward(model, data)
        length: Array = data.ten_length[model.tendon("spring").id]
        assert float(length) == pytest.approx(math.sqrt(a * a + b * b + 2.0 * a * b * math.cos(q - SPRING.zero)))


@pytest.mark.parametrize("kind", ["urdf"])
def test_a_urdf_comes_back_in_its_own_frames(kind: str, tmp_path: Path) -> None:
    """Read, written and read again: same links, joints, flange and limits, equal parameters."""
    path = tmp_path / "arm.urdf"
    path.write_text(dressed_urdf(load_robot("irb120"), seed=1), encoding="utf-8")
    robot = load_robot(path)
    path.write_text(FORMATS[kind].text(whole_robot(robot, robot.parameters, "its file")), encoding="utf-8")
    again = load_robot(path)
    assert again.links is not None
    assert robot.links is not None
    assert (again.links.names, again.links.joints, again.links.tip) == (
        robot.links.names, robot.links.joints, robot.links.tip
    )  # fmt: skip
    np.testing.assert_allclose(again.flange.R, robot.flange.R, atol=1e-12)
    np.testing.assert_allclose(again.flange.p, robot.flange.p, atol=1e-9)
    assert [joint.limits for joint in again.joints] == [joint.limits for joint in robot.joints]
    assert dict(again.parameters) == pytest.approx(dict(robot.parameters), rel=1e-9, abs=1e-9)


def identified(robot: Robot, truth: dict[str, float], seed: int) -> WholeRobot:
    """A robot nearest to cylinders, from base parameters with a fifth of their size as noise."""
    base = base_parameters(robot)
    chi = base.value(truth)
    sigma = 0.2 * (np.abs(chi) + 0.1)
    values = chi + sigma * np.random.default_rng(seed).standard_normal(len(chi))
    values[base.columns.index("FV3")] = -3.0 * sigma[base.columns.index("FV3")]
    estimate = Estimate(
        base.columns, values, np.diag(sigma**2), np.inf, Fit(np.ones(1), np.ones(1), (1,)), np.ones(1)
    )
    nearest = solve_constrained_prior(robot, base, estimate, robot_prior(robot, 50.0))
    return whole_robot(robot, nearest.parameters, "noise", base, estimate, nearest.prior.source)


@pytest.mark.parametrize("name", ["rx90", "kr6_r900"])
def test_an_identified_robot_is_one_that_can_exist(name: str, random_parameters: RandomParameters) -> None:
    """Every link has some margin, and who decided each number is told."""
    robot = load_robot(name)
    whole = identified(robot, random_parameters(robot, 6), 6)
    for link in whole.links:
        assert link.moments[0] > 0.0
        assert link.margin > 0.0
    drives = [label for drive in (*whole.drives, whole.coupled) for label in drive.values()]
    bound = [label for label in drives if label.bound]
    assert whole.drives[2]["damping"].bound
    assert all(label.mark == "rule" for label in bound)
    assert all(label.value < 1e-2 for label in bound)
    text = FORMATS["mjcf"].text(whole)
    assert "At their bound, zero: " in text
    for words in (" mark=data share=1.000 sigma=", " mark=rule ", " mark=prior share=0.000 sigma=none"):
        assert words in text
    lines = re.findall(
        r"^ +(\w+) (\S+) (data|rule|prior) ([\d.]+) (\S+) (\S+) (\S+) (\S+)$", text, flags=re.MULTILINE
    )
    assert {line[0] for line in lines} >= set(BODY_NUMBERS) | {"armature", "damping", "friction", "FV1", "XX6"}
