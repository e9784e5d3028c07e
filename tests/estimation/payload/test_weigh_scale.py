"""A payload that was weighed on a scale as well."""

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.estimation import KnownMass, PossibleBody, StandIn
from dynident.tests.estimation.payload.recordings import LOAD, Record, weighed
from dynident.trajectories import Simulator


def test_with_a_scale_the_wrist_alone_will_do(record: Record, simulator: Simulator) -> None:
    rules = (PossibleBody(), KnownMass(7.02, 0.02))
    answer = weighed(simulator.robot, record((4, 5, 6)), constraints=rules)
    assert answer.judged["mass"].use == "weighed"
    assert answer.mass == pytest.approx(7.02, abs=1e-3)
    assert answer.weighing is None
    assert all(group.mass is None for group in answer.by_joints.masses)
    assert np.abs(answer.com - LOAD.com).max() < 0.02
    # 0.02 kg of the scale is all that is unsure about it
    assert answer.spread.mass == pytest.approx(0.02)


@pytest.mark.long
def test_one_joint_with_a_scale_tells_what_it_shows(record: Record, simulator: Simulator) -> None:
    pair = record((6,))
    rules = (PossibleBody(), KnownMass(7.02, 0.02))
    answer = weighed(simulator.robot, pair, constraints=rules)
    assert answer.possible is None
    assert np.flatnonzero(np.isfinite(answer.ten)).tolist() == [5, 6, 7, 9]  # ZZ, MX, MY, M
    assert np.isfinite(answer.com).tolist() == [True, True, False]
    assert answer.judged["centre of mass"].use == "not visible"
    assert answer.verdict.level == "do_not_use"
    with pytest.raises(InputError, match="centre of mass that is not known"):
        weighed(simulator.robot, pair, constraints=rules, stand_in=StandIn.parse("box:60x60x350"))


def test_a_scale_that_is_wrong_is_told(record: Record, simulator: Simulator) -> None:
    rules = (PossibleBody(), KnownMass(9.0, 0.02))
    answer = weighed(simulator.robot, record((2, 3, 5, 6)), constraints=rules)
    assert answer.verdict.level == "do_not_use"
    assert any("the scale shows 9" in reason for reason in answer.verdict.reasons)


def test_a_scale_sharpens(record: Record, simulator: Simulator) -> None:
    pair = record((2, 3, 5, 6))
    free = weighed(simulator.robot, pair)
    known = weighed(simulator.robot, pair, constraints=(PossibleBody(), KnownMass(7.02, 0.005)))
    assert known.spread.com[2] < free.spread.com[2]
    assert np.ptp(known.mass_interval) < np.ptp(free.mass_interval)
