"""Parts of the dynamics fit together, serve in optimisations, and equal what NumPy alone computes."""

from collections.abc import Callable
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from dynident import model
from dynident.common.arrays import Array
from dynident.model.drives import parameter_kind
from dynident.model.dynamics import dry_friction_names, smooth_dry_friction
from dynident.model.frames import forward_kinematics, point_at
from dynident.model.kernel.kernel import read_program
from dynident.model.regressors import regressor_at
from dynident.tests.conftest import CROOKED
from dynident.tests.model.random_robots import random_robot

LAW = model.Spring(2, table=((-4.0, 30.0), (-0.5, 5.0), (1.0, -8.0), (4.0, -60.0)))
OTHERS = {"crooked": CROOKED, "table": replace(CROOKED, name="table", drives=model.Drives(spring=LAW))}
MAKERS: dict[str, Callable[[model.Robot], ca.Function]] = {
    "inverse_dynamics": model.inverse_dynamics,
    "inverse_dynamics_base": lambda robot: model.inverse_dynamics_base(robot, model.base_parameters(robot)),
    "mass_matrix": model.mass_matrix,
    "coriolis": model.coriolis,
    "coriolis_matrix": model.coriolis_matrix,
    "gravity": model.gravity,
    "forward_dynamics": model.forward_dynamics,
    "standard_regressor": model.standard_regressor,
    "base_regressor": lambda robot: model.base_regressor(robot, model.base_parameters(robot)),
    "payload_regressor": model.payload_regressor,
}


@pytest.fixture(params=[*model.robot_names(), *OTHERS])
def robot(request: pytest.FixtureRequest) -> model.Robot:
    """The shipped robots, and two with sliding joints and a spring, by its law and by a table."""
    return OTHERS.get(request.param) or model.load_robot(request.param)


@pytest.fixture
def chi(robot: model.Robot, random_parameters: Callable[[model.Robot, int], dict[str, float]]) -> Array:
    """Standard parameters of a robot that can exist."""
    values = random_parameters(robot, 0)
    return np.array([values[name] for name in model.standard_columns(robot)])


def named(robot: model.Robot, chi: Array) -> dict[str, float]:
    return dict(zip(model.standard_columns(robot), chi.tolist(), strict=True))


def state(robot: model.Robot) -> Array:
    return np.random.default_rng(100).uniform(-2.0, 2.0, (3, robot.n))


def dense(value: ca.DM) -> Array:
    array = np.asarray(value.full())
    return array.ravel() if array.shape[1] == 1 else array


def spring_torque(robot: model.Robot, q: Array) -> Array:
    spring = robot.spring
    return np.array([spring.torque(q[[j]])[0] if spring and spring.joint == j + 1 else 0.0 for j in range(robot.n)])


def drive_torque(robot: model.Robot, q: Array, qd: Array, chi: Array) -> Array:
    """Friction and offsets less the torque of the spring, by the regressor."""
    drives = np.array([parameter_kind(name) not in model.INERTIAL for name in model.standard_columns(robot)])
    phi = dense(model.standard_regressor(robot)(q, qd, np.zeros(robot.n)))
    return np.asarray(phi[:, drives] @ chi[drives] - spring_torque(robot, q))


def test_forward_dynamics_inverts_the_inverse(robot: model.Robot, chi: Array) -> None:
    """And needs no more than the base parameters."""
    q, qd, qdd = state(robot)
    inverse, forward, base = (
        model.inverse_dynamics(robot),
        model.forward_dynamics(robot),
        model.base_parameters(robot),
    )
    np.testing.assert_allclose(dense(forward(q, qd, inverse(q, qd, qdd, chi), chi)), qdd, rtol=1e-9)
    np.testing.assert_allclose(dense(inverse(q, qd, forward(q, qd, qdd, chi), chi)), qdd, rtol=1e-9)
    by_base = model.forward_dynamics_base(robot, base)(q, qd, qdd, base.value(named(robot, chi)))
    np.testing.assert_allclose(dense(by_base), dense(forward(q, qd, qdd, chi)), rtol=1e-8, atol=1e-8)


def test_torque_is_the_sum_of_its_parts(robot: model.Robot, chi: Array) -> None:
    """That of gravity and the drives alone at rest; dA/dt - 2 C is skew-symmetric: the energy is kept."""
    q, qd, qdd = state(robot)
    torque, still, weight = model.inverse_dynamics(robot), np.zeros(robot.n), dense(model.gravity(robot)(q, chi))
    C = dense(model.coriolis_matrix(robot)(q, qd, chi))
    np.testing.assert_allclose(C @ qd, dense(model.coriolis(robot)(q, qd, chi)), rtol=1e-11, atol=1e-11)
    parts = dense(model.mass_matrix(robot)(q, chi)) @ qdd + C @ qd + weight + drive_torque(robot, q, qd, chi)
    np.testing.assert_allclose(dense(torque(q, qd, qdd, chi)), parts, rtol=1e-10, atol=1e-10)
    resting = weight + drive_torque(robot, q, still, chi)
    np.testing.assert_allclose(dense(torque(q, still, still, chi)), resting, rtol=1e-10, atol=1e-10)
    place, speed = ca.SX.sym("q", robot.n), ca.SX.sym("qd", robot.n)
    A = ca.densify(ca.vec(model.mass_matrix(robot)(place, chi)))
    rate = ca.reshape(ca.jtimes(A, place, speed), robot.n, robot.n)
    skew = ca.Function("skew", [place, speed], [rate - 2 * model.coriolis_matrix(robot)(place, speed, chi)])
    N = dense(skew(q, qd))
    assert np.abs(N).max() > 1e-3
    np.testing.assert_allclose(N, -N.T, atol=1e-12)


def test_base_parameters_give_the_same_torques(robot: model.Robot, chi: Array) -> None:
    """With fewer operations; a regressor of some of them is its columns."""
    base, (q, qd, qdd) = model.base_parameters(robot), state(robot)
    names = base.columns[1::2]
    reduced, phi = base.value(named(robot, chi)), model.base_regressor(robot, base)
    expected, torque = (
        dense(model.inverse_dynamics(robot)(q, qd, qdd, chi)),
        model.inverse_dynamics_base(robot, base),
    )
    np.testing.assert_allclose(dense(torque(q, qd, qdd, reduced)), expected, rtol=1e-9, atol=1e-9)
    whole = dense(phi(q, qd, qdd))
    np.testing.assert_allclose(whole @ reduced - spring_torque(robot, q), expected, rtol=1e-9, atol=1e-9)
    assert torque.n_instructions() < model.inverse_dynamics(robot).n_instructions()
    assert torque.n_instructions() < phi.n_instructions() + 2 * phi.nnz_out(0)
    chosen = dense(model.regressor(robot, names)(q, qd, qdd))
    np.testing.assert_allclose(
        chosen, whole[:, [base.columns.index(name) for name in names]], rtol=1e-13, atol=1e-13
    )


@pytest.mark.parametrize("name", MAKERS)
def test_function_serves_in_an_optimisation(robot: model.Robot, chi: Array, name: str) -> None:
    """Named, no operation repeated; called on MX, with a gradient that agrees with central differences."""
    function, base = MAKERS[name](robot), model.base_parameters(robot)
    assert function.name() == name
    steps = [(name, arguments) for name, _, arguments in read_program(function).steps]
    assert len(set(steps)) == len(steps)
    values = base.value(named(robot, chi)) if name == "inverse_dynamics_base" else chi
    q, qd, third = state(robot)
    known = {"q": q, "qd": qd, "qdd": third, "Gamma": third, "chi": values}
    point = np.concatenate([known[function.name_in(k)] for k in range(function.n_in())])
    x = ca.MX.sym("x", len(point))
    parts = ca.vertsplit(x, np.cumsum([0, *(function.numel_in(k) for k in range(function.n_in()))]).tolist())
    output = ca.vec(ca.densify(function(*parts)))
    weights, step = np.random.default_rng(2).uniform(0.5, 1.5, output.numel()), 1e-5
    cost = ca.dot(weights, output) + ca.sumsqr(x)
    value = ca.Function("value", [x], [cost, ca.gradient(cost, x)])
    ends = [[float(value(point + sign * step * e)[0]) for sign in (1, -1)] for e in np.eye(len(point))]
    slopes, gradient = np.array(ends) @ [1.0, -1.0] / (2.0 * step), dense(value(point)[1])
    np.testing.assert_allclose(gradient, slopes, rtol=1e-5, atol=1e-6 * np.abs(gradient).max())


def test_smooth_dry_friction_nears_the_sign(robot: model.Robot) -> None:
    names, draw, still = dry_friction_names(robot), np.random.default_rng(1), np.zeros(robot.n)
    level, qd = draw.uniform(1.0, 2.0, len(names)), draw.uniform(0.5, 1.0, robot.n) * draw.choice([-1, 1], robot.n)
    values = dict.fromkeys(model.standard_columns(robot), 0.0) | dict(zip(names, level, strict=True))
    bare = replace(robot, drives=replace(robot.drives, spring=None))
    sharp = drive_torque(bare, still, qd, np.array(list(values.values())))
    smooth = smooth_dry_friction(robot, 1e-3)
    np.testing.assert_allclose(dense(smooth(qd, level)), sharp, atol=1e-12)
    assert not dense(smooth(still, level)).any()


def _sliding() -> model.Robot:
    robot = model.load_robot("irb120")
    second = replace(robot.joints[1], kind="prismatic", theta=0.3, r=0.2, d=0.1)
    return replace(robot, joints=(robot.joints[0], second, *robot.joints[2:]), gravity=(1.0, -2.0, -9.0))


ROBOTS = {name: model.load_robot(name) for name in model.robot_names()} | {"sliding": _sliding()}
RANDOM = {robot.name: robot for robot in map(random_robot, range(12))}


@pytest.mark.parametrize("name", ROBOTS | RANDOM)
def test_many_states_equal_one_after_the_other(name: str) -> None:
    robot = (ROBOTS | RANDOM)[name]
    columns = model.standard_columns(robot)
    states = np.random.default_rng(0).normal(size=(3, 7, robot.n))
    function = model.regressor(robot, columns)
    single = np.array([np.array(function(*state)) for state in zip(*states, strict=True)])
    many = regressor_at(robot, columns, *states)
    np.testing.assert_allclose(many.transpose(2, 0, 1), single, atol=1e-12)


@pytest.mark.parametrize("name", ROBOTS)
def test_a_point_of_the_last_link_is_where_kinematics_put_it(name: str) -> None:
    """Joints move it by the derivative of its place."""
    robot, point = ROBOTS[name], np.array([0.1, -0.2, 0.3])
    q = ca.SX.sym("q", robot.n)
    R, p = forward_kinematics(robot)(q)
    place = p + R @ ca.DM(point)
    function = ca.Function("place", [q], [place, ca.jacobian(place, q)])
    states = np.random.default_rng(2).normal(size=(5, robot.n))
    places, moved = point_at(robot, point, states)
    for k, state in enumerate(states):
        single = function(state)
        np.testing.assert_allclose(places[:, k], np.array(single[0])[:, 0], atol=1e-12)
        np.testing.assert_allclose(moved[:, :, k], np.array(single[1]), atol=1e-12)


@pytest.mark.parametrize("name", ["rx90", "panda"])
def test_smooth_torques_have_slopes(name: str) -> None:
    """Against central differences; where dry friction is smooth, it is next to the sign at speed."""
    robot, draw = model.load_robot(name), np.random.default_rng(5)
    chi, x, step = draw.uniform(0.1, 1.0, len(robot.standard)), draw.uniform(-1.0, 1.0, 3 * robot.n), 1e-6
    smooth = model.inverse_dynamics(robot, smooth=0.05)

    def torque(states: Array) -> Array:
        return dense(smooth(*np.split(states, 3), chi)).ravel()

    slopes = np.hstack([part.full() for part in model.inverse_dynamics_slopes(robot, 0.05)(*np.split(x, 3), chi)])
    around = [(torque(x + step * e) - torque(x - step * e)) / (2.0 * step) for e in np.eye(len(x))]
    assert slopes == pytest.approx(np.transpose(around), rel=1e-5, abs=1e-5)
    fast = np.split(x, 3)
    fast[1] = np.sign(fast[1])
    assert dense(smooth(*fast, chi)) == pytest.approx(dense(model.inverse_dynamics(robot)(*fast, chi)), abs=1e-9)
