"""A tenth of the coverage benchmark: nominal 95 % intervals under white torque noise, whole processing."""

import importlib.util
from pathlib import Path

import numpy as np


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
