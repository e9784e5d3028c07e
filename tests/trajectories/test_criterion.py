"""Criteria and the design's regressor: values against NumPy's own and the model's, slopes against differences."""

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.model import Robot, base_parameters, load_robot, regressor
from dynident.model.base.rank import random_states
from dynident.tests.conftest import CROOKED, SCARA
from dynident.trajectories.design.criterion import Criterion, Kind, condition_numbers
from dynident.trajectories.design.information import SPRING, RegressorKernel, regressor_kernel
from dynident.trajectories.motions.family import Samples

DRAW = np.random.default_rng(0)
W = DRAW.standard_normal((60, 6)) * np.array([1.0, 3.0, 0.2, 5.0, 0.7, 1.5])
REFERENCE = np.array([1.0, -2.0, 3.0, 0.5, 1.0, 4.0])


def scaled(W: Array) -> Array:
    return np.asarray(W / np.linalg.norm(W, axis=0))


def test_condition_numbers_are_numpys() -> None:
    plain, columns = condition_numbers(W)
    assert plain == pytest.approx(np.linalg.cond(W))
    assert columns == pytest.approx(np.linalg.cond(scaled(W)))


@pytest.mark.parametrize(("kind", "matrix"), [("cond", W), ("cond-scaled", scaled(W))])
def test_the_surrogate_is_an_upper_bound_that_closes(kind: Kind, matrix: Array) -> None:
    exact = np.log(np.linalg.cond(matrix))
    values = [Criterion(kind)(W.T @ W, p)[0] for p in (1.0, 8.0, 24.0, 400.0)]
    assert all(np.diff(values) <= 0.0)
    assert values[-1] == pytest.approx(exact, abs=0.01)
    assert min(values) >= exact - 1e-12


def test_d_and_a_are_what_they_say() -> None:
    G = W.T @ W
    covariance = np.linalg.inv(G)
    assert Criterion("d")(G)[0] == pytest.approx(-np.linalg.slogdet(G)[1] / 6)
    own = covariance[np.ix_([1, 4], [1, 4])]
    assert Criterion("d", interest=[1, 4])(G)[0] == pytest.approx(np.linalg.slogdet(own)[1] / 2)
    relative = np.sqrt(np.diag(covariance)) / REFERENCE
    assert Criterion("a", REFERENCE)(G)[0] == pytest.approx(0.5 * np.log((relative**2).mean()))
    assert Criterion("a", REFERENCE, [2, 3])(G)[0] == pytest.approx(0.5 * np.log((relative[2:4] ** 2).mean()))


CRITERIA = {
    "d": Criterion("d"),
    "d of two": Criterion("d", interest=[0, 3]),
    "a": Criterion("a", REFERENCE),
    "a of three": Criterion("a", REFERENCE, [1, 2, 5]),
    "cond": Criterion("cond"),
    "cond-scaled": Criterion("cond-scaled"),
}


@pytest.mark.parametrize("name", CRITERIA)
@pytest.mark.parametrize("order", [1.0, 8.0, 24.0])
def test_slopes_are_derivatives(name: str, order: float) -> None:
    G, step = W.T @ W, 1e-5
    direction = DRAW.standard_normal((6, 6))
    direction = direction + direction.T
    M = CRITERIA[name](G, order)[1]
    ahead, behind = (CRITERIA[name](G + s * direction, order)[0] for s in (step, -step))
    assert np.allclose(M, M.T, atol=1e-12 * np.abs(M).max())
    assert np.sum(M * direction) == pytest.approx((ahead - behind) / (2 * step), rel=1e-6)


def test_a_singular_matrix_has_no_condition_number() -> None:
    twice = np.column_stack([W, W[:, 0] + W[:, 1]])
    assert condition_numbers(twice) == (np.inf, np.inf)
    assert condition_numbers(np.column_stack([W, np.zeros(60)])) == (np.inf, np.inf)
    assert condition_numbers(W[:4]) == (np.inf, np.inf)
    G = np.column_stack([W, np.zeros(60)])
    assert Criterion("d")(G.T @ G)[0] == np.inf
    assert Criterion("cond-scaled")(G.T @ G)[0] == np.inf


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
