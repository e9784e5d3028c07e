"""The moving window of a stream: what its blocks say of their own errors."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.estimation import Estimate, identify
from dynident.estimation.payload.live import LiveWeighing
from dynident.estimation.payload.window import MovingWindow
from dynident.model import InertialParameters, Motion, Recording, load_robot
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points

LOAD = InertialParameters.from_com(6.0, [0.0, 0.0, 0.1], [0.05, 0.05, 0.03])


class Known(NamedTuple):
    """A simulated arm, its parameters by an identification, and the noise of its torques [N·m]."""

    simulator: Simulator
    known: Estimate
    noise: Array

    def recorded(self, seed: int, payload: InertialParameters | None = None) -> Recording:
        """About 25 s, without payload unless one is given."""
        plan = random_via_points(self.simulator.robot, 14, seed=seed)
        return self.simulator.record(plan.motion(100.0), payload, self.noise, seed=seed)


@pytest.fixture(scope="module")
def arm() -> Known:
    simulator, noise = Simulator(load_robot("rx90")), np.array(RX90_NOISE)
    bare = simulator.record(random_via_points(simulator.robot, 14, seed=1).motion(100.0), noise=noise)
    return Known(simulator, identify(simulator.robot, [bare]).estimate, noise)


def test_a_joint_that_hardly_moved_tells_nothing_of_its_errors(arm: Known) -> None:
    """A few rows are fitted exactly by the joint's friction: a size of their errors would be rounding."""
    window, noise = MovingWindow(arm.simulator.robot, arm.known), arm.noise
    weighing, sizes = LiveWeighing(window), list[float]()
    for _ in weighing.feed(arm.simulator.record(turned_late(), noise=noise, seed=4)):
        sizes.append(float(window.held.noise[0]))
    assert all(size == 0.0 or 0.2 * noise[0] < size < 5.0 * noise[0] for size in sizes)
    assert 0 < sum(len(block.equations.Y[0]) for block in window.blocks) < 6
    assert not weighing.changes


def test_a_second_that_no_payload_explains_is_no_change(arm: Known) -> None:
    """Large errors that are no payload's, as of a jerk beyond the filter, make no change, then or after."""
    recording = arm.recorded(3)
    loud = (recording.t >= 20.0) & (recording.t < 21.0)
    errors = np.random.default_rng(5).standard_normal(recording.torque.shape) * arm.noise * 15.0
    torque = recording.torque + np.where(loud[:, None], errors, 0.0)
    weighing = LiveWeighing(MovingWindow(arm.simulator.robot, arm.known))
    list(weighing.feed(replace(recording, torque=torque)))
    assert len(weighing.window.blocks) > 15
    assert not weighing.changes


def test_the_window_begins_anew_behind_the_second_in_which_the_payload_changed(arm: Known) -> None:
    """That second holds both payloads."""
    bare, heavy = arm.recorded(3), arm.recorded(3, LOAD)
    torque = np.where((bare.t >= 15.0)[:, None], heavy.torque, bare.torque)
    weighing = LiveWeighing(MovingWindow(arm.simulator.robot, arm.known))
    changes = 0
    for news in weighing.feed(replace(bare, torque=torque)):
        if news.change is not None:
            changes += 1
            assert all(block.start > news.change.time for block in weighing.window.blocks)
    assert changes


def turned_late() -> Motion:
    """All joints swing but the first, which turns by three degrees at the end."""
    t = np.arange(1200) / 100.0
    share = np.clip((t - 10.2) / 0.6, 0.0, 1.0)
    turned = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    q = np.column_stack([0.05 * turned, 0.6 * np.sin(np.outer(t, [0.9, 1.1, 1.7, 1.9, 2.3]))])
    qd = np.gradient(q, t, axis=0)
    return Motion(t, q, qd, np.gradient(qd, t, axis=0))
