"""Monotone cubics against scipy's."""

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.estimation.signals.filtering import MonotoneCubic
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator


@pytest.mark.parametrize("count", [2, 3, 4, 300])
@pytest.mark.parametrize("seed", range(3))
def test_scipy_interpolates_alike(count: int, seed: int) -> None:
    draw = np.random.default_rng(seed)
    t = np.cumsum(draw.uniform(0.001, 0.02, count)) + 5.0
    values = draw.standard_normal((count, 4))
    values[: count // 2, 1] = 0.3  # level stretches
    values[:, 2] = np.sort(values[:, 2])
    times = np.concatenate([t, draw.uniform(t[0], t[-1], 500), [t[0] - 0.01, t[-1] + 0.01]])
    theirs = PchipInterpolator(t, values, axis=0, extrapolate=False)(times)
    ours = MonotoneCubic(t, values)(times)
    assert np.isnan(ours).any()
    assert ours == pytest.approx(theirs, rel=1e-11, abs=1e-12, nan_ok=True)


@given(st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=20))
def test_it_never_overshoots(values: list[float]) -> None:
    t = np.arange(len(values), dtype=float)
    column = np.array(values)[:, None]
    k = np.repeat(np.arange(len(values) - 1), 20)
    times: Array = k.astype(float) + np.tile(np.linspace(0.0, 0.99, 20), len(values) - 1)
    inside = MonotoneCubic(t, column)(times)[:, 0]
    ends = np.sort(np.stack([column[k, 0], column[k + 1, 0]]), axis=0)
    slack = 1e-9 * (1.0 + np.abs(ends).max())
    assert (inside >= ends[0] - slack).all()
    assert (inside <= ends[1] + slack).all()
