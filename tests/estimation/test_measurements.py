"""A recording is filtered once, however often it is asked for, and forgotten with it."""

import gc
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from dynident.estimation.signals import filtering
from dynident.estimation.signals.filtering import measured, measurement
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
        return measured(recording, processing)

    monkeypatch.setattr("dynident.estimation.signals.filtering.measured", counted)
    first, second = (measurement(recording, SETTINGS) for recording in recordings)
    assert measurement(recordings[0], SETTINGS) is first
    assert measurement(recordings[1], replace(SETTINGS, decimate=2)) is second
    assert filtered == ["0.0", "0.7"]
    assert np.array_equal(first.motion.qdd, measured(recordings[0], SETTINGS).motion.qdd)


def test_other_settings_filter_anew(recordings: list[Recording]) -> None:
    first = measurement(recordings[0], SETTINGS)
    for settings in (replace(SETTINGS, cutoff=6.0), replace(SETTINGS, rate=80.0)):
        assert measurement(recordings[0], settings) is not first


def test_what_is_made_of_a_recording_goes_with_it(recordings: list[Recording]) -> None:
    gc.collect()
    before = len(filtering._made)
    for recording in recordings:
        measurement(recording, SETTINGS)
    assert len(filtering._made) == before + 2
    del recording
    recordings.clear()
    gc.collect()
    assert len(filtering._made) <= before
