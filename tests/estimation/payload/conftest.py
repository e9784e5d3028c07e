"""A simulated RX90 and what it records."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.estimation import ShortMotion
from dynident.estimation.payload.weighing import difference_weighing
from dynident.model import InertialParameters, load_robot
from dynident.tests.estimation.payload.recordings import LOAD, NOISE, Pair, Record, near
from dynident.trajectories import Simulator


@pytest.fixture(scope="session")
def simulator() -> Simulator:
    return Simulator(load_robot("rx90"))


@pytest.fixture(scope="session")
def record(simulator: Simulator) -> Record:
    """``record(joints, seed, noise, load)``: a pair of recordings; held joints flicker by their encoders."""

    def make(joints: Sequence[int], seed: int = 0, noise: Array = NOISE, load: InertialParameters = LOAD) -> Pair:
        motion = near(joints).motion(250.0)
        draw = np.random.default_rng([seed, 77])
        pair = []
        for k, body in enumerate((None, load)):
            recording = simulator.record(motion, body, noise, [seed, k], f"run{seed}-{k}")
            flicker = 2e-5 * draw.standard_normal(recording.q.shape)
            flicker[:, [joint - 1 for joint in joints]] = 0.0
            pair.append(replace(recording, q=recording.q + flicker))
        return Pair(*pair)

    return make


@pytest.fixture(scope="session")
def arm(record: Record, simulator: Simulator) -> ShortMotion:
    pair = record((2, 3, 5, 6))
    return difference_weighing(simulator.robot, [pair.loaded], [pair.bare])
