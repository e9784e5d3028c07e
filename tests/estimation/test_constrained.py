"""Constrained payloads: only bodies that can exist, nearest to the free estimate, the same by CVXPY."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.commands.demo import PAYLOAD as PAPER_PAYLOAD
from dynident.apps.logs.read import read_recording
from dynident.common.errors import InputError
from dynident.estimation import (
    PAYLOAD,
    KnownMass,
    LongMotion,
    MassBounds,
    PossibleBody,
    Settings,
    SolverError,
    payload_estimate,
    payload_problem,
    solve_constrained,
)
from dynident.estimation.equations.equations import merged
from dynident.estimation.payload.methods import combined
from dynident.estimation.payload.problem import long_motion
from dynident.estimation.possible.cone import ConeProgram, solve_cone
from dynident.model import InertialParameters, load_robot
from dynident.model.friction import PAPER
from dynident.model.motion import Measurement
from dynident.tests.estimation.estimates import EXACT, TABLES, all_ten, estimate_of, random_estimate
from dynident.trajectories import Simulator


@pytest.mark.parametrize(("table", "principal"), [(1, (0.0074, 0.0251, 0.0376)), (2, (0.0080, 0.0140, 0.0270))])
def test_published_payloads_cannot_exist(table: int, principal: tuple[float, ...]) -> None:
    """The triangle inequality of the payload's principal inertias fails, though all of them are positive."""
    x = all_ten(TABLES[table])
    body = InertialParameters(x)
    moments = np.linalg.eigvalsh(body.inertia_com)
    assert moments == pytest.approx(principal, abs=1.1e-4)
    assert moments[2] - moments[1] - moments[0] == pytest.approx(5.1e-3, abs=1e-4)
    rule = PossibleBody("payload of the paper")
    assert rule.violation(x) == pytest.approx({1: 2.6e-3, 2: 2.5e-3}[table], abs=1e-4)


@pytest.mark.parametrize(("table", "chi2"), [(1, 0.16), (2, 0.62)])
def test_nearest_possible_payload_costs_nothing(table: int, chi2: float) -> None:
    result = solve_constrained(TABLES[table])
    assert result.chi2_rise == pytest.approx(chi2, abs=0.005)
    moved = result.values[[PAYLOAD.index(name) for name in result.free.names]] - result.free.values
    assert np.abs(moved / result.free.sigma).max() < 0.5
    assert result.body.physically_consistent
    assert [active.constraint for active in result.active] == [PossibleBody()]
    assert result.p_value > 0.98


@pytest.mark.parametrize("reading", ["zero", "unknown", "as in Table 1"])
def test_every_reading_of_table_2_agrees(reading: str) -> None:
    """The eliminated XY XZ YZ MX MY stay zero whether they are fixed, unknown or have Table 1's sigma.

    The values printed are a body symmetric in x and in y, and so is the nearest one.
    """
    printed_two = TABLES[2]
    if reading == "zero":
        result = solve_constrained(printed_two)
        assert (result.values[[1, 2, 4, 6, 7]] == 0.0).all()
    else:
        sigma = TABLES[1].sigma.copy() * (1.0 if reading == "as in Table 1" else 100.0)
        sigma[[PAYLOAD.index(name) for name in printed_two.names]] = printed_two.sigma
        result = solve_constrained(estimate_of(all_ten(printed_two), np.diag(sigma**2)))
        assert np.abs(result.values[[1, 2, 4, 6, 7]]).max() < 1e-4
    assert result.chi2_rise == pytest.approx(0.6166, abs=1e-4)


def test_reference_payload_passes_by_a_hair() -> None:
    body = PAPER_PAYLOAD
    assert PossibleBody().violation(body.vector) == pytest.approx(-2.9e-4, abs=1e-5)


@pytest.mark.long
def test_no_negative_eigenvalue_in_a_thousand() -> None:
    """Not even by rounding, in SI units; chi2 is that of the values returned, and cannot exceed the truth's."""
    solved = 0
    for seed in range(1000):
        estimate = random_estimate(seed)
        result = solve_constrained(estimate)
        assert result.min_pseudo_inertia_eigenvalue >= 0.0
        assert np.linalg.eigvalsh(InertialParameters(result.values).pseudo_inertia)[0] >= 0.0
        error = result.values - estimate.values
        distance = error @ np.linalg.solve(estimate.covariance, error)
        assert result.chi2_rise == pytest.approx(distance, rel=1e-3, abs=1e-6)
        solved += result.status == "Solved"
    assert solved > 400


def test_a_possible_estimate_is_left_alone() -> None:
    values = InertialParameters.from_com(2.0, [0.1, 0.0, 0.2], np.diag([0.02, 0.02, 0.03])).vector
    result = solve_constrained(estimate_of(values, np.diag(np.full(10, 1e-4))))
    assert (result.values == values).all()
    assert (result.chi2_rise, result.status, result.active) == (0.0, "free", ())
    assert result.p_value == 1.0


def test_result_is_nearest(random_bodies: Callable[[int, int], list[InertialParameters]]) -> None:
    """No step towards a body that can exist comes nearer: the projection's variational inequality."""
    for seed in (1, 4, 6):
        estimate = random_estimate(seed)
        result = solve_constrained(estimate)
        assert result.status == "Solved"
        gradient = np.linalg.solve(estimate.covariance, result.values - estimate.values)
        for body in random_bodies(50, seed):
            assert gradient @ (body.vector - result.values) > -1e-4 * (1.0 + abs(gradient @ body.vector))


def test_a_scale_pulls_the_mass() -> None:
    """Two independent measurements of one mass, weighted by their variances; chi2 of their difference."""
    values = InertialParameters.from_com(2.0, [0.1, 0.0, 0.2], np.diag([0.02, 0.02, 0.03])).vector
    free = estimate_of(values, np.diag(np.full(10, 1e-4)))
    result = solve_constrained(free, [KnownMass(2.03, 0.02)])
    assert result.body.mass == pytest.approx((2.0 / 1e-4 + 2.03 / 4e-4) / (1e4 + 2500.0))
    assert result.chi2_rise == pytest.approx(0.03**2 / 5e-4)


def test_p_value_is_conservative() -> None:
    """True payload a thin disc on the boundary: fewer than 5 % of the rises have p < 0.05."""
    truth = InertialParameters.from_com(7.0, [0.0, 0.0, 0.143], np.diag([0.0175, 0.0175, 0.035])).vector
    draw = np.random.default_rng(0)
    sigma = TABLES[1].sigma
    small = 0
    for _ in range(200):
        estimate = estimate_of(truth + sigma * draw.standard_normal(10), np.diag(sigma**2))
        small += solve_constrained(estimate).p_value < 0.05
    assert small <= 10


def test_impossible_combination_raises_with_the_problem() -> None:
    with pytest.raises(SolverError, match="no body holds all constraints") as caught:
        solve_constrained(TABLES[1], [MassBounds(7.0, 7.5), MassBounds(8.0, 9.0)])
    assert caught.value.status == "PrimalInfeasible"


def test_rank_and_finiteness_are_checked_first() -> None:
    sigma = TABLES[1].sigma
    C = np.diag(sigma**2)
    C[8, 9] = C[9, 8] = sigma[8] * sigma[9]
    with pytest.raises(InputError, match="do not tell MZ_L, M_L apart"):
        solve_constrained(replace(TABLES[1], covariance=C))
    with pytest.raises(InputError, match="no covariance"):
        solve_constrained(replace(TABLES[1], covariance=np.diag(sigma**2 * ([1.0] * 9 + [0.0]))))
    with pytest.raises(InputError, match="not that of a payload"):
        solve_constrained(replace(TABLES[1], names=tuple(f"X{k}" for k in range(10))))


@pytest.fixture(scope="module")
def noisy(simulated: Callable[[str], Simulator], exact_pair: Callable[..., tuple[Measurement, ...]]) -> LongMotion:
    """An RX90 with so much noise that the free estimate is impossible."""
    simulator = simulated("rx90")
    robot = simulator.robot
    draw = np.random.default_rng(2)
    bare, loaded = (
        Measurement(data.motion, data.torque + 20.0 * draw.standard_normal(data.torque.shape))
        for data in exact_pair(simulator)
    )
    return long_motion(robot, [loaded], [bare], settings=Settings(EXACT, robust=False))


def test_joint_problem_gives_the_same(noisy: LongMotion) -> None:
    """Method 4 on the reduced factor, robot and payload together, the payload's pseudo-inertia constrained."""
    free = payload_estimate(noisy, 4).estimate
    result = solve_constrained(free)
    assert result.status == "Solved"
    assert noisy.unloaded is not None
    both, names = combined(noisy), noisy.loaded.columns
    factor = merged([noisy.unloaded.select(names), noisy.loaded]).stacked(both.weights)
    c = len(names)
    R, scale = factor[:c, :c], np.linalg.norm(factor[:, :c], axis=0) ** -1
    bodies = np.zeros((1, 10, c))
    places = [names.index(name) for name in PAYLOAD]
    bodies[0, range(10), places] = scale[places]
    variance = factor[c, c] ** 2 / both.degrees_of_freedom
    R, d = R * scale / np.sqrt(variance), factor[:c, c] / np.sqrt(variance)
    joint = solve_cone(ConeProgram(R, d, np.zeros((0, c)), np.zeros(0), bodies))
    payload = (joint.z * scale)[places]
    assert np.abs((payload - result.values) / free.sigma).max() < 1e-3
    assert joint.norm**2 == pytest.approx(result.chi2_rise, rel=1e-3)


@pytest.mark.parametrize("method", [1, 2, 4])
def test_every_method_takes_constraints(noisy: LongMotion, method: int) -> None:
    result = solve_constrained(payload_estimate(noisy, method).estimate)
    assert result.body.physically_consistent


def test_ur10e(recordings: Path) -> None:
    """Real recordings: masses and first moments that were established independently, from all rows."""
    folder = recordings / "ur10e"
    robot, gains = load_robot("ur10e"), (11.976, 11.976, 9.839, 10.763, 10.757, 10.680)
    loaded, unloaded = (
        read_recording(folder / f"{name}.csv.gz", robot, gains) for name in ("loaded_2.805kg", "unloaded")
    )
    every_row = replace(robot.processing, slow_speed=0.0)
    problem = payload_problem(
        robot, [loaded], [unloaded], settings=Settings(every_row, robust=False, friction_change=0.0, friction=PAPER)
    )
    results = [solve_constrained(payload_estimate(problem, method).estimate) for method in (1, 2, 3, 4)]
    assert [result.body.mass for result in results] == pytest.approx([2.793, 2.788, 2.791, 2.787], abs=4e-3)
    assert results[2].body.first_moments == pytest.approx([0.083, 0.476, 0.137], abs=1.5e-3)
    assert all(result.body.physically_consistent for result in results)
    assert all(abs(result.body.mass / result.free["M_L"] - 1.0) < 1e-3 for result in results)
