"""Robust standard deviations of the robot's own parameters: what they cover, what goes by them, how they last."""

from dataclasses import replace

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.estimation import Identification, identify
from dynident.estimation.equations.equations import merged
from dynident.estimation.equations.observer import Observation, Observer
from dynident.estimation.equations.reduction import reduced
from dynident.estimation.fit.blocks import block_edges, block_length, in_blocks, remembered
from dynident.estimation.fit.least_squares import weighted
from dynident.estimation.possible.prior import robot_prior, solve_constrained_prior
from dynident.estimation.possible.robot import solve_constrained_base
from dynident.estimation.signals.filtering import measurement
from dynident.model import Recording, load_robot
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points
from numpy.typing import NDArray
from scipy.signal import lfilter

BoolArray = NDArray[np.bool_]
MEMORY = 20.0  # samples


def remembering(shape: tuple[int, ...], seed: int) -> Array:
    """Stationary AR(1), autocorrelation exp(-k / MEMORY), a third as large as the noise behind Table 2."""
    phi = np.exp(-1.0 / MEMORY)
    steps = np.random.default_rng(seed).standard_normal(shape)
    steps[1:] *= np.sqrt(1.0 - phi**2)
    return np.asarray(lfilter([1.0], [1.0, -phi], steps, axis=0) * np.array(RX90_NOISE) / 3.0)


@pytest.fixture(scope="module")
def exact() -> list[Recording]:
    robot = load_robot("rx90")
    simulator = Simulator(robot)
    return [simulator.record(random_via_points(robot, 14, seed=k).motion(250.0)) for k in range(4)]


def identified(exact: list[Recording], seed: int) -> Identification:
    """By recordings with noise that remembers."""
    return identify(load_robot("rx90"), noisy(exact, seed))


def noisy(exact: list[Recording], seed: int) -> list[Recording]:
    return [replace(r, torque=r.torque + remembering(r.torque.shape, 10 * seed + k)) for k, r in enumerate(exact)]


@pytest.fixture(scope="module")
def results(exact: list[Recording]) -> list[Identification]:
    return [identified(exact, seed) for seed in range(4)]


def observed(result: Identification, recordings: list[Recording]) -> list[Observation]:
    """The equations of recordings, each held whole."""
    observer, processing = Observer(result.robot, result.base.columns), result.robot.processing
    return [observer.observe(measurement(recording, processing), processing) for recording in recordings]


def test_intervals_hold_under_noise_that_remembers(results: list[Identification]) -> None:
    """Mean over the 54 parameters and four runs; a correlation of 20 samples makes the formula's too short."""
    robot = load_robot("rx90")
    truth = results[0].base.value(robot.parameters)
    formula: list[BoolArray] = []
    robust: list[BoolArray] = []
    for result in results:
        wide = result.estimate.robust_interval95
        assert wide is not None
        for hits, interval in ((formula, result.estimate.interval95), (robust, wide)):
            hits.append((interval[:, 0] <= truth) & (truth <= interval[:, 1]))
    assert np.mean(formula) < 0.82
    assert 0.90 <= np.mean(robust) <= 0.99


def test_essential_parameters_have_their_own(exact: list[Recording], results: list[Identification]) -> None:
    """By solving again with the essential parameters alone, each block gone in turn, weights fixed."""
    result = results[0]
    whole = observed(result, noisy(exact, 0))
    equations = merged(reduced(recording) for recording in whole)
    length = block_length([remembered(whole, equations)])
    blocks = in_blocks(
        equations, whole, [block_edges(recording, length) for recording in whole], length
    ).without_each()
    estimate = result.elimination.estimate
    assert len(estimate.names) < 54
    values = [weighted(part.select(estimate.names), estimate.weights).values for part in blocks]
    changes = np.array(values) - estimate.values
    assert estimate.sigma_robust is not None
    expected = np.sqrt((len(values) - 1) / len(values) * np.sum(changes**2, axis=0))
    assert estimate.sigma_robust == pytest.approx(expected, rel=1e-9)
    assert len(values) >= 10


def test_distance_and_probability_go_by_robust_deviations(results: list[Identification]) -> None:
    """The estimate alone tells: no caller can forget it."""
    result = results[1]
    robot, base, estimate = result.robot, result.base, result.estimate
    assert estimate.robust is not None
    shifted = replace(estimate, values=estimate.values - 3.0 * estimate.sigma)
    wide = replace(shifted, robust=replace(estimate.robust, covariance=4.0 * estimate.robust.covariance))
    plain, wider = (solve_constrained_base(robot, base, e) for e in (shifted, wide))
    assert plain.chi2_rise > 1.0
    assert wider.chi2_rise == pytest.approx(plain.chi2_rise / 4.0, rel=1e-3)
    assert np.abs((wider.values - plain.values) / estimate.robust.sigma).max() < 1e-2
    assert np.allclose(plain.free.sigma, estimate.robust.sigma)
    assert plain.free.degrees_of_freedom == estimate.robust.degrees_of_freedom
    prior = solve_constrained_prior(robot, base, shifted, robot_prior(robot))
    assert prior.nearest.chi2_rise == pytest.approx(plain.chi2_rise, rel=1e-6)
