"""Signal processing: even time, no delay, known noise."""

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.estimation.signals.decimation import Decimator, decimated, noise_bandwidth
from dynident.estimation.signals.filtering import (
    lowpass,
    measurement,
    on_grid,
    resampled,
    slopes,
)
from dynident.model import Processing, Recording
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator
from scipy.signal import butter, sosfiltfilt


def sine(t: np.ndarray, frequency: float) -> np.ndarray:
    return np.sin(2 * np.pi * frequency * t)[:, None] * np.ones((1, 2))


def test_even_time_is_kept_and_uneven_time_resampled() -> None:
    t = np.arange(200) / 100.0
    even = Recording(t, sine(t, 1.0), sine(t, 1.0))
    assert np.array_equal(resampled(even, None).q, even.q)
    uneven_t = np.sort(np.random.default_rng(0).uniform(0.0, 2.0, 400))
    uneven = Recording(uneven_t, sine(uneven_t, 1.0), sine(uneven_t, 1.0))
    even_again = resampled(uneven, 100.0)
    assert np.allclose(np.diff(even_again.t), 0.01)
    assert np.abs(even_again.q - sine(even_again.t, 1.0)).max() < 5e-3
    assert even_again.t[-1] <= uneven_t[-1]


def test_filter_has_no_delay_and_differences_give_speed_and_acceleration() -> None:
    t = np.arange(2000) / 500.0
    recording = Recording(t, sine(t, 1.0), np.zeros((2000, 2)))
    motion = measurement(recording, Processing(cutoff=20.0)).motion
    inner = slice(200, -200)
    omega = 2 * np.pi
    assert np.abs(motion.q - sine(t, 1.0))[inner].max() < 1e-4
    assert np.abs(motion.qd - omega * np.cos(omega * t)[:, None])[inner].max() < 1e-3
    assert np.abs(motion.qdd + omega**2 * sine(t, 1.0))[inner].max() < 2e-2


def test_the_filter_is_scipys() -> None:
    signals = np.cumsum(np.random.default_rng(0).standard_normal((3000, 4)), axis=0)
    theirs = sosfiltfilt(butter(4, 0.08, output="sos"), signals, axis=0)
    assert np.abs(lowpass(signals, 0.01, 4.0, "log") - theirs).max() < 1e-12 * np.abs(theirs).max()
    assert np.array_equal(slopes(signals, 0.01), np.gradient(signals, 0.01, axis=0))


@pytest.mark.parametrize("count", [200, 4000])
def test_interpolation_is_scipys(count: int) -> None:
    draw = np.random.default_rng(0)
    uneven = np.sort(draw.uniform(0.0, 8.0, 1000))
    recording = Recording(uneven, draw.standard_normal((1000, 3)), draw.standard_normal((1000, 3)))
    t = np.linspace(uneven[0], uneven[-1], count)
    for kind in ("q", "torque"):
        theirs = PchipInterpolator(uneven, getattr(recording, kind), axis=0)(t)
        assert getattr(on_grid(recording, t), kind) == pytest.approx(theirs, rel=1e-9, abs=1e-12)


def test_recorded_speeds_are_used() -> None:
    t = np.arange(500) / 100.0
    recording = Recording(t, sine(t, 0.5), np.zeros((500, 2)), qd=np.full((500, 2), 3.0))
    assert np.allclose(measurement(recording, Processing(cutoff=10.0)).motion.qd, 3.0)


def test_cutoff_above_nyquist_and_short_recordings_are_refused() -> None:
    t = np.arange(100) / 100.0
    with pytest.raises(InputError, match="lower --cutoff"):
        measurement(Recording(t, sine(t, 1.0), sine(t, 1.0)), Processing(cutoff=50.0))
    short = Recording(t[:20], sine(t[:20], 1.0), sine(t[:20], 1.0))
    with pytest.raises(InputError, match="too few to filter"):
        measurement(short, Processing(cutoff=10.0))


@given(st.integers(1, 40), st.integers(1, 3000), st.lists(st.integers(0, 400), max_size=8))
@settings(max_examples=40, deadline=None)
def test_blocks_give_what_the_whole_gives(factor: int, size: int, cuts: list[int]) -> None:
    signals = np.random.default_rng(size).standard_normal((3, size))
    whole = decimated(signals, factor)
    assert whole.shape == (3, -(-size // factor))
    decimator = Decimator(3, factor)
    parts = [decimator.push(part) for part in np.split(signals, sorted(min(cut, size) for cut in cuts), axis=1)]
    parts.append(decimator.finish() if factor > 1 else np.empty((3, 0)))
    assert np.allclose(np.concatenate(parts, axis=1), whole, atol=1e-14)


@pytest.mark.parametrize("factor", [1, 4, 10, 40])
def test_slow_signals_pass_and_fast_ones_do_not(factor: int) -> None:
    t = np.arange(factor * 1000) / factor  # new rate 1 Hz
    slow, fast = np.sin(2 * np.pi * 0.05 * t), np.sin(2 * np.pi * 0.6 * t)
    low, gone = decimated(np.vstack([slow, fast]), factor)
    assert len(low) == 1000
    inner = slice(50, -50)
    assert np.abs(low - slow[::factor])[inner].max() < 0.03
    if factor > 1:
        assert np.abs(gone)[inner].max() < 0.03


@pytest.mark.parametrize("factor", [2, 10, 20, 100])
def test_noise_bandwidth_is_what_noise_shows(factor: int) -> None:
    """Variance left of white noise, over the density that the pass band keeps."""
    noise = np.random.default_rng(3).standard_normal((40, factor * 2000))
    left = decimated(noise, factor)[:, 50:-50]
    density = np.mean(np.abs(np.fft.rfft(left, axis=1)[:, 1:500]) ** 2) / left.shape[1]
    assert left.var() / density == pytest.approx(noise_bandwidth(factor), rel=0.02)


def test_no_decimation_keeps_noise_white() -> None:
    assert noise_bandwidth(1) == 1.0


@pytest.mark.parametrize(("duration", "words"), [(0.4, "too short for it; record longer"), (4.0, "raise --cutoff")])
def test_a_cutoff_is_not_blamed_for_a_short_log(duration: float, words: str) -> None:
    t = np.arange(0.0, duration, 0.004)
    q = np.sin(2.0 * np.pi * 9.0 * t)[:, None]
    with pytest.raises(InputError, match=words):
        measurement(Recording(t, q, q, source="log"), Processing(cutoff=10.0))
