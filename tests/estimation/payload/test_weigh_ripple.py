"""Ripple that comes with the payload."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from dynident.apps.report.sections.estimates import data_notes
from dynident.common.arrays import Array
from dynident.estimation.payload import ripple
from dynident.estimation.payload.ripple import RIPPLE_CHANCE
from dynident.estimation.payload.weighing import difference_weighing
from dynident.tests.estimation.payload.recordings import LOAD, Pair, Record, short, weighed
from dynident.trajectories import Simulator


def shaken(pair: Pair) -> Pair:
    """With ripple of 5 % of each moving joint's torque, 36 waves a turn, beside the payload."""
    q, places = pair.loaded.q, [1, 2, 4, 5]
    wave = np.zeros_like(q)
    wave[:, places] = (sizes(pair) * np.sin(36.0 * q + 0.7))[:, places]
    return Pair(pair.bare, replace(pair.loaded, torque=pair.loaded.torque + wave))


def sizes(pair: Pair) -> Array:
    return np.asarray(0.05 * np.sqrt(np.mean(pair.loaded.torque**2, axis=0)))


@pytest.mark.long
def test_ripple_that_comes_with_the_payload_is_found(record: Record, simulator: Simulator) -> None:
    """A ripple's waves are found; mass and interval's width are as if it were not there, or wide enough."""
    pair = record((2, 3, 5, 6))
    size = sizes(pair)
    plain, rippled = weighed(simulator.robot, pair), weighed(simulator.robot, shaken(pair))
    ripples = rippled.short.runs[0].ripple
    assert {ripple.joint for ripple in ripples} >= {2, 3}
    clear = [ripple for ripple in ripples if ripple.joint in (2, 3)]
    assert all(ripple.waves == pytest.approx(36.0, abs=1.5) for ripple in clear)
    assert all(ripple.amplitude == pytest.approx(size[ripple.joint - 1], rel=0.3) for ripple in clear)
    assert rippled.mass == pytest.approx(plain.mass, abs=plain.spread.mass)
    low, high = rippled.mass_interval
    assert low < LOAD.mass < high


@pytest.mark.long
def test_white_noise_has_no_ripple(record: Record, simulator: Simulator) -> None:
    waves = [len(weighed(simulator.robot, record((2, 3, 5, 6), seed)).short.runs[0].ripple) for seed in range(4)]
    assert sum(waves) <= 2  # of 16 joints, each with one chance in twenty


@pytest.mark.long
def test_in_how_many_parts_it_is_looked_for_does_not_matter(
    record: Record, simulator: Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    pair, ripples = shaken(record((2, 3, 5, 6))), []
    for at_once in (10**9, 60_000, 1):  # all, a few, one
        monkeypatch.setattr(ripple, "_AT_ONCE", at_once)
        ripples.append(short(difference_weighing(simulator.robot, [pair.loaded], [pair.bare])).runs[0].ripple)
    assert len(ripples[0]) >= 2
    for again in ripples[1:]:
        assert [(w.joint, w.waves) for w in again] == [(w.joint, w.waves) for w in ripples[0]]
        assert [wave.amplitude for wave in again] == pytest.approx(
            [wave.amplitude for wave in ripples[0]], rel=1e-12
        )


def test_a_long_search_takes_little_memory() -> None:
    """A few numbers a sample besides the sample's own; all waves at once would be 235 three times."""
    samples = 100_000
    t = np.asarray(1e-3 * np.arange(samples), dtype=np.float64)
    torque = np.random.default_rng(0).standard_normal(samples)
    search = ripple._Search(np.sin(t), np.ones(samples, dtype=bool), 1, 1e-3)
    tracemalloc.start()
    search.waves(np.column_stack([np.sin(t), np.cos(t)]), torque, t)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 60 * 8 * samples


def test_that_it_may_be_chance_is_told(record: Record, simulator: Simulator) -> None:
    answer = weighed(simulator.robot, shaken(record((2, 3, 5, 6))))
    (note,) = (line for line in data_notes(answer.result) if line.startswith("Ripple"))
    assert "may be chance" in note
    assert f"probability of {100 * RIPPLE_CHANCE:.0f} %" in note
    assert f"in one or more with {100 * (1 - (1 - RIPPLE_CHANCE) ** 4):.0f} %" in note  # four joints
