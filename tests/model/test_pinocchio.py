"""The model against Pinocchio, which knows nothing of this package's code, and laws of energy and payloads."""

from collections.abc import Callable
from dataclasses import replace
from math import cos, radians, sin

import numpy as np
import pinocchio as pin
from dynident.common.arrays import Array
from dynident.model import (
    INERTIAL,
    InertialParameters,
    Joint,
    Robot,
    forward_kinematics,
    inverse_dynamics,
    mass_matrix,
    payload_regressor,
    standard_columns,
    standard_regressor,
)
from dynident.model.base import random_states
from dynident.model.regressors import payload_columns
from dynident.tests.model.urdf_files import rigid

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


FEW = 50
Evaluate = Callable[..., Array]
RandomParameters = Callable[[Robot, int], dict[str, float]]
RandomBodies = Callable[[int, int], list[InertialParameters]]


def vector(robot: Robot, values: dict[str, float]) -> Array:
    return np.array([values[name] for name in standard_columns(robot)])


def assert_equal(value: Array, reference: Array, tolerance: float = 1e-11) -> None:
    """Equal to a fraction of each column's largest entry (columns may have different units)."""
    scale = np.abs(reference).max(axis=0)
    assert value.shape == reference.shape
    assert (np.abs(value - reference) <= tolerance * scale).all()


def test_power_balance(robot: Robot, evaluate: Evaluate, random_parameters: RandomParameters) -> None:
    """The motors' power is the growth of energy plus what friction takes."""
    q, qd, qdd = random_states(robot, FEW, seed=4)
    values = random_parameters(robot, 4)
    torque = evaluate(inverse_dynamics(robot), q, qd, qdd, vector(robot, values))[:, :, 0]
    power = (torque * qd).sum(axis=1)
    step = 1e-30  # complex step: the derivative along the motion without cancellation
    growth = np.array(
        [
            energy(robot, values, a + 1j * step * b, b + 1j * step * c).imag / step
            for a, b, c in zip(q, qd, qdd, strict=True)
        ]
    )
    assert_equal(power, growth + friction_power(robot, values, qd))


def energy(robot: Robot, values: dict[str, float], q: Array, qd: Array) -> complex:
    """Kinetic and potential energy [J] from homogeneous transforms and pseudo-inertias; takes complex numbers."""
    T, speed = np.eye(4, dtype=complex), np.zeros((4, 4), dtype=complex)
    total = 0.0 + 0.0j
    for j, joint in enumerate(robot.joints):
        A, slope = transform(joint, q[j])
        T, speed = T @ A, speed @ A + T @ slope * qd[j]
        body = InertialParameters(np.array([values[f"{kind}{j + 1}"] for kind in INERTIAL]))
        total += 0.5 * np.trace(speed @ body.pseudo_inertia @ speed.T)
        total -= np.array(robot.gravity) @ (T @ body.pseudo_inertia)[:3, 3]
        total += 0.5 * values.get(f"IA{j + 1}", 0.0) * qd[j] ** 2
    if robot.coupling:
        first, second = robot.coupling.joints
        total += values[f"IA{second}"] * qd[first - 1] * qd[second - 1]
    if robot.spring:
        a, b = robot.spring.arms
        psi = q[robot.spring.joint - 1] - robot.spring.zero
        L = np.sqrt(a * a + b * b + 2 * a * b * np.cos(psi))
        total += 0.5 * robot.spring.stiffness * (L - robot.spring.length) ** 2
    return complex(total)


def transform(joint: Joint, q: complex) -> tuple[Array, Array]:
    """Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r), and its derivative by q."""
    angle, length = (q + joint.theta, joint.r) if joint.revolute else (joint.theta, q + joint.r)
    ca, sa, c, s = cos(joint.alpha), sin(joint.alpha), np.cos(angle), np.sin(angle)
    before = np.array([[1, 0, 0, joint.d], [0, ca, -sa, 0], [0, sa, ca, 0], [0, 0, 0, 1]])
    screw = np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, length], [0, 0, 0, 1]])
    slope = np.zeros((4, 4), dtype=complex)
    if joint.revolute:
        slope[:2, :2] = [[-s, -c], [c, -s]]
    else:
        slope[2, 3] = 1.0
    return before @ screw, before @ slope


def friction_power(robot: Robot, values: dict[str, float], qd: Array) -> Array:
    """(2) times the speed, the offsets, and rotor k's friction at the sum of the coupled speeds."""
    power = np.zeros(len(qd))
    for j, speed in enumerate(qd.T, start=1):
        power += values.get(f"FS{j}", 0.0) * np.abs(speed) + values.get(f"FV{j}", 0.0) * speed**2
        power += values.get(f"OFF{j}", 0.0) * speed
    if robot.coupling:
        first, second = robot.coupling.joints
        first_speed, two = qd[:, first - 1], qd[:, second - 1]
        power += (
            values[f"FSM{second}"] * np.abs(first_speed + two) + 2.0 * values[f"FVM{second}"] * first_speed * two
        )
    return power


def test_welded_payload_only_changes_the_last_link(
    robot: Robot, evaluate: Evaluate, random_parameters: RandomParameters, random_bodies: RandomBodies
) -> None:
    """A payload given in a tool frame, and the same body as one more link behind a joint that is held."""
    tool = Joint("revolute", radians(33), 0.12, radians(-71), 0.08)
    values, payload = random_parameters(robot, 7), random_bodies(1, 8)[0]
    longer = replace(robot, joints=(*robot.joints, tool), joint_names=())
    states = random_states(robot, FEW, seed=7)
    n = robot.n
    longer_states = [np.column_stack([x, np.zeros(FEW)]) for x in states]
    extra = dict.fromkeys(standard_columns(longer), 0.0) | values | payload.named(str(n + 1))
    expected = evaluate(inverse_dynamics(longer), *longer_states, vector(longer, extra))[:, :n, 0]

    pose = transform(tool, 0.0)[0].real
    moved = payload.moved(pose[:3, :3], pose[:3, 3])
    loaded = values | {name: values[name] + value for name, value in moved.named(str(n)).items()}
    torque = inverse_dynamics(robot)
    with_payload = evaluate(torque, *states, vector(robot, loaded))[:, :, 0]
    assert_equal(with_payload, expected)
    assert tuple(moved.named(str(n))) == payload_columns(robot)

    without = evaluate(torque, *states, vector(robot, values))[:, :, 0]
    assert_equal(evaluate(payload_regressor(robot), *states) @ moved.vector, with_payload - without, 1e-10)
