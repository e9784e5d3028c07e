"""The tilt of a merged passport weighs its parts by what they show."""

import numpy as np
import pytest
from dynident.apps.fleet.merging import _pooled
from dynident.estimation.diagnosis.nuisances import Tilt

EFFECTS = (np.arange(20.0).reshape(10, 2), np.ones((10, 2)))
SHARP = Tilt(np.array([0.01, -0.02]), np.diag([1e-6, 4e-6]), EFFECTS)


def test_equal_parts_keep_the_tilt_and_halve_its_variance() -> None:
    merged = _pooled([SHARP, SHARP])
    assert merged is not None
    assert merged.values == pytest.approx(SHARP.values)
    assert merged.covariance == pytest.approx(0.5 * SHARP.covariance)
    assert merged.effects[0] == pytest.approx(SHARP.effects[0])


def test_a_part_that_shows_little_hardly_counts() -> None:
    vague = Tilt(np.array([0.3, 0.3]), np.diag([1.0, 1.0]), (np.zeros((10, 2)), np.zeros((10, 2))))
    merged = _pooled([SHARP, vague])
    assert merged is not None
    assert merged.values == pytest.approx(SHARP.values, abs=1e-5)
    assert merged.effects[0] == pytest.approx(SHARP.effects[0], rel=1e-4)
    # The least variance that an unbiased mean can have.
    least = np.linalg.inv(np.linalg.inv(SHARP.covariance) + np.linalg.inv(vague.covariance))
    assert merged.covariance == pytest.approx(least)


def test_a_part_without_a_tilt_leaves_none() -> None:
    assert _pooled([SHARP, None]) is None
    assert _pooled([]) is None
