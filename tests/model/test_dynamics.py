"""Laws of the dynamics that hold for every robot."""

from collections.abc import Callable
from dataclasses import replace
from math import radians

import casadi as ca
import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.model import (
    INERTIAL,
    Coupling,
    Drives,
    Joint,
    Robot,
    Spring,
    base_parameters,
    base_regressor,
    coriolis,
    coriolis_matrix,
    essential_regressor,
    forward_dynamics,
    forward_dynamics_base,
    forward_kinematics,
    gravity,
    inverse_dynamics,
    inverse_dynamics_base,
    load_robot,
    mass_matrix,
    payload_regressor,
    robot_names,
    standard_columns,
    standard_regressor,
)
from dynident.model.dynamics import drive_torque, dry_friction_names, smooth_dry_friction
from dynident.model.kernel.program import read_program

GENERAL = Robot(
    "general",
    (
        Joint("prismatic", radians(20), 0.1, radians(35), 0.2),
        Joint("revolute", radians(-65), 0.3, radians(10), -0.1),
        Joint("prismatic", radians(55), -0.2, radians(-75), 0.1),
        Joint("revolute", radians(100), 0.25, radians(30), 0.05),
        Joint("revolute", radians(-40), 0.1, radians(130), 0.3),
    ),
    gravity=(1.0, -2.5, -9.2),
    drives=Drives(offsets=True, coupling=Coupling((4, 5)), spring=Spring(2, 900.0, 0.2, (0.3, 0.15), radians(15))),
)
TABLE = replace(
    GENERAL,
    name="table",
    drives=Drives(spring=Spring(4, table=((-4.0, 30.0), (-0.5, 5.0), (1.0, -8.0), (4.0, -60.0)))),
)
SEEDS = range(3)

MAKERS: dict[str, Callable[[Robot], ca.Function]] = {
    "inverse_dynamics": inverse_dynamics,
    "inverse_dynamics_base": lambda robot: inverse_dynamics_base(robot, base_parameters(robot)),
    "mass_matrix": mass_matrix,
    "coriolis": coriolis,
    "coriolis_matrix": coriolis_matrix,
    "gravity": gravity,
    "drive_torque": drive_torque,
    "forward_dynamics": forward_dynamics,
    "standard_regressor": standard_regressor,
    "base_regressor": lambda robot: base_regressor(robot, base_parameters(robot)),
    "essential_regressor": lambda robot: essential_regressor(robot, base_parameters(robot), essential_names(robot)),
    "payload_regressor": payload_regressor,
}


@pytest.fixture(params=[*robot_names(), "general", "table"])
def robot(request: pytest.FixtureRequest) -> Robot:
    """The shipped robots, and two with sliding joints and a spring (by its law and by a table)."""
    return {"general": GENERAL, "table": TABLE}.get(request.param) or load_robot(request.param)


def essential_names(robot: Robot) -> tuple[str, ...]:
    return base_parameters(robot).columns[1::2]


def parameters(robot: Robot, seed: int) -> dict[str, float]:
    """Standard parameters of a robot that can exist: each link has a positive definite pseudo-inertia."""
    draw = np.random.default_rng(seed)
    values = {name: float(draw.uniform(0.2, 2.0)) for name in standard_columns(robot)}
    for link in range(1, robot.n + 1):
        factor = draw.normal(0.0, 0.3, (4, 4)) + np.diag([0.1, 0.1, 0.1, 1.0])
        P = factor @ factor.T
        J = np.trace(P[:3, :3]) * np.eye(3) - P[:3, :3]
        body = [*J[np.triu_indices(3)], *P[:3, 3], P[3, 3]]
        values |= {f"{kind}{link}": float(value) for kind, value in zip(INERTIAL, body, strict=True)}
    if robot.coupling:  # IAj holds rotor k's inertia as well
        j, k = robot.coupling.joints
        values[f"IA{j}"] += values[f"IA{k}"]
    return values


def chi(robot: Robot, seed: int) -> Array:
    return np.array(list(parameters(robot, seed).values()))


def state(robot: Robot, seed: int) -> tuple[Array, Array, Array]:
    q, qd, qdd = np.random.default_rng(100 + seed).uniform(-2.0, 2.0, (3, robot.n))
    return q, qd, qdd


def dense(value: ca.DM) -> Array:
    array = np.asarray(value.full())
    return array.ravel() if array.shape[1] == 1 else array


@pytest.mark.parametrize("seed", SEEDS)
def test_forward_dynamics_inverts_the_inverse(robot: Robot, seed: int) -> None:
    q, qd, qdd = state(robot, seed)
    torque = inverse_dynamics(robot)(q, qd, qdd, chi(robot, seed))
    np.testing.assert_allclose(dense(forward_dynamics(robot)(q, qd, torque, chi(robot, seed))), qdd, rtol=1e-9)
    np.testing.assert_allclose(
        dense(
            inverse_dynamics(robot)(q, qd, forward_dynamics(robot)(q, qd, qdd, chi(robot, seed)), chi(robot, seed))
        ),
        qdd,
        rtol=1e-9,
    )


@pytest.mark.parametrize("seed", SEEDS)
def test_mass_matrix_is_symmetric_and_positive(robot: Robot, seed: int) -> None:
    q, _, _ = state(robot, seed)
    A = dense(mass_matrix(robot)(q, chi(robot, seed)))
    np.testing.assert_array_equal(A, A.T)
    assert np.linalg.eigvalsh(A)[0] > 0.0
    still = np.zeros(robot.n)
    torque = inverse_dynamics(robot)
    columns = [
        dense(torque(q, still, e, chi(robot, seed)) - torque(q, still, still, chi(robot, seed)))
        for e in np.eye(robot.n)
    ]
    np.testing.assert_allclose(A, np.transpose(columns), rtol=1e-12, atol=1e-12 * np.abs(A).max())


@pytest.mark.parametrize("seed", SEEDS)
def test_torque_is_the_sum_of_its_parts(robot: Robot, seed: int) -> None:
    q, qd, qdd = state(robot, seed)
    values = chi(robot, seed)
    C = dense(coriolis_matrix(robot)(q, qd, values))
    np.testing.assert_allclose(C @ qd, dense(coriolis(robot)(q, qd, values)), rtol=1e-11, atol=1e-11)
    parts = dense(mass_matrix(robot)(q, values)) @ qdd + C @ qd
    parts += dense(gravity(robot)(q, values)) + dense(drive_torque(robot)(q, qd, values))
    np.testing.assert_allclose(dense(inverse_dynamics(robot)(q, qd, qdd, values)), parts, rtol=1e-10, atol=1e-10)


def test_coriolis_matrix_keeps_energy(robot: Robot) -> None:
    """dA/dt - 2 C is skew-symmetric."""
    q, qd, values = ca.SX.sym("q", robot.n), ca.SX.sym("qd", robot.n), chi(robot, 0)
    A = mass_matrix(robot)(q, values)
    rate = ca.reshape(ca.jtimes(ca.densify(ca.vec(A)), q, qd), robot.n, robot.n)
    skew = ca.Function("skew", [q, qd], [rate - 2 * coriolis_matrix(robot)(q, qd, values)])
    N = dense(skew(*state(robot, 0)[:2]))
    assert np.abs(N).max() > 1e-3
    np.testing.assert_allclose(N, -N.T, atol=1e-12)


def energies(robot: Robot, q: ca.SX, qd: ca.SX, values: dict[str, float]) -> tuple[ca.SX, ca.SX]:
    """Kinetic and potential energy of the links, from the frames of each and its pseudo-inertia alone."""
    kinetic, potential = ca.SX(0), ca.SX(0)
    for link in range(1, robot.n + 1):
        R, p = forward_kinematics(Robot("part", robot.joints[:link]))(q[:link])
        xx, xy, xz, yy, yz, zz, mx, my, mz, m = (values[f"{kind}{link}"] for kind in INERTIAL)
        J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        h = np.array([[mx], [my], [mz]])
        P = np.block([[np.trace(J) / 2 * np.eye(3) - J, h], [h.T, np.array([[m]])]])
        frame = ca.horzcat(R, p)
        speed = ca.reshape(ca.jtimes(ca.vec(frame), q, qd), 3, 4)
        kinetic += 0.5 * ca.trace(speed @ P @ speed.T)
        potential -= ca.dot(ca.DM(robot.gravity), frame @ P[:, 3])
    return kinetic, potential


def test_inverse_dynamics_agrees_with_lagrange(robot: Robot) -> None:
    """Links only: Gamma = d/dt(dT/dqd) - dT/dq + dU/dq."""
    links = replace(robot, drives=Drives(rotor_inertia=False, friction=False))
    q, qd, qdd = (ca.SX.sym(symbol, robot.n) for symbol in ("q", "qd", "qdd"))
    kinetic, potential = energies(links, q, qd, parameters(links, 0))
    momentum = ca.gradient(kinetic, qd)
    weight = ca.gradient(potential, q)
    rate = ca.jtimes(momentum, q, qd) + ca.jtimes(momentum, qd, qdd)
    lagrange = ca.Function("lagrange", [q, qd, qdd], [rate - ca.gradient(kinetic, q) + weight, weight])
    torque, holding = (dense(part) for part in lagrange(*state(robot, 0)))
    point, values = state(robot, 0), chi(links, 0)
    np.testing.assert_allclose(dense(inverse_dynamics(links)(*point, values)), torque, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(dense(gravity(links)(point[0], values)), holding, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("seed", SEEDS)
def test_base_parameters_give_the_same_torques(robot: Robot, seed: int) -> None:
    base = base_parameters(robot)
    reduced = base.value(parameters(robot, seed))
    q, qd, qdd = state(robot, seed)
    expected = dense(inverse_dynamics(robot)(q, qd, qdd, chi(robot, seed)))
    torque = inverse_dynamics_base(robot, base)
    np.testing.assert_allclose(dense(torque(q, qd, qdd, reduced)), expected, rtol=1e-9, atol=1e-9)
    spring = np.zeros(robot.n)
    if robot.spring:
        joint = robot.spring.joint - 1
        spring[joint] = robot.spring.torque(q[joint : joint + 1])[0]
    by_columns = dense(base_regressor(robot, base)(q, qd, qdd)) @ reduced - spring
    np.testing.assert_allclose(by_columns, expected, rtol=1e-9, atol=1e-9)


def test_base_parameters_need_fewer_operations(robot: Robot) -> None:
    base = base_parameters(robot)
    reduced, regressor = inverse_dynamics_base(robot, base), base_regressor(robot, base)
    assert reduced.n_instructions() < inverse_dynamics(robot).n_instructions()
    assert reduced.n_instructions() < regressor.n_instructions() + 2 * regressor.nnz_out(0)


def test_essential_regressor_is_columns_of_the_base_regressor(robot: Robot) -> None:
    base, names = base_parameters(robot), essential_names(robot)
    whole = dense(base_regressor(robot, base)(*state(robot, 0)))
    chosen = dense(essential_regressor(robot, base, names)(*state(robot, 0)))
    np.testing.assert_allclose(
        chosen, whole[:, [base.columns.index(name) for name in names]], rtol=1e-13, atol=1e-13
    )


def test_essential_regressor_refuses_what_is_no_base_parameter() -> None:
    robot = load_robot("rx90")
    with pytest.raises(KeyError, match="'M6' is not a base parameter of robot 'rx90'"):
        essential_regressor(robot, base_parameters(robot), ["ZZ1", "M6"])


@pytest.mark.parametrize("name", MAKERS)
def test_function_is_named_and_repeats_no_operation(robot: Robot, name: str) -> None:
    function = MAKERS[name](robot)
    assert function.name() == name
    steps = [(step.name, step.arguments) for step in read_program(function).steps]
    assert len(set(steps)) == len(steps)


@pytest.mark.parametrize("name", MAKERS)
def test_function_serves_in_an_optimisation(robot: Robot, name: str) -> None:
    """Called on MX, with a gradient that agrees with central differences."""
    function = MAKERS[name](robot)
    base = base_parameters(robot)
    values = base.value(parameters(robot, 1)) if name == "inverse_dynamics_base" else chi(robot, 1)
    q, qd, third = state(robot, 1)
    known = {"q": q, "qd": qd, "qdd": third, "Gamma": third, "chi": values}
    point = np.concatenate([known[function.name_in(k)] for k in range(function.n_in())])
    x = ca.MX.sym("x", len(point))
    parts = ca.vertsplit(x, np.cumsum([0, *(function.numel_in(k) for k in range(function.n_in()))]).tolist())
    output = ca.vec(ca.densify(function(*parts)))
    weights = np.random.default_rng(2).uniform(0.5, 1.5, output.numel())
    cost = ca.dot(weights, output) + ca.sumsqr(x)
    value = ca.Function("value", [x], [cost, ca.gradient(cost, x)])
    gradient = dense(value(point)[1])
    step = 1e-5
    slopes = [
        float(value(point + step * e)[0] - value(point - step * e)[0]) / (2 * step) for e in np.eye(len(point))
    ]
    np.testing.assert_allclose(gradient, slopes, rtol=1e-5, atol=1e-6 * np.abs(gradient).max())


def test_motion_by_base_parameters(robot: Robot) -> None:
    """Forward dynamics needs no more than the base parameters."""
    base, draw = base_parameters(robot), np.random.default_rng(0)
    values = dict(zip(standard_columns(robot), draw.uniform(0.01, 0.1, len(standard_columns(robot))), strict=True))
    for j in range(1, robot.n + 1):
        values |= {f"XX{j}": 0.5, f"YY{j}": 0.5, f"ZZ{j}": 0.5, f"M{j}": 2.0, f"IA{j}": 1.0}
    values = {name: values[name] for name in standard_columns(robot)}
    q, qd, torque = draw.uniform(-1.0, 1.0, (3, robot.n))
    by_base = np.array(forward_dynamics_base(robot, base)(q, qd, torque, base.value(values)))
    by_standard = np.array(forward_dynamics(robot)(q, qd, torque, list(values.values())))
    assert np.allclose(by_base, by_standard, rtol=1e-8, atol=1e-8)


def test_smooth_dry_friction_nears_the_sign(robot: Robot) -> None:
    names, draw = dry_friction_names(robot), np.random.default_rng(1)
    level, qd = draw.uniform(1.0, 2.0, len(names)), draw.uniform(0.5, 1.0, robot.n) * draw.choice([-1, 1], robot.n)
    smooth = np.array(smooth_dry_friction(robot, 1e-3)(qd, level))[:, 0]
    values = dict.fromkeys(standard_columns(robot), 0.0) | dict(zip(names, level, strict=True))
    still = np.zeros(robot.n)
    bare = replace(robot, drives=replace(robot.drives, spring=None))
    sharp = np.array(drive_torque(bare)(still, qd, [values[name] for name in standard_columns(robot)]))[:, 0]
    assert np.allclose(smooth, sharp, atol=1e-12)
    assert not np.array(smooth_dry_friction(robot, 1e-3)(still, level)).any()
