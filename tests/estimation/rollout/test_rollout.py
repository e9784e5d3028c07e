"""Predicted motion: against a pendulum's closed form, against MuJoCo, over robots, on a real arm."""

from dataclasses import replace
from math import pi, radians, sqrt
from pathlib import Path

import numpy as np
import pytest
from dynident import model
from dynident.apps.rollout import CONSTANT, IDENTIFIED, IdentifiedArm, mujoco_arm, roll_out_all
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import Settings
from dynident.estimation.results.robot import Rollout
from dynident.model.stand_in import with_stand_in
from dynident.tests.conftest import IN_FULL
from dynident.trajectories import plan_point_to_point
from dynident.trajectories.motions.via_points import random_points
from dynident.trajectories.simulation import Task, no_disturbances, run_experiment

STEP = 0.01
PENDULUM = model.Robot(
    "pendulum", (model.Joint(alpha=radians(90)),), drives=model.Drives(friction=(), offsets=False)
)
"""Turns about a level axis; gravity pulls its mass down."""
BODY = {"M1": 2.0, "MX1": 1.0, "ZZ1": 0.9}


def values_of(robot: model.Robot, parameters: dict[str, float]) -> Array:
    return model.base_parameters(robot).value(dict.fromkeys(model.standard_columns(robot), 0.0) | parameters)


@pytest.fixture(scope="module")
def pendulum() -> IdentifiedArm:
    return IdentifiedArm(PENDULUM, model.base_parameters(PENDULUM), values_of(PENDULUM, BODY))


def test_a_pendulum_swings_as_in_closed_form(pendulum: IdentifiedArm) -> None:
    """About its lowest point q'' = -w^2 q with w^2 = g MX / ZZ."""
    w, small = sqrt(9.81 / 0.9), 1e-4
    t = STEP * np.arange(101)
    q = pendulum.positions(np.array([[-0.5 * pi + small]]), np.zeros((1, 1)), np.zeros((1, 101, 1)), STEP)
    assert np.abs(q[0, :, 0] + 0.5 * pi - small * np.cos(w * t)).max() < 1e-4 * small


def test_a_pendulum_held_beside_its_lowest_point_sags_as_in_closed_form(pendulum: IdentifiedArm) -> None:
    """Held at an angle a, e'' = -(b^2 + w^2) e - 2 b e' - w^2 a."""
    w, b, small, t = sqrt(9.81 / 0.9), 200.0, 1e-4, STEP * np.arange(101)
    held = np.full((1, 101, 1), -0.5 * pi + small)
    q, _ = pendulum.followed(held, 0.0 * held, STEP)
    sag = small * w**2 / (b**2 + w**2) * (1.0 - np.exp(-b * t) * (np.cos(w * t) + b / w * np.sin(w * t)))
    assert np.abs((held - q)[0, :, 0] - sag).max() < 1e-3 * sag.max()


def test_mujoco_moves_a_pendulum_alike(pendulum: IdentifiedArm, tmp_path: Path) -> None:
    path = tmp_path / "pendulum.xml"
    inertial = '<inertial pos="0.5 0 0" mass="2" diaginertia="0.1 0.4 0.4"/>'
    path.write_text(
        f'<mujoco><compiler angle="radian"/><worldbody><body euler="{pi / 2} 0 0"><joint axis="0 0 1"/>{inertial}'
        "</body></worldbody></mujoco>"
    )
    pytest.importorskip("mujoco")
    torque = np.sin(np.linspace(0.0, 9.0, 101))[None, :, None]
    starts = np.array([[0.3]]), np.array([[0.5]])
    ours, theirs = (predict(*starts, torque, STEP) for predict in (pendulum.positions, mujoco_arm(path, PENDULUM)))
    assert np.ptp(ours) > 0.5
    assert np.abs(ours - theirs).max() < 5e-3


def recorded(robot: model.Robot) -> model.Recording:
    """A motion under a controller, without noise."""
    points = random_points(robot, 4, 3)
    tasks, still = [Task("", plan_point_to_point(robot, points, 0.42, 0.5, 0.2))], no_disturbances(robot.n)
    data = run_experiment(robot, tasks, still).runs[0].exact
    return model.Recording(data.motion.t, data.motion.q, data.torque, data.motion.qd, "simulated")


def swung(size: int) -> model.Recording:
    """A pendulum that is driven to and fro."""
    t: Array = STEP * np.arange(size, dtype=float)
    q = np.sin(4.0 * t)[:, None]
    return model.Recording(t, q, (0.9 * -16.0 * q + 9.81 * np.cos(q)), (4.0 * np.cos(4.0 * t))[:, None], "swung")


def rolled(robot: model.Robot, recording: model.Recording, parameters: dict[str, float]) -> Rollout:
    settings = Settings(model.Processing(slow_speed=0.05))
    (rollout,) = roll_out_all(robot, values_of(robot, parameters), [recording], settings, (0.1, 0.5))
    return rollout


LINK_SIDE = tuple(name for name in model.robot_names() if model.load_robot(name).drives.side == "link")


MOTOR_SIDE = [name for name in IN_FULL if name not in LINK_SIDE]
"""Further arms differ from these by their lengths and axes alone."""


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.long) for name in MOTOR_SIDE])
def test_true_parameters_predict_and_wrong_ones_do_not(name: str) -> None:
    robot = with_stand_in(model.load_robot(name))
    recording = recorded(robot)
    true = rolled(robot, recording, dict(robot.parameters))
    error, constant = (true.working.spreads(0.5)[by] for by in (IDENTIFIED, CONSTANT))
    assert error[1] < 0.05 * constant[1]
    assert true.replay_relative < 0.05
    heavier = {name: value * (1.3 if name[0] == "M" else 1.0) for name, value in robot.parameters.items()}
    wrong = rolled(robot, recording, heavier)
    missed = wrong.working.spreads(0.5)[IDENTIFIED]
    assert missed[1] > 10.0 * error[1]
    assert wrong.replay_relative > 2.0 * true.replay_relative


def test_a_joint_of_hardly_any_inertia_is_named() -> None:
    """Friction as a motor's on a link that weighs nothing cannot be integrated, and it says what is missing."""
    robot = replace(PENDULUM, drives=model.Drives())
    with pytest.raises(InputError, match="IA1"):
        rolled(robot, swung(400), {"ZZ1": 1e-7, "FS1": 5.0})


def test_parameters_of_no_robot_are_named() -> None:
    with pytest.raises(InputError, match="positive definite"):
        rolled(PENDULUM, swung(400), {"ZZ1": -0.1})


def test_a_short_recording_is_refused() -> None:
    """It must last twice as long as the horizon."""
    with pytest.raises(InputError, match=r"swung: 3\.99 s are too short for a horizon of 2 s"):
        roll_out_all(PENDULUM, values_of(PENDULUM, BODY), [swung(400)], horizons=(2.0,))
