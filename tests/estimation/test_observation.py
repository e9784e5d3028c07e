"""The observation system: Y = W chi on exact data, which rows are used."""

from collections.abc import Callable

import numpy as np
import pytest
from dynident.estimation.equations.observer import Observer, used
from dynident.estimation.signals.decimation import noise_bandwidth
from dynident.estimation.signals.rows import moving_parts
from dynident.model import Motion, Processing, base_parameters
from dynident.model.motion import Measurement
from dynident.trajectories import Simulator


@pytest.mark.parametrize("name", ["rx90", "tx40", "ur10e"])
def test_exact_data_satisfy_the_equations(
    name: str, simulated: Callable[[str], Simulator], wander: Callable[..., Motion]
) -> None:
    simulator = simulated(name)
    base = base_parameters(simulator.robot)
    truth = base.value(simulator.robot.parameters)
    data = Observer(simulator.robot, base.columns).observe(simulator.measure(wander(6, 0)), Processing())
    for W, Y in zip(data.W, data.Y, strict=True):
        assert len(Y) > 300
        assert np.abs(W @ truth - Y).max() < 1e-9 * np.abs(Y).max()


def test_parallel_decimation_keeps_the_equations(
    simulated: Callable[[str], Simulator], wander: Callable[..., Motion]
) -> None:
    simulator = simulated("rx90")
    base = base_parameters(simulator.robot)
    truth = base.value(simulator.robot.parameters)
    observer = Observer(simulator.robot, base.columns)
    data = observer.observe(simulator.measure(wander(6, 0, rate=250.0)), Processing(decimate=10))
    for W, Y, t in zip(data.W, data.Y, data.t, strict=True):
        assert np.abs(W @ truth - Y).max() < 1e-9 * np.abs(Y).max()
        assert np.allclose(np.diff(t)[np.diff(t) < 0.05], 0.04)
    assert data.bandwidth == noise_bandwidth(10)


def test_columns_may_repeat(simulated: Callable[[str], Simulator], wander: Callable[..., Motion]) -> None:
    simulator = simulated("rx90")
    observer = Observer(simulator.robot, ("XX6", "FV2", "XX6"), ("x", "f", "y"))
    data = observer.observe(simulator.measure(wander(6, 0)), Processing())
    assert data.columns == ("x", "f", "y")
    assert all(np.array_equal(W[:, 0], W[:, 2]) for W in data.W)
    assert np.abs(data.W[1][:, 1]).max() > 0.1


def paused(rate: float = 100.0) -> Motion:
    """Rest 1 s, move 2 s, rest 0.2 s, move 3 s, rest 2 s, move 1 s."""
    parts = [(1.0, 0.0), (2.0, 0.5), (0.2, 0.0), (3.0, -0.4), (2.0, 0.0), (1.0, 0.5)]
    speed = np.concatenate([np.full(int(d * rate), v) for d, v in parts])[:, None]
    t = np.arange(len(speed)) / rate
    return Motion(t, np.cumsum(speed, axis=0) / rate, speed, np.zeros_like(speed))


def test_moving_stretches_are_used_and_short_pauses_do_not_end_them() -> None:
    motion = paused()
    moving = moving_parts(motion, 2e-3)
    used = motion.t[moving]
    assert used[0] == pytest.approx(1.0)
    assert moving[(motion.t >= 1.0) & (motion.t < 6.2)].all()  # the pause of 0.2 s included
    assert not moving[(motion.t >= 6.2) & (motion.t < 8.2)].any()
    assert moving[motion.t >= 8.2].all() == (motion.t[-1] - 8.2 >= 1.0)
    resting = Motion(motion.t, motion.q, 0.0 * motion.qd, motion.qdd)
    assert not moving_parts(resting, 2e-3).any()


def test_a_jog_under_a_second_is_left_out_unless_there_is_nothing_else() -> None:
    motion = paused()
    early = slice(0, 150)  # at rest until 1 s, then 0.5 s of motion
    short = Motion(motion.t[early], motion.q[early], motion.qd[early], motion.qdd[early])
    assert moving_parts(short, 2e-3).sum() == 50
    late = slice(320, 1000)  # 3 s of motion, 2 s of rest, 1 s of motion less a little
    speed = np.array(motion.qd[late])
    speed[-5:] = 0.0
    assert not moving_parts(Motion(motion.t[late], motion.q[late], speed, motion.qdd[late]), 2e-3)[-100:].any()


def test_slow_rows_are_left_out(simulated: Callable[[str], Simulator], wander: Callable[..., Motion]) -> None:
    simulator = simulated("rx90")
    motion = wander(6, 0)
    observer = Observer(simulator.robot, ("FS1", "FS2", "FS3", "FS4", "FS5", "FS6"))
    data = observer.observe(simulator.measure(motion), Processing(slow_fraction=0.2))
    for j in range(6):
        fast = np.abs(motion.qd[:, j]) >= 0.2 * np.abs(motion.qd[:, j]).max()
        assert len(data.Y[j]) == fast.sum()
    partner = Motion(motion.t, motion.q, 0.0 * motion.qd, motion.qdd)
    none = observer.observe_rows(*used(Measurement(motion, np.zeros_like(motion.q)), Processing(), partner))
    assert sum(len(Y) for Y in none.Y) == 0
