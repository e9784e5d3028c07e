"""A tenth of the coverage benchmark: nominal 95 % intervals of all methods, the whole processing."""

from collections.abc import Mapping, Sequence

import numpy as np
import pytest
from dynident.benchmarks.coverage import Stated, cases, coverage


def disc(noise: str, trajectories: int, runs: int) -> dict[str, list[Stated]]:
    return coverage(cases(trajectories)[noise]._replace(arms=("disc",)), range(runs))


def pooled(rows: Mapping[str, Sequence[Stated]], kind: str) -> list[float]:
    """Coverage of the ten by methods 1 to 4."""
    return [float(np.mean([stated.held for stated in rows[f"disc, method {m}, {kind}"]])) for m in (1, 2, 3, 4)]


@pytest.mark.long
def test_intervals_hold_the_truth_under_white_noise() -> None:
    rows = disc("white", 4, 80)
    for kind in ("formula", "jackknife"):
        assert np.all(np.abs(np.array(pooled(rows, kind)) - 0.95) <= 0.02), pooled(rows, kind)
    assert min(pooled(rows, "recommended")) > 0.95


@pytest.mark.long
def test_intervals_hold_under_noise_that_remembers() -> None:
    """AR(1) torque noise, correlation time 20 samples at 250 Hz."""
    rows = disc("ar", 4, 12)
    assert max(pooled(rows, "formula")) < 0.82
    assert min(pooled(rows, "jackknife")) >= 0.90
    assert max(pooled(rows, "jackknife")) <= 0.98


@pytest.mark.long
def test_intervals_hold_where_decimated_noise_remembers() -> None:
    """The formula is far too short there."""
    rows = disc("late", 2, 10)
    assert max(pooled(rows, "formula")) < 0.75
    assert min(pooled(rows, "recommended")) > 0.88
