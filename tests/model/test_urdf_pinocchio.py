"""URDF descriptions of public arms against Pinocchio."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from dynident.model import Robot, forward_kinematics, inverse_dynamics, load_robot, standard_columns
from dynident.model.base.rank import random_states
from dynident.tests.model.urdf_files import ARMS, Write, dressed_urdf, rigid
from dynident.tests.model.urdf_files import write as write


def check_against_pinocchio(text: str, robot: Robot) -> None:
    """Pose of the flange and joint torques by Pinocchio's own reading of the same text."""
    model = pin.buildModelFromXML(text)
    data = model.createData()
    tip = model.getFrameId("tool0")
    robot = rigid(robot)
    chi = np.array([robot.parameters[name] for name in standard_columns(robot)])
    ours, torque = forward_kinematics(robot), inverse_dynamics(robot)
    for q, qd, qdd in zip(*random_states(robot, 20, seed=3), strict=True):
        place, theirs = pinocchio_state(model, q)
        pin.framesForwardKinematics(model, data, place)
        R, p = (np.array(value) for value in ours(q))
        to_base = robot.base.inverse()
        base_R, base_p = to_base.R @ R, to_base.R @ p.ravel() + to_base.p
        np.testing.assert_allclose(base_R @ robot.flange.R, data.oMf[tip].rotation, atol=1e-9)
        np.testing.assert_allclose(base_R @ robot.flange.p + base_p, data.oMf[tip].translation, atol=1e-9)
        expected = pin.rnea(model, data, place, qd, qdd)[theirs]
        np.testing.assert_allclose(
            np.array(torque(q, qd, qdd, chi)).ravel(), expected, atol=1e-9 * np.abs(expected).max()
        )


def pinocchio_state(model: pin.Model, q: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """Joint positions as Pinocchio counts them (a continuous joint by cosine and sine) and speeds' places."""
    place = np.zeros(model.nq)
    order = []
    for k in range(len(q)):
        joint = model.joints[model.getJointId(f"joint{k + 1}")]
        place[joint.idx_q : joint.idx_q + joint.nq] = [q[k]] if joint.nq == 1 else [np.cos(q[k]), np.sin(q[k])]
        order.append(joint.idx_v)
    return place, order


@pytest.mark.parametrize("path", ARMS, ids=[path.stem for path in ARMS])
def test_arms_against_pinocchio(path: Path, write: Write) -> None:
    """Kinematics and inverse dynamics of known arms, dressed in link frames of any kind, to 1e-9."""
    text = dressed_urdf(load_robot(path), seed=len(path.stem))
    check_against_pinocchio(text, load_robot(write(text)))


@pytest.mark.parametrize("seed", range(6))
def test_continuous_and_prismatic_joints(prismatic: dict[str, Robot], seed: int, write: Write) -> None:
    arm = list(prismatic.values())[seed % 3]
    text = dressed_urdf(arm, seed, limits=False)
    robot = load_robot(write(text))
    assert [joint.kind for joint in robot.joints] == [joint.kind for joint in arm.joints]
    check_against_pinocchio(text, robot)
