"""One wandering motion recorded without and with payload, with white noise."""

from collections.abc import Callable

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.estimation.equations.equations import Equations, merged
from dynident.estimation.equations.observer import Observation
from dynident.estimation.equations.reduction import reduced
from dynident.estimation.fit import blocks
from dynident.estimation.payload.problem import PairedMeasurement
from dynident.model import InertialParameters, Motion, Processing, load_robot
from dynident.model.motion import Measurement
from dynident.trajectories import Simulator

SETTINGS = Processing(decimate=4, slow_fraction=0.01)
Wander = Callable[..., Motion]


def noisy(data: Measurement, seed: int, size: float = 1.0) -> Measurement:
    noise = np.random.default_rng(seed).standard_normal(data.torque.shape)
    return Measurement(data.motion, data.torque + size * noise)


def later(data: Measurement, shift: float) -> Measurement:
    motion = data.motion
    return Measurement(Motion(motion.t + shift, motion.q, motion.qd, motion.qdd), data.torque)


@pytest.fixture(scope="module")
def simulator() -> Simulator:
    return Simulator(load_robot("rx90"))


@pytest.fixture(scope="module")
def pair(simulator: Simulator, payload: InertialParameters, wander: Wander) -> PairedMeasurement:
    motion = wander(6, 0, points=30)
    return PairedMeasurement(
        noisy(simulator.measure(motion), 0), noisy(simulator.measure(motion, payload), 1), lag=0.0
    )


def rows_out(whole: Equations, part: Equations) -> Array:
    """How many rows of each joint are left out."""
    return np.asarray(np.subtract(whole.rows, part.rows), dtype=float)


def same_equations(first: Equations, second: Equations) -> None:
    """The factors' Gram matrices are equal to rounding, and so are the numbers of rows."""
    assert (first.columns, first.rows) == (second.columns, second.rows)
    assert first.effective_rows == pytest.approx(second.effective_rows)
    for a, b in zip(first.factors, second.factors, strict=True):
        gram = b.T @ b
        size = np.sqrt(np.outer(np.diag(gram), np.diag(gram)))
        assert (np.abs(a.T @ a - gram) <= 1e-12 * size).all()


def block_length(groups: list[list[Observation]]) -> float:
    """Block length [s] of recordings of one load each."""
    return blocks.block_length([blocks.remembered(group, merged(map(reduced, group))) for group in groups])


def cut(recording: Observation, edges: Array) -> Equations:
    return blocks.in_blocks(reduced(recording), [recording], [edges], 1.0)
