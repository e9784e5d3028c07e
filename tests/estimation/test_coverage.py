"""A tenth of the coverage benchmark: nominal 95 % intervals under white torque noise, whole processing."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from dynident.benchmarks.monte_carlo import Tally, difference
from dynident.benchmarks.repeated_noise import Experiment


@pytest.mark.long
def test_intervals_of_every_method_hold_the_truth_in_93_to_97_percent() -> None:
    path = Path(__file__).parents[2] / "benchmarks" / "coverage.py"
    spec = importlib.util.spec_from_file_location("coverage_benchmark", path)
    assert spec is not None
    assert spec.loader is not None
    benchmark = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(benchmark)
    (share,) = benchmark.coverage(range(40), trajectories=4)
    assert share.shape == (4, 10)
    pooled = share.mean(axis=1)
    assert np.all((pooled >= 0.93) & (pooled <= 0.97)), pooled


@pytest.mark.long
def test_the_monte_carlo_benchmark_does_what_the_library_does() -> None:
    """Gram matrices give the library's values and jackknife; under slow noise the formula is far too short."""
    experiment = Experiment(2)
    values, sigma = difference(experiment, 20.0)
    assert values < 1e-8
    assert sigma < 1e-8
    tally = Tally(experiment)
    for seed in range(10):
        tally.add(*experiment.run(200.0, seed))
    share = {kind: np.mean(tally.payload["disc", 3, kind]) for kind in ("formula", "recommended")}
    assert share["formula"] < 0.75
    assert share["recommended"] > 0.88
