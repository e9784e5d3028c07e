"""The model against Pinocchio, which knows nothing of this package's code."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pinocchio as pin
from dynident.common.arrays import Array
from dynident.model import (
    Drives,
    InertialParameters,
    Robot,
    forward_kinematics,
    inverse_dynamics,
    mass_matrix,
    standard_columns,
    standard_regressor,
)
from dynident.model.base.rank import random_states

STATES = 200
TOLERANCE = 1e-9
# Pinocchio: m, m c, Ixx Ixy Iyy Ixz Iyz Izz at the joint's origin; place of each in the order of (6).
KHALIL_FROM_PINOCCHIO = [4, 5, 7, 6, 8, 9, 1, 2, 3, 0]


def pinocchio_model(robot: Robot) -> pin.Model:
    """The chain by modified DH; a joint's frame is the link's frame."""
    model = pin.Model()
    model.gravity.linear = np.array(robot.gravity)
    parent = 0
    for number, joint in enumerate(robot.joints, start=1):
        before = pin.SE3(pin.utils.rotate("x", joint.alpha), np.array([joint.d, 0.0, 0.0]))
        after = pin.SE3(pin.utils.rotate("z", joint.theta), np.array([0.0, 0.0, joint.r]))
        kind = pin.JointModelRZ() if joint.revolute else pin.JointModelPZ()
        parent = model.addJoint(parent, kind, before * after, f"joint{number}")
    return model


def with_bodies(robot: Robot, values: dict[str, float]) -> pin.Model:
    model = pinocchio_model(robot)
    ten = np.array([values[name] for name in standard_columns(rigid(robot))]).reshape(robot.n, 10)
    for link, body in enumerate(map(InertialParameters, ten), start=1):
        inertia = pin.Inertia(body.mass, body.com, body.inertia_com)
        model.appendBodyToJoint(link, inertia, pin.SE3.Identity())
    return model


def rigid(robot: Robot) -> Robot:
    return replace(robot, drives=Drives(rotor_inertia=False, friction=()))


def relative_error(value: Array, reference: Array) -> float:
    """Largest deviation, relative to the largest entry of the same sample."""
    axes = tuple(range(1, reference.ndim))
    deviation = np.abs(value - reference).max(axis=axes) / np.abs(reference).max(axis=axes)
    return float(deviation.max())


def test_regressor(robot: Robot, evaluate: Callable[..., Array]) -> None:
    model = pinocchio_model(robot)
    data = model.createData()
    states = random_states(robot, STATES, seed=11)
    theirs = np.array([pin.computeJointTorqueRegressor(model, data, *state) for state in zip(*states, strict=True)])
    order = np.concatenate([10 * link + np.array(KHALIL_FROM_PINOCCHIO) for link in range(robot.n)])
    ours = evaluate(standard_regressor(rigid(robot)), *states)
    assert relative_error(ours, theirs[:, :, order]) <= TOLERANCE


def test_inverse_dynamics(
    robot: Robot, evaluate: Callable[..., Array], random_parameters: Callable[[Robot, int], dict[str, float]]
) -> None:
    """Rotor inertia (3), the inertial coupling of (10) and (11) and the spring are added by hand."""
    values = random_parameters(robot, 5)
    values |= {name: 0.0 for name in values if name.startswith(("FS", "FV", "OFF"))}
    model = with_bodies(robot, values)
    data = model.createData()
    q, qd, qdd = random_states(robot, STATES, seed=12)
    theirs = np.array([pin.rnea(model, data, *state) for state in zip(q, qd, qdd, strict=True)])
    theirs += qdd * [values.get(f"IA{joint}", 0.0) for joint in range(1, robot.n + 1)]
    if robot.coupling:
        j, k = (joint - 1 for joint in robot.coupling.joints)
        theirs[:, j] += values[f"IA{k + 1}"] * qdd[:, k]
        theirs[:, k] += values[f"IA{k + 1}"] * qdd[:, j]
    if robot.spring:
        theirs[:, robot.spring.joint - 1] -= robot.spring.torque(q[:, robot.spring.joint - 1])
    chi = np.array([values[name] for name in standard_columns(robot)])
    ours = evaluate(inverse_dynamics(robot), q, qd, qdd, chi)[:, :, 0]
    assert relative_error(ours, theirs) <= TOLERANCE


def test_mass_matrix(
    robot: Robot, evaluate: Callable[..., Array], random_parameters: Callable[[Robot, int], dict[str, float]]
) -> None:
    values = random_parameters(robot, 6)
    model = with_bodies(robot, values)
    data = model.createData()
    q = random_states(robot, STATES, seed=13)[0]
    theirs = np.array([np.triu(pin.crba(model, data, state)) for state in q])
    theirs += np.triu(theirs, 1).transpose(0, 2, 1)
    plain = rigid(robot)
    ours = evaluate(mass_matrix(plain), q, np.array([values[name] for name in standard_columns(plain)]))
    assert relative_error(ours, theirs) <= TOLERANCE


def test_forward_kinematics(robot: Robot) -> None:
    model = pinocchio_model(robot)
    data = model.createData()
    ours = forward_kinematics(robot)
    for q in random_states(robot, 20, seed=14)[0]:
        pin.forwardKinematics(model, data, q)
        R, p = ours(q)
        np.testing.assert_allclose(np.array(R), data.oMi[robot.n].rotation, atol=1e-13)
        np.testing.assert_allclose(np.array(p).ravel(), data.oMi[robot.n].translation, atol=1e-13)
