"""Signal processing: even time, no delay, known noise; rows that are used; two runs brought onto one time."""

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.estimation.signals.filtering import (
    aligned,
    decimated,
    measurement,
    noise_bandwidth,
    resampled,
    used_rows,
)
from dynident.model import Motion, Processing, Recording
from hypothesis import given, settings
from hypothesis import strategies as st


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
    whole = np.hstack([*decimated([signals], 3, factor)])
    assert whole.shape == (3, -(-size // factor))
    pieces = np.split(signals, sorted(min(cut, size) for cut in cuts), axis=1)
    assert np.allclose(np.hstack([*decimated(pieces, 3, factor)]), whole, atol=1e-14)


@pytest.mark.parametrize("factor", [1, 4, 10, 40])
def test_slow_signals_pass_and_fast_ones_do_not(factor: int) -> None:
    t = np.arange(factor * 1000) / factor  # new rate 1 Hz
    slow, fast = np.sin(2 * np.pi * 0.05 * t), np.sin(2 * np.pi * 0.6 * t)
    low, gone = np.hstack([*decimated([np.vstack([slow, fast])], 2, factor)])
    assert len(low) == 1000
    inner = slice(50, -50)
    assert np.abs(low - slow[::factor])[inner].max() < 0.03
    if factor > 1:
        assert np.abs(gone)[inner].max() < 0.03


@pytest.mark.parametrize("factor", [2, 10, 20, 100])
def test_noise_bandwidth_is_what_noise_shows(factor: int) -> None:
    """Variance left of white noise, over the density that the pass band keeps."""
    noise = np.random.default_rng(3).standard_normal((40, factor * 2000))
    left = np.hstack([*decimated([noise], 40, factor)])[:, 50:-50]
    density = np.mean(np.abs(np.fft.rfft(left, axis=1)[:, 1:500]) ** 2) / left.shape[1]
    assert left.var() / density == pytest.approx(noise_bandwidth(factor), rel=0.02)


CUT_AT_10 = Processing(cutoff=10.0)


def moved(begin: float, end: float, seconds: float = 20.0) -> Motion:
    """One joint from a speed to a speed by way of 1 rad/s, another one still but for noise."""
    t = 0.01 * np.arange(round(100 * seconds) + 1)
    qd = np.interp(t, [0.0, 0.5, seconds - 0.5, seconds], [begin, 1.0, 1.0, end])
    still = 1e-3 * np.random.default_rng(0).standard_normal(len(t))
    speeds = np.column_stack([qd, np.clip(still, -1.5e-3, 1.5e-3)])
    q, qdd = np.cumsum(speeds, axis=0) * 0.01, np.gradient(speeds, 0.01, axis=0)
    return Motion(np.asarray(t, dtype=np.float64), q, speeds, np.asarray(qdd, dtype=np.float64))


@pytest.mark.parametrize(
    ("begin", "end", "lost"),
    [(0.05, 0.05, (0, 0)), (0.5, 0.05, (30, 0)), (0.05, -0.5, (0, 30)), (1.0, 1.0, (30, 30))],
)
def test_full_motion_at_an_end(begin: float, end: float, lost: tuple[int, int]) -> None:
    """Three periods of 10 Hz are 30 samples; of a motion the other way, too."""
    motion = moved(begin, end)
    moving = used_rows(motion, CUT_AT_10)[:, 0]
    back = Motion(motion.t, -motion.q, -motion.qd, -motion.qdd)
    assert (used_rows(back, CUT_AT_10)[:, 0] == moving).all()
    inside = np.flatnonzero(moving)
    assert (inside[0], len(moving) - 1 - inside[-1]) == lost
    assert moving[inside[0] : inside[-1] + 1].all()


def test_a_jog_to_the_start_gives_no_rows() -> None:
    """Fast as it is: half a second of motion, a pause of one second, then the recording proper."""
    motion = moved(0.05, 0.05)
    speeds = np.array(motion.qd)
    speeds[:50], speeds[50:150] = 0.5, 0.0
    rows = used_rows(Motion(motion.t, motion.q, speeds, motion.qdd), Processing())
    assert not rows[:150].any()
    assert rows[150:, 0].all()


def test_the_larger_bound_of_share_and_speed_counts() -> None:
    motion = moved(1.0, 1.0)
    fastest = np.abs(motion.qd).max(axis=0)
    for share, speed in (
        (0.1, 0.0),
        (0.0, 0.05),
        (0.1, 0.05),
        (0.001, tuple(0.02 * (j + 1) for j in range(motion.n))),
    ):
        rows = used_rows(motion, Processing(slow_fraction=share, slow_speed=speed))
        least = np.maximum(share * fastest, speed)
        assert (np.abs(motion.qd)[rows] >= np.broadcast_to(least, rows.shape)[rows]).all()
        assert not rows[np.abs(motion.qd) < least].any()
        assert rows[(np.abs(motion.qd) >= least) & used_rows(motion, Processing())].all()


AT_100 = Processing(rate=100.0, cutoff=20.0, decimate=4, slow_fraction=0.05)


@pytest.mark.parametrize(
    ("recorded", "grid", "factor"),
    [(1000.0, 1000.0, 40), (500.0, 500.0, 20), (190.0, 200.0, 8), (125.0, 100.0, 4), (100.0, 100.0, 4)],
)
def test_a_fast_log_is_resampled_to_a_multiple(recorded: float, grid: float, factor: int) -> None:
    t = np.arange(int(6.0 * recorded)) / recorded
    q = np.sin(2.0 * np.pi * 0.5 * t)[:, None]
    rate = measurement(Recording(t, q, q), AT_100).motion.rate
    assert rate == pytest.approx(grid)
    assert AT_100.thinning(rate) == factor


@pytest.mark.parametrize(
    ("lag", "samples"),
    [
        *((lag, 3_000) for lag in (0.0, 0.0002, 0.0037, 0.005, -0.0021, 0.1349, -1.2345)),
        *((0.0037, samples) for samples in (40_001, 250_000)),
    ],
)
def test_a_lag_between_samples_is_found(lag: float, samples: int) -> None:
    """Both clocks show the same, the motion itself is late: no sample of one run is one of the other.

    To 1/1000 of a step without noise, to 1/50 with noise of 1 mrad; of long recordings some stretches are compared.
    """
    draw, t, step = np.random.default_rng(3), np.asarray(0.01 * np.arange(samples), dtype=np.float64), 0.01
    w, phase = 2 * np.pi * draw.uniform(0.05, 0.6, (4, 3)), draw.uniform(0.0, 6.0, (4, 3))

    def run(delay: float, noise: float) -> Recording:
        exact = 0.3 * np.sin(w * (t - delay)[:, None, None] + phase).sum(axis=1)
        q = np.asarray(exact + noise * draw.standard_normal(exact.shape), dtype=np.float64)
        return Recording(t, q, q)

    for noise, most in ((0.0, step / 1000), (1e-3, step / 50)):
        pair = aligned(run(0.0, noise), run(lag, noise), rate=100.0, most=0.02)
        assert pair.lag == pytest.approx(lag, abs=most)
        assert np.array_equal(pair.unloaded.t, pair.loaded.t)
        ends = max(0.0, pair.lag), t[-1] + min(0.0, pair.lag)  # of what both have recorded
        assert ends[0] <= pair.loaded.t[0] < ends[0] + step
        assert ends[1] - step < pair.loaded.t[-1] <= ends[1]


def test_joints_at_rest_leave_the_lag_of_a_pair_alone() -> None:
    t, rest, lag = np.arange(0.0, 20.0, 0.01), np.array([0.1, -0.7, 1.3, 0.4, -2.1]), 3.21

    def recording(begun: float, source: str) -> Recording:
        moving = np.sin(t - begun) + 0.5 * np.sin(2.3 * (t - begun) + 1.0)
        q = np.column_stack([moving, np.tile(rest, (len(t), 1))])
        return Recording(t, q, 0.0 * q, source=source)

    pair = aligned(recording(0.0, "unloaded"), recording(lag, "loaded"), 100.0)
    assert pair.lag == pytest.approx(lag, abs=1e-3)
