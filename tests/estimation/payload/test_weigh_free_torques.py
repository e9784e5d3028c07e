"""Constant torques and friction that changed between the recordings."""

from dataclasses import replace

import numpy as np
import pytest
from dynident.estimation import ShortMotion, payload_estimate
from dynident.estimation.payload.constant_torques import OFFSET_SHARE, HeldFriction
from dynident.estimation.payload.weighing import difference_weighing
from dynident.tests.estimation.payload.recordings import LOAD, Pair, Record, short, weighed
from dynident.trajectories import Simulator


def test_a_constant_torque_and_coulomb_friction_that_changed_do_not_matter(
    record: Record, simulator: Simulator
) -> None:
    pair = record((2, 3, 5, 6))
    qd = np.gradient(pair.loaded.q, pair.loaded.t, axis=0)
    changed = pair.loaded.torque + np.array([0, 9, 5, 0, 3, 1]) + np.array([0, 6, 3, 0, 2, 1]) * np.sign(qd)
    changed_pair = Pair(pair.bare, replace(pair.loaded, torque=changed))
    first, second = (weighed(simulator.robot, each_pair) for each_pair in (pair, changed_pair))
    assert first.short.held.joints == (1, 2)  # counted from 0
    assert second.short.held.joints == ()  # told by the recordings themselves
    assert second.mass == pytest.approx(first.mass, abs=2.0 * first.spread.mass)
    assert np.abs(second.com - first.com).max() < 2.0 * first.spread.com.max()
    assert second.mass == pytest.approx(LOAD.mass, abs=4.0 * second.spread.mass)
    assert abs(second.agreement[0].mass - LOAD.mass) > 0.1  # what plain differences make of it


def test_a_constant_torque_within_the_allowance_is_in_the_interval(
    record: Record, simulator: Simulator, arm: ShortMotion
) -> None:
    """What the allowance adds is what the mass changes by when constant torques differ by as much."""
    motion, payload = short(arm), payload_estimate(arm, 3)
    torques = motion.held
    assert torques.sigma[1] == pytest.approx(OFFSET_SHARE * simulator.robot.parameters["FS2"], rel=0.1)
    pair = record((2, 3, 5, 6))
    moved = np.zeros(10)
    for j in torques.joints:
        torque = pair.loaded.torque + np.eye(6)[j] * torques.sigma[j]
        moved_pair = difference_weighing(simulator.robot, [replace(pair.loaded, torque=torque)], [pair.bare])
        moved_payload = payload_estimate(moved_pair, 3)
        moved += (moved_payload.ten - payload.ten) ** 2
    free = replace(motion, held=HeldFriction({}, np.zeros(6), np.ones(6)))
    assert payload_estimate(free, 3).ten == pytest.approx(payload.ten, abs=5.0 * np.max(payload.estimate.sigma))
    assert payload.estimate.robust is not None
    assert moved[9] > 0.0
    assert payload.estimate.robust.covariance[9, 9] > 0.9 * moved[9]
