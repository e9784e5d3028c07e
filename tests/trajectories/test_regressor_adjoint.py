"""The design's regressor: entries against the model's own, the smooth sign, and the adjoint of every robot."""

import numpy as np
import pytest
from dynident.model import Robot, base_parameters, load_robot, regressor
from dynident.model.base.rank import random_states
from dynident.model.regressors import smooth_regressor
from dynident.tests.conftest import CROOKED, SCARA
from dynident.trajectories.design.information import SPRING, RegressorKernel, regressor_kernel
from dynident.trajectories.motions.family import Samples

ROBOTS = {robot.name: robot for robot in (load_robot("rx90"), CROOKED, SCARA)}


def columns(robot: Robot) -> tuple[str, ...]:
    own = base_parameters(robot).columns
    return (*own, SPRING) if robot.spring else own


@pytest.fixture(scope="module", params=ROBOTS)
def kernel(request: pytest.FixtureRequest) -> tuple[Robot, RegressorKernel]:
    robot = ROBOTS[request.param]
    return robot, regressor_kernel(robot, columns(robot))


def samples(robot: Robot, count: int = 11) -> Samples:
    return Samples(np.linspace(0.5, 1.5, count), *random_states(robot, count, 0))


def test_the_matrix_is_the_regressor(kernel: tuple[Robot, RegressorKernel]) -> None:
    robot, own = kernel
    data = samples(robot)
    names = [name for name in own.columns if name != SPRING]
    phi = regressor(robot, names)
    W = own.matrix(data).reshape(robot.n, -1, len(own.columns))
    for k in range(len(data.q)):
        expected = np.asarray(phi(data.q[k], data.qd[k], data.qdd[k]))
        assert np.allclose(W[:, k, [own.columns.index(name) for name in names]], expected, atol=1e-12)
        if robot.spring:
            j = robot.spring.joint - 1
            assert W[j, k, -1] == pytest.approx(robot.spring.torque(data.q[k, j : j + 1])[0])


def test_gram_and_torque_are_products_of_the_matrix(kernel: tuple[Robot, RegressorKernel]) -> None:
    robot, own = kernel
    data, draw = samples(robot), np.random.default_rng(1)
    entries, W = own.entries(data, 0.0), own.matrix(data)
    weights = draw.uniform(0.5, 2.0, (robot.n, len(data.q)))
    assert np.allclose(own.gram(entries, weights), (W * weights.reshape(-1, 1)).T @ W, rtol=1e-10)
    chi = draw.standard_normal(len(own.columns))
    assert np.allclose(own.torque(entries, chi), (W @ chi).reshape(robot.n, -1).T)


def test_the_adjoint_is_the_derivative(kernel: tuple[Robot, RegressorKernel]) -> None:
    robot, own = kernel
    data, draw, step = samples(robot), np.random.default_rng(2), 1e-6
    seed = draw.standard_normal(own.entries(data, 0.3).shape)
    slopes = own.state_slope(data, 0.3, seed)
    for k, slope in enumerate(slopes, start=1):
        direction = draw.standard_normal(data.q.shape)
        ahead, behind = (
            own.entries(data._replace(**{data._fields[k]: data[k] + s * direction}), 0.3) for s in (step, -step)
        )
        expected = np.sum(seed * (ahead - behind)) / (2 * step)
        assert np.sum(slope * direction) == pytest.approx(expected, rel=1e-6, abs=1e-7)


def test_the_smooth_sign_becomes_the_sign() -> None:
    robot = load_robot("rx90")
    names = base_parameters(robot).columns
    q, qd, qdd = (x[0] for x in random_states(robot, 1, 3))
    exact = np.asarray(regressor(robot, names)(q, qd, qdd))
    assert np.allclose(np.asarray(smooth_regressor(robot, names)(q, qd, qdd, 1e-3)), exact, atol=1e-12)
    wide = np.asarray(smooth_regressor(robot, names)(q, qd, qdd, 2.0))
    place = names.index("FS2")
    assert wide[1, place] == pytest.approx(np.tanh(qd[1] / 2.0))
    place = names.index("FSM6")
    assert wide[4, place] == pytest.approx(np.tanh((qd[4] + qd[5]) / 2.0))
