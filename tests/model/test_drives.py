"""Drives: friction, rotor inertia, the coupling of two drives, offsets, springs; poses and mounting."""

import math
from dataclasses import replace
from typing import Literal

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest
from dynident import model
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.model.base import random_states

GEOMETRIC = model.Spring(1, stiffness=800.0, length=0.2, arms=(0.3, 0.15), zero=0.4)
TABLE = model.Spring(1, table=((-1.0, 5.0), (0.0, 1.0), (2.0, -3.0)))


FORMS: tuple[Literal["sum", "paper"], ...] = ("sum", "paper")
STATES = 20
States = tuple[Array, Array, Array]


def torque(robot: model.Robot, states: States, **values: float) -> Array:
    """Torques of a robot of which only some parameters are not zero, shape (N, n)."""
    chi = np.array([values.get(name, 0.0) for name in model.standard_columns(robot)])
    return np.array(model.inverse_dynamics(robot)(*(x.T for x in states), chi)).T


def test_drive_parameters_of_a_joint_act_on_it_alone(robot: model.Robot) -> None:
    _, qd, qdd = states = random_states(robot, STATES, seed=1)
    spring = torque(robot, states)
    factors = {"IA": qdd, "FS": np.sign(qd), "FV": qd, "OFF": np.ones_like(qd)}
    coupled = f"IA{robot.coupling.joints[1]}" if robot.coupling else ""
    for name in model.standard_columns(robot):
        kind, joint = name.rstrip("0123456789"), int(name[-1]) - 1
        if kind in factors and name != coupled:
            expected = np.zeros_like(qd)
            expected[:, joint] = factors[kind][:, joint]
            np.testing.assert_allclose(torque(robot, states, **{name: 1.0}) - spring, expected, atol=1e-11)


@pytest.mark.parametrize("form", FORMS)
def test_coupling_terms(rx90: model.Robot, form: Literal["sum", "paper"]) -> None:
    """(10) and (11): inertia IA6, viscous FVM6, Coulomb FSM6, in both forms."""
    robot = rx90.with_coulomb(form)
    _, qd, qdd = states = random_states(robot, STATES, seed=2)
    speed5, speed6 = qd[:, 4], qd[:, 5]
    signs = {"sum": (speed5 + speed6, speed5 + speed6), "paper": (speed6, speed5)}
    expected = {
        "IA6": (qdd[:, 5], qdd[:, 4] + qdd[:, 5]),
        "FVM6": (speed6, speed5),
        "FSM6": (np.sign(signs[form][0]), np.sign(signs[form][1])),
    }
    for name, (row5, row6) in expected.items():
        torques = torque(robot, states, **{name: 1.0})
        assert not torques[:, :4].any()
        np.testing.assert_allclose(torques[:, 4:], np.column_stack([row5, row6]), atol=1e-14)


def test_coupling_follows_from_motors_by_duality(rx90: model.Robot) -> None:
    """(8) and (9): rotor inertias JA and motor friction, seen from the joints; powers are equal."""
    K5, K6, JA5, JA6, viscous, coulomb = 45.0, -32.0, 1.2e-4, 0.4e-4, 3e-4, 0.02
    gear = np.array([[K5, 0.0], [K6, K6]])
    _, qd, qdd = states = random_states(rx90, STATES, seed=3)
    motor_speed, motor_acceleration = qd[:, 4:] @ gear.T, qdd[:, 4:] @ gear.T
    motor = np.array([JA5, JA6]) * motor_acceleration
    motor[:, 1] += viscous * motor_speed[:, 1] + coulomb * np.sign(motor_speed[:, 1])
    joint = torque(
        rx90,
        states,
        **{"IA5": K5**2 * JA5 + K6**2 * JA6, "IA6": K6**2 * JA6, "FSM6": abs(K6) * coulomb},
        **dict.fromkeys(("FV5", "FV6", "FVM6"), K6**2 * viscous),
    )
    np.testing.assert_allclose(joint[:, 4:], motor @ gear, rtol=1e-11)
    np.testing.assert_allclose((joint * qd).sum(axis=1), (motor * motor_speed).sum(axis=1), rtol=1e-11)


def stored_energy(spring: model.Spring, q: Array) -> Array:
    """k/2 (L - L0)^2 with L between the pivots at distances a and b from the axis."""
    a, b = spring.arms
    start = np.array([a, 0.0])
    two = -b * np.stack([np.cos(q - spring.zero), np.sin(q - spring.zero)], axis=-1)
    stretch = np.asarray(np.linalg.norm(two - start, axis=-1)) - spring.length
    return 0.5 * spring.stiffness * stretch**2


def test_geometric_spring_is_the_slope_of_its_energy() -> None:
    q, h = np.linspace(-3.0, 3.0, 101), 1e-5
    slope = (stored_energy(GEOMETRIC, q + h) - stored_energy(GEOMETRIC, q - h)) / (2.0 * h)
    np.testing.assert_allclose(GEOMETRIC.torque(q), -slope, atol=1e-6)
    assert np.abs(GEOMETRIC.torque(q)).max() > 1.0


@pytest.mark.parametrize("angle", [-1.001, 2.001])
def test_spring_table_is_not_left(angle: float) -> None:
    with pytest.raises(InputError, match=r"joint 1 moves from .* outside the spring's table \(-1\.000 to 2\.000"):
        TABLE.torque(np.array([0.0, angle]))


@pytest.mark.parametrize("spring", [GEOMETRIC, TABLE], ids=["geometric", "table"])
def test_spring_as_expression(spring: model.Spring) -> None:
    q = np.linspace(-1.0, 2.0, 31)
    symbol = ca.SX.sym("q")
    law = ca.Function("law", [symbol], [spring.law(symbol)])
    np.testing.assert_allclose(np.array(law(q[None])).ravel(), spring.torque(q), atol=1e-10)


@pytest.mark.parametrize(
    ("drives", "message"),
    [
        (model.Drives(coupling=model.Coupling((5, 7))), "joint 7, the robot has joints 1 to 6"),
        (model.Drives(spring=replace(GEOMETRIC, joint=0)), "joint 0, the robot has joints 1 to 6"),
        (model.Drives(friction=(), coupling=model.Coupling((5, 6))), "need rotor inertia and friction"),
        (model.Drives(rotor_inertia=False, coupling=model.Coupling((5, 6))), "need rotor inertia and friction"),
    ],
)
def test_drives_that_do_not_fit_the_robot(rx90: model.Robot, drives: model.Drives, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        replace(rx90, drives=drives)


RPY = [(0.3, -0.7, 2.0), (0.0, math.pi / 2, 0.0), (0.4, -math.pi / 2, 1.1), (math.pi, 0.0, math.pi / 2)]


@pytest.mark.parametrize("rpy", RPY)
def test_roll_pitch_yaw_as_pinocchio_reads_them(rpy: tuple[float, float, float]) -> None:
    pose = model.Pose.from_rpy((0.1, 0.2, 0.3), rpy)
    np.testing.assert_allclose(pose.R, pin.rpy.rpyToMatrix(*rpy), atol=1e-14)
    np.testing.assert_allclose(model.Pose.from_rpy(pose.origin, pose.rpy).R, pose.R, atol=1e-14)


def test_poses_compose_like_transforms() -> None:
    a, b = model.Pose.from_rpy((0.1, -0.2, 0.3), RPY[0]), model.Pose.from_rpy((1.0, 0.0, -0.5), RPY[2])
    theirs = pin.SE3(a.R, a.p) * pin.SE3(b.R, b.p)
    np.testing.assert_allclose((a @ b).R, theirs.rotation, atol=1e-14)
    np.testing.assert_allclose((a @ b).p, theirs.translation, atol=1e-12)
    assert (model.Pose() @ model.Pose().inverse()).is_identity
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
    rx90: model.Robot, rpy_deg: tuple[float, ...], gravity: tuple[float, float, float]
) -> None:
    """Gravity as the base sees it: down in the world, by the transposed rotation of the base."""
    roll, pitch, yaw = (math.radians(angle) for angle in rpy_deg)
    assert model.mounted(rx90, (roll, pitch, yaw)).gravity == pytest.approx(gravity, abs=1e-12)
    # Where frame 0 is not the base, gravity goes through both rotations.
    base = model.Pose.from_rpy((0.0, 0.0, 0.2), (math.pi / 2, 0.0, 0.0))
    turned = model.mounted(replace(rx90, base=base), (roll, pitch, yaw))
    assert turned.gravity == pytest.approx(tuple(base.R @ np.array(gravity)), abs=1e-12)
    assert turned.base == base


def test_tool_frames_add_up(rx90: model.Robot) -> None:
    tool = model.Pose.from_rpy((0.0, 0.0, 0.1), RPY[0])
    gripper = model.with_tool(rx90, tool, "gripper")
    two = model.with_tool(gripper, tool, "finger")
    assert two.flange == tool @ tool
    finger = model.Pose.from_rpy((0.02, 0.0, -0.1), RPY[2])
    both = model.with_tool(gripper, finger, "finger")
    assert both.flange == tool @ finger != finger @ tool, "a tool stands in the flange"
    names = (gripper.last_frame, gripper.payload_frame, two.payload_frame)
    assert names == ("frame 6 (modified DH)", "gripper", "finger")
    assert rx90.last_frame == rx90.payload_frame
