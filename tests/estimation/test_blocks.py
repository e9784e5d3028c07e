"""Blocks of time: how long, where cut, and what is left without each."""

from dataclasses import replace

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.estimation.equations.equations import merged
from dynident.estimation.equations.observer import Observation, Observer
from dynident.estimation.equations.reduction import reduced
from dynident.estimation.fit.blocks import autocorrelation_time, block_edges
from dynident.estimation.fit.covariance import jackknife
from dynident.estimation.fit.least_squares import weighted
from dynident.estimation.payload.problem import PairedMeasurement
from dynident.model import base_parameters
from dynident.tests.estimation.wandering import SETTINGS, block_length, cut, same_equations
from dynident.tests.estimation.wandering import pair as pair
from dynident.tests.estimation.wandering import simulator as simulator
from dynident.trajectories import Simulator


def remembering(size: int, memory: float, seed: int) -> Array:
    from scipy.signal import lfilter

    phi = np.exp(-1.0 / memory)
    return np.asarray(lfilter([1.0], [1.0, -phi], np.random.default_rng(seed).standard_normal(size)))


def times(size: int) -> Array:
    return np.linspace(0.0, 0.01 * (size - 1), size)


@pytest.mark.parametrize(("memory", "expected"), [(0.05, 0.5), (4.0, 4.0), (20.0, 20.0)])
def test_autocorrelation_time(memory: float, expected: float) -> None:
    """1/2 + sum of exp(-k / T), which is T but for 1 / (12 T)."""
    t = times(50_000)
    series = [(t, remembering(50_000, memory, seed)) for seed in range(2)]
    assert autocorrelation_time(series, 0.01) == pytest.approx(0.01 * expected, rel=0.1)


def test_rows_left_out_do_not_shorten_the_memory() -> None:
    t = times(100_000)
    e = remembering(100_000, 10.0, 0)
    there = np.random.default_rng(1).uniform(size=t.size) < 0.6
    assert autocorrelation_time([(t[there], e[there])], 0.01) == pytest.approx(0.1, rel=0.1)


def test_residuals_without_noise_have_no_memory() -> None:
    assert autocorrelation_time([(np.arange(10.0), np.zeros(10)), (np.empty(0), np.empty(0))], 1.0) == 0.5


@pytest.fixture(scope="module")
def observation(simulator: Simulator, pair: PairedMeasurement) -> Observation:
    return Observer(simulator.robot, base_parameters(simulator.robot).columns).observe(pair.unloaded, SETTINGS)


def test_blocks_are_equal_and_long_enough(observation: Observation) -> None:
    t = np.concatenate(observation.t)
    edges = block_edges(observation, 3.0)
    inner = np.diff(np.concatenate([[t.min()], edges[1:-1], [t.max()]]))
    assert np.ptp(inner) < 1e-9
    assert 3.0 <= inner[0] < 3.0 * (1.0 + 1.0 / (len(inner) - 1))
    assert (edges[0], edges[-1]) == (-np.inf, np.inf)
    assert len(block_edges(observation, 1000.0)) == 2


def test_block_length(observation: Observation) -> None:
    """White noise: the shortest; noise that remembers: five times its memory; many recordings: at most 100."""
    assert block_length([[observation]]) == 1.0
    slow = tuple(Y + 10.0 * remembering(len(Y), 10.0, j) for j, Y in enumerate(observation.Y))
    remembered = replace(observation, Y=slow)
    errors = remembered.errors(weighted(reduced(remembered)).values)
    memories = [autocorrelation_time([(t, e)], 0.04) for t, e in zip(remembered.t, errors, strict=True)]
    assert max(memories) > 0.2
    assert block_length([[observation], [remembered]]) == pytest.approx(5.0 * max(memories), rel=1e-6)
    duration = np.ptp(np.concatenate(observation.t))
    assert block_length([[observation] * 10]) == pytest.approx(10.0 * duration / 100.0)


def without(recording: Observation, start: float, stop: float) -> Observation:
    """All rows but those of a block."""
    stays = [(t < start) | (t >= stop) for t in recording.t]
    W, Y, t = (
        tuple(array[keep] for array, keep in zip(arrays, stays, strict=True))
        for arrays in (recording.W, recording.Y, recording.t)
    )
    return Observation(recording.columns, W, Y, t, recording.bandwidth)


def test_leaving_a_block_out_is_reducing_without_it(observation: Observation) -> None:
    edges = block_edges(observation, 2.0)
    parts = list(cut(observation, edges).without_each())
    assert len(parts) == len(edges) - 1 >= 10
    for k, part in enumerate(parts):
        direct = reduced(without(observation, edges[k], edges[k + 1]))
        same_equations(part, direct)
        part_fit, direct_fit = weighted(part), weighted(direct)
        assert (np.abs(part_fit.values - direct_fit.values) < 1e-6 * part_fit.sigma).all()


def test_few_equations_keep_all_they_say(observation: Observation) -> None:
    """Fewer rows than columns, some columns zero or dependent: nothing of W'W and W'Y is lost."""
    edges = block_edges(observation, 0.2)
    blocks = cut(observation, edges).parts()
    assert min(min(block.rows) for block in blocks) < 10
    same_equations(merged(blocks), reduced(observation))


def test_jackknife_of_a_mean_is_the_textbook_one() -> None:
    """s^2 / B, exactly; independent groups add, with the degrees of freedom of the smaller."""
    draws = np.random.default_rng(0).standard_normal((12, 3))
    parts = [np.delete(draws, k, axis=0) for k in range(12)]

    def mean(data: Array) -> Array:
        return np.asarray(data.mean(axis=0))

    once = jackknife([map(mean, parts)], mean(draws), 1.0)
    assert np.allclose(once.covariance, np.cov(draws.T) / 12.0, rtol=1e-12, atol=1e-15)
    assert (once.blocks, once.degrees_of_freedom, once.warning) == (12, 11, "")
    assert once.quantile95 == pytest.approx(2.20099, abs=1e-5)
    twice = jackknife([map(mean, parts), map(mean, parts[:9])], mean(draws), 1.0)
    assert (twice.blocks, twice.degrees_of_freedom) == (21, 8)
    changes = np.array([mean(part) for part in parts[:9]]) - mean(draws)
    assert np.allclose(twice.covariance, once.covariance + 8.0 / 9.0 * changes.T @ changes)
    assert "9 blocks" in twice.warning
