"""A recording is filtered once and a pair aligned once, however often they are asked for."""

from collections.abc import Callable

import numpy as np
import pytest
from dynident.estimation.signals import Measurements, aligned, measurement
from dynident.model import Motion, Processing, Recording

SETTINGS = Processing(rate=100.0, cutoff=8.0)


@pytest.fixture
def recordings(wander: Callable[..., Motion]) -> list[Recording]:
    motion = wander(6, 0)
    return [Recording(motion.t + delay, motion.q, motion.q, source=f"{delay}") for delay in (0.0, 0.7)]


def test_each_recording_is_filtered_once(recordings: list[Recording], monkeypatch: pytest.MonkeyPatch) -> None:
    filtered: list[str] = []

    def counted(recording: Recording, processing: Processing) -> object:
        filtered.append(recording.source)
        return measurement(recording, processing)

    monkeypatch.setattr("dynident.estimation.signals.measurements.measurement", counted)
    measurements = Measurements(SETTINGS)
    first, second = (measurements.of(recording) for recording in recordings)
    assert measurements.of(recordings[0]) is first
    assert measurements.of(recordings[1]) is second
    assert filtered == ["0.0", "0.7"]
    assert np.array_equal(first.motion.qdd, measurement(recordings[0], SETTINGS).motion.qdd)


def test_each_pair_is_aligned_once(recordings: list[Recording]) -> None:
    measurements = Measurements(SETTINGS)
    pair = measurements.pair(recordings[0], recordings[1])
    again = measurements.pair(recordings[0], recordings[1])
    assert again is pair
    assert measurements.of(pair.loaded) is measurements.of(again.loaded)
    assert pair.lag == aligned(recordings[0], recordings[1], 100.0, SETTINGS.max_mismatch).lag
    assert measurements.pair(recordings[1], recordings[0]).lag == pytest.approx(-pair.lag, abs=1e-6)
