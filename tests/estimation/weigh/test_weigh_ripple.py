"""Ripple that comes with the payload."""

from dataclasses import replace

import numpy as np
import pytest
from dynident.tests.estimation.weigh.recordings import LOAD, Pair, Record, weighed
from dynident.trajectories import Simulator


def test_ripple_that_comes_with_the_payload_is_found(record: Record, simulator: Simulator) -> None:
    """Its waves; the mass, and the interval's width, as if it were not there or wide enough."""
    pair = record((2, 3, 5, 6))
    q, places = pair.loaded.q, [1, 2, 4, 5]
    size = 0.05 * np.sqrt(np.mean(pair.loaded.torque**2, axis=0))
    wave = np.zeros_like(q)
    wave[:, places] = (size * np.sin(36.0 * q + 0.7))[:, places]
    plain = weighed(simulator.robot, pair)
    rippled = weighed(simulator.robot, Pair(pair.bare, replace(pair.loaded, torque=pair.loaded.torque + wave)))
    found = rippled.problem.runs[0].ripple
    assert {one.joint for one in found} >= {2, 3}
    clear = [one for one in found if one.joint in (2, 3)]
    assert all(one.waves == pytest.approx(36.0, abs=1.5) for one in clear)
    assert all(one.amplitude == pytest.approx(size[one.joint - 1], rel=0.3) for one in clear)
    assert rippled.mass == pytest.approx(plain.mass, abs=plain.spread.mass)
    low, high = rippled.mass_interval
    assert low < LOAD.mass < high


def test_white_noise_has_no_ripple(record: Record, simulator: Simulator) -> None:
    waves = [len(weighed(simulator.robot, record((2, 3, 5, 6), seed)).problem.runs[0].ripple) for seed in range(4)]
    assert sum(waves) <= 2  # of 16 joints, each with one chance in twenty
