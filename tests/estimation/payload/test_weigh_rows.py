"""Which joints and rows of a short motion count, and which recordings belong together."""

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.estimation import Settings, ShortMotion, payload_estimate
from dynident.estimation.payload.short_motion import telling_rows
from dynident.estimation.payload.weighing import difference_weighing
from dynident.estimation.signals.filtering import measurement
from dynident.tests.estimation.payload.recordings import LOAD, Record, cut, short
from dynident.trajectories import Simulator


def test_held_joints_are_dropped(arm: ShortMotion) -> None:
    assert short(arm).joints == (2, 3, 5, 6)
    assert [rows > 0 for rows in arm.loaded.rows] == [False, True, True, False, True, True]


def test_joints_asked_for_must_move(record: Record, simulator: Simulator) -> None:
    pair = record((2, 3, 5))
    with pytest.raises(InputError, match="joint 6 of rx90 does not move"):
        difference_weighing(simulator.robot, [pair.loaded], [pair.bare], settings=Settings(joints=(2, 6)))
    some = difference_weighing(simulator.robot, [pair.loaded], [pair.bare], settings=Settings(joints=(2, 5)))
    assert short(some).joints == (2, 5)


def test_recordings_that_do_not_form_pairs(record: Record, simulator: Simulator) -> None:
    a, b = record((2, 3, 5, 6)), record((2, 3, 5, 6), 1)
    with pytest.raises(InputError, match="one without for all"):
        difference_weighing(simulator.robot, [a.loaded, b.loaded, record((2, 3, 5, 6), 2).loaded], [a.bare, b.bare])


def test_without_noise_the_payload_is_exact(record: Record, simulator: Simulator) -> None:
    pair = record((2, 3, 5, 6), noise=np.zeros(6))
    payload = payload_estimate(difference_weighing(simulator.robot, [pair.loaded], [pair.bare]), 3)
    assert payload.ten == pytest.approx(LOAD.vector, abs=2e-3)


@pytest.mark.parametrize(("begin", "end"), [(2.3, 17.2), (1.1, 18.2), (3.1, 16.3)])
def test_ends_cut_in_full_motion_cost_little(
    record: Record, simulator: Simulator, begin: float, end: float
) -> None:
    """The filter errs there, alike in both recordings of a pair: the payload is off by up to 3e-3."""
    pair = record((2, 3, 5, 6), noise=np.zeros(6))
    problem = difference_weighing(simulator.robot, [cut(pair.loaded, begin, end)], [cut(pair.bare, begin, end)])
    assert payload_estimate(problem, 3).ten == pytest.approx(LOAD.vector, abs=5e-3)


def test_ends_cut_in_full_motion_are_left_out_of_a_single_recording(record: Record, simulator: Simulator) -> None:
    """Three periods of the cut-off are left out, 5 % at most, as everywhere but in a pair."""
    processing = simulator.robot.processing
    motion = measurement(cut(record((2, 3, 5, 6)).bare, 2.3, 17.2), processing).motion
    rows = telling_rows(motion, (2, 3, 5, 6), processing)
    whole = telling_rows(motion, (2, 3, 5, 6), processing, ends=True)
    lost = min(3.0 / (processing.cutoff or np.inf), 0.05 * (motion.t[-1] - motion.t[0]))
    inner = (motion.t >= motion.t[0] + lost) & (motion.t <= motion.t[-1] - lost)
    assert whole[~inner].any()
    assert not rows[motion.t < motion.t[0] + 0.99 * lost].any()
    assert not rows[motion.t > motion.t[-1] - 0.99 * lost].any()
    assert (rows[inner] == whole[inner]).mean() > 0.99
