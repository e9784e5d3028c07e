"""Base parameters for which a possible robot exists."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cvxpy
import numpy as np
import pytest
from dynident.apps.logs.read import read_recording
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import Estimate, PossibleBody, Settings, identify
from dynident.estimation.fit.estimate import Fit
from dynident.estimation.possible.cone import ConeProgram, solve_cone
from dynident.estimation.possible.constraints import PSEUDO_INERTIA
from dynident.estimation.possible.robot import solve_constrained_base
from dynident.model import INERTIAL, BaseParameters, InertialParameters, Robot, base_parameters, load_robot

NOTHING = Fit(np.ones(1), np.ones(1), (1,))
Parameters = Callable[[Robot, int], dict[str, float]]


def noisy_estimate(base: BaseParameters, truth: Array, seed: int, size: float = 0.5) -> Estimate:
    """Base parameters with correlated errors."""
    draw = np.random.default_rng(seed)
    n = len(truth)
    sigma = size * (np.abs(truth) + 0.1) * draw.uniform(0.2, 1.0, n)
    root = sigma[:, None] * (np.eye(n) + 0.3 * draw.standard_normal((n, n)) / np.sqrt(n))
    values = truth + root @ draw.standard_normal(n)
    return Estimate(base.columns, values, root @ root.T, np.inf, NOTHING, np.ones(1))


SHARED = (("IA5", "IA6"), ("FV5", "FVM6"), ("FV6", "FVM6"))
"""What holds a share of rotor 6, and that share."""


@pytest.fixture(scope="module")
def rx90_base(rx90: Robot) -> BaseParameters:
    return base_parameters(rx90)


@pytest.mark.parametrize("seed", range(5))
def test_some_robot_exists(
    rx90: Robot, rx90_base: BaseParameters, random_parameters: Parameters, seed: int
) -> None:
    """The robot holds every rule exactly and has the base parameters returned."""
    truth = rx90_base.value(random_parameters(rx90, seed))
    estimate = noisy_estimate(rx90_base, truth, seed)
    result = solve_constrained_base(rx90, rx90_base, estimate)
    for link in range(1, 7):
        ten = np.array([result.parameters[f"{kind}{link}"] for kind in INERTIAL])
        assert PossibleBody().violation(ten) <= 0.0
    kinds = ("IA", "FV", "FS", "FVM", "FSM")
    assert min(v for name, v in result.parameters.items() if name.rstrip("0123456789") in kinds) >= 0.0
    assert all(result.parameters[whole] >= result.parameters[part] for whole, part in SHARED)
    assert result.values == pytest.approx(rx90_base.value(result.parameters), rel=1e-12)
    error = result.values - estimate.values
    assert result.chi2_rise == pytest.approx(error @ np.linalg.solve(estimate.covariance, error), rel=1e-6)
    assert bool(result.active) == (result.chi2_rise > 1e-6)
    truth_error = truth - estimate.values
    assert result.chi2_rise <= truth_error @ np.linalg.solve(estimate.covariance, truth_error)


def test_cvxpy_agrees(rx90: Robot, rx90_base: BaseParameters, random_parameters: Parameters) -> None:
    """The problem written plainly, link by link, gives the same."""
    estimate = noisy_estimate(rx90_base, rx90_base.value(random_parameters(rx90, 7)), 7)
    result = solve_constrained_base(rx90, rx90_base, estimate)
    x = cvxpy.Variable(len(rx90_base.standard))
    place = rx90_base.standard.index
    rules = [x[place(whole)] >= x[place(part)] for whole, part in SHARED]
    for link in range(1, 7):
        ten = [x[place(f"{kind}{link}")] for kind in INERTIAL]
        rules.append(sum(v * J for v, J in zip(ten, PSEUDO_INERTIA, strict=True)) >> 0)
    kinds = ("IA", "FV", "FS", "FVM", "FSM")
    rules += [x[k] >= 0 for k, name in enumerate(rx90_base.standard) if name.rstrip("0123456789") in kinds]
    R = np.linalg.inv(np.linalg.cholesky(estimate.covariance))
    distance = cvxpy.norm(R @ (rx90_base.grouping @ x - estimate.values))
    problem = cvxpy.Problem(cvxpy.Minimize(distance), rules)
    problem.solve(solver="CLARABEL")
    assert result.chi2_rise == pytest.approx(problem.value**2, rel=1e-5)
    moved = (rx90_base.grouping @ x.value - result.values) / estimate.sigma
    assert np.abs(moved).max() < 1e-3


def test_a_robot_that_can_exist_stays(
    rx90: Robot, rx90_base: BaseParameters, random_parameters: Parameters
) -> None:
    truth = rx90_base.value(random_parameters(rx90, 3))
    estimate = replace(noisy_estimate(rx90_base, truth, 3), values=truth)
    result = solve_constrained_base(rx90, rx90_base, estimate)
    assert np.abs((result.values - truth) / estimate.sigma).max() < 1e-3
    assert result.p_value > 0.999


def test_negative_friction_is_named(rx90: Robot, rx90_base: BaseParameters, random_parameters: Parameters) -> None:
    values = rx90_base.value(random_parameters(rx90, 3))
    values[rx90_base.columns.index("FV3")] = -0.5
    estimate = replace(noisy_estimate(rx90_base, values, 3), values=values)
    result = solve_constrained_base(rx90, rx90_base, estimate)
    assert result.active[0].description == "FV3 >= 0"
    assert dict(zip(rx90_base.columns, result.values, strict=True))["FV3"] == pytest.approx(0.0, abs=1e-6)


def test_another_models_estimate_is_refused(rx90: Robot, rx90_base: BaseParameters) -> None:
    estimate = noisy_estimate(rx90_base, np.ones(len(rx90_base.columns)), 0)
    with pytest.raises(InputError, match="identify the robot anew"):
        solve_constrained_base(rx90, rx90_base, replace(estimate, names=estimate.names[::-1]))


@pytest.mark.parametrize(("name", "file"), [("ur10e", "ur10e/unloaded"), ("tx40", "tx40/tx40")])
def test_real_robots(recordings: Path, name: str, file: str) -> None:
    """Links that can exist explain the recordings as well as those that cannot."""
    robot = load_robot(name)
    gains = (11.976, 11.976, 9.839, 10.763, 10.757, 10.680) if name == "ur10e" else None
    identification = identify(
        robot, [read_recording(recordings / f"{file}.csv.gz", robot, gains)], Settings(robust=False)
    )
    result = solve_constrained_base(robot, identification.base, identification.estimate)
    assert result.min_pseudo_inertia_eigenvalue >= 0.0
    assert 0.1 < result.chi2_rise < 20.0
    assert result.p_value > 0.5


def test_a_program_without_an_attained_least_value_is_closed() -> None:
    """A body with a first moment of at least 1 has as little mass as its extent is large: none is the least."""
    only = np.eye(10)
    program = ConeProgram(only[9:], np.zeros(1), only[6:7], -np.ones(1), only[None])
    closed = solve_cone(program, [(1e5, 100.0)])
    assert np.linalg.norm(closed.z) <= 100.0 * (1.0 + 1e-6)
    assert 0.0 < closed.z[9] < 0.05
    assert InertialParameters(closed.z).min_pseudo_inertia_eigenvalue > -1e-6


def test_a_ball_that_is_far_away_changes_nothing() -> None:
    only = np.eye(10)
    target = InertialParameters.from_com(2.0, [0.1, 0.2, -0.1], 0.3 * np.eye(3)).vector
    program = ConeProgram(only, target, only[9:], np.zeros(1), only[None])
    np.testing.assert_allclose(solve_cone(program, [(1e5, 1e3)]).z, target, atol=1e-5)
