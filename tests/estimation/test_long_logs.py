"""A log reduced piece by piece is the log held whole."""

from collections.abc import Callable, Iterator

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.estimation.equations import Observer, reduced_measurement
from dynident.estimation.equations.long_logs import reduced_log
from dynident.estimation.fit import weighted
from dynident.estimation.recordings import Samples
from dynident.estimation.signals import measurement
from dynident.model import Motion, Processing, Recording, base_parameters
from dynident.trajectories import Simulator


@pytest.fixture(scope="module")
def log(simulated: Callable[[str], Simulator], wander: Callable[..., Motion]) -> Recording:
    """Four minutes with noise, a pause in the middle, and time steps that differ."""
    motion = wander(6, 7, points=260, rate=100.0)
    exact = simulated("ur10e").record(motion, None, [1.0] * 6, 0)
    rest = 20.0
    half = len(exact.t) // 2
    pause = exact.t[half] + 0.01 * np.arange(1, int(100 * rest))
    t = np.concatenate([exact.t[: half + 1], pause, exact.t[half + 1 :] + rest])
    stay = np.repeat(exact.q[half : half + 1], len(pause), axis=0)
    hold = np.repeat(exact.torque[half : half + 1], len(pause), axis=0)
    q = np.concatenate([exact.q[: half + 1], stay, exact.q[half + 1 :]])
    torque = np.concatenate([exact.torque[: half + 1], hold, exact.torque[half + 1 :]])
    jitter = np.random.default_rng(0).uniform(-0.001, 0.001, len(t))
    return Recording(t + jitter, q, torque)


def blocks(log: Recording, size: int = 1000) -> Iterator[Samples]:
    for start in range(0, len(log.t), size):
        part = slice(start, start + size)
        yield Samples(log.t[part], log.q[part], log.torque[part], log.qd[part] if log.qd is not None else None)


@pytest.mark.parametrize(
    ("settings", "size"),
    [
        (Processing(rate=100.0, cutoff=5.0, decimate=10), 1111),
        (Processing(rate=90.0, cutoff=8.0, slow_fraction=0.05), 17),
        (Processing(rate=100.0, decimate=4, slow_fraction=0.01), 16_384),
    ],
)
def test_pieces_make_no_difference(
    simulated: Callable[[str], Simulator], log: Recording, settings: Processing, size: int
) -> None:
    robot = simulated("ur10e").robot
    observer = Observer(robot, base_parameters(robot).columns)
    whole = reduced_measurement(observer, measurement(log, settings), settings)
    pieces = reduced_log(observer, lambda: blocks(log, size), settings)
    assert pieces.rows == whole.rows
    a, b = weighted(pieces), weighted(whole)
    assert np.abs((a.values - b.values) / b.sigma).max() < 1e-3
    assert a.sigma == pytest.approx(b.sigma, rel=1e-4)


def test_uneven_time_needs_a_rate(simulated: Callable[[str], Simulator], log: Recording) -> None:
    robot = simulated("ur10e").robot
    observer = Observer(robot, base_parameters(robot).columns)
    with pytest.raises(InputError, match="needs --rate"):
        reduced_log(observer, lambda: blocks(log), Processing(cutoff=5.0))


def test_an_empty_log(simulated: Callable[[str], Simulator]) -> None:
    robot = simulated("ur10e").robot
    observer = Observer(robot, base_parameters(robot).columns)
    with pytest.raises(InputError, match="no rows"):
        reduced_log(observer, lambda: iter(()), Processing(rate=100.0))
