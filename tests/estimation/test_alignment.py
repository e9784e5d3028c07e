"""Two runs of one trajectory are brought onto one time; two trajectories are refused."""

from collections.abc import Callable

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.estimation.signals.alignment import aligned
from dynident.model import Motion, Recording


def recording(motion: Motion, name: str, delay: float = 0.0, seed: int | None = None) -> Recording:
    """A run that starts ``delay`` later on its own clock; with a seed, at uneven times."""
    t = motion.t
    if seed is not None:
        t = np.sort(np.random.default_rng(seed).uniform(motion.t[0], motion.t[-1], len(motion.t)))
    q = np.column_stack([np.interp(t, motion.t, q) for q in motion.q.T])
    return Recording(t + delay, q, q, source=name)


@pytest.mark.parametrize("delay", [0.0, 0.0137, 1.18, -0.4213])
@pytest.mark.parametrize("uneven", [False, True])
def test_lag_is_found_to_a_fraction_of_a_sample(wander: Callable[..., Motion], delay: float, uneven: bool) -> None:
    motion = wander(6, 0)
    a = recording(motion, "a", 0.0, 1 if uneven else None)
    b = recording(motion, "b", delay, 2 if uneven else None)
    pair = aligned(a, b, 100.0, 0.02)
    assert pair.lag == pytest.approx(delay, abs=2e-4)
    assert pair.max_mismatch < 5e-3
    assert np.array_equal(pair.unloaded.t, pair.loaded.t)


def test_of_long_recordings_some_samples_are_compared(
    wander: Callable[..., Motion], monkeypatch: pytest.MonkeyPatch
) -> None:
    motion = wander(6, 4, points=40, rate=125.0)
    pair = recording(motion, "a", 0.0, 1), recording(motion, "b", 1.3, 2)
    whole = aligned(*pair, 100.0, 0.02)
    monkeypatch.setattr("dynident.estimation.signals.alignment._MOST", 500)
    thin = aligned(*pair, 100.0, 0.02)
    assert thin.lag != whole.lag
    assert thin.lag == pytest.approx(1.3, abs=5e-4)
    assert thin.rms_mismatch < 1.02 * whole.rms_mismatch


def test_offset_between_the_runs_is_reported(wander: Callable[..., Motion]) -> None:
    motion = wander(6, 0)
    b = Recording(motion.t, motion.q + 1e-3, motion.q)
    pair = aligned(recording(motion, "a"), b, 100.0, 0.02)
    assert pair.rms_mismatch == pytest.approx(1e-3, rel=0.05)


def test_different_trajectories_are_refused_and_the_limit_can_be_moved(wander: Callable[..., Motion]) -> None:
    a, b = recording(wander(6, 0), "first"), recording(wander(6, 1), "second")
    with pytest.raises(InputError, match=r"first and second are not the same trajectory.*max-mismatch"):
        aligned(a, b, 100.0, 0.02)
    slightly = Recording(a.t, a.q * 1.01, a.torque, source="third")
    with pytest.raises(InputError, match=r"q\d differs"):
        aligned(a, slightly, 100.0, 1e-3)
    mismatch = aligned(a, slightly, 100.0, 0.05).rms_mismatch
    assert mismatch > 1e-3
    with pytest.raises(InputError, match=r"q\d differs"):
        aligned(a, slightly, 100.0, 0.99 * mismatch)
    assert aligned(a, slightly, 100.0, 1.01 * mismatch).rms_mismatch == mismatch


@pytest.mark.parametrize(
    ("lag", "samples"),
    [
        *((lag, 3_000) for lag in (0.0, 0.0002, 0.0037, 0.005, -0.0021, 0.1349, -1.2345)),
        *((0.0037, samples) for samples in (40_001, 90_000, 250_000)),
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
        pair = aligned(run(0.0, noise), run(lag, noise), rate=100.0, max_mismatch=0.02)
        assert pair.lag == pytest.approx(lag, abs=most)
