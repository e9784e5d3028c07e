"""Recursive filters against scipy's."""

import numpy as np
import pytest
from dynident.common.recursion import Section, butterworth, filtered
from scipy.signal import butter, lfilter, sosfilt, sosfilt_zi

SIGNALS = np.random.default_rng(0).standard_normal((400, 3)).cumsum(axis=0)


@pytest.mark.parametrize("cutoff", [0.01, 0.1, 0.5, 0.95])
@pytest.mark.parametrize("order", [2, 4, 6])
def test_scipy_filters_alike(order: int, cutoff: float) -> None:
    sections = butterworth(order, cutoff)
    sos = butter(order, cutoff, output="sos")
    settled = sosfilt_zi(sos)[:, :, None] * SIGNALS[0]
    theirs, _ = sosfilt(sos, SIGNALS, axis=0, zi=settled)
    assert np.abs(filtered(sections, SIGNALS) - theirs).max() < 1e-11 * np.abs(theirs).max()


def test_a_first_order_filter_is_a_section_too() -> None:
    ours = Section(1.0, 0.0, 0.0, -0.9, 0.0).filtered(SIGNALS, np.zeros((2, 3)))
    assert ours == pytest.approx(lfilter([1.0], [1.0, -0.9], SIGNALS, axis=0), rel=1e-12, abs=1e-12)
