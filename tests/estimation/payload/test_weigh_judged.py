"""Each quantity by its own, what intervals hold, and what is not to be used."""

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.estimation import Gains, ShortMotion, payload_estimate
from dynident.estimation.fit.estimate import error_model
from dynident.model import InertialParameters
from dynident.tests.estimation.payload.recordings import LOAD, Pair, Record, cut, weighed
from dynident.trajectories import Simulator


def test_every_quantity_is_judged_by_its_own(record: Record, simulator: Simulator) -> None:
    answer = weighed(simulator.robot, record((2, 3, 5, 6)))
    assert answer.judged["mass"].use == "use"
    assert answer.judged["centre of mass"].use == "use"
    low, high = answer.mass_interval
    assert low < LOAD.mass < high
    assert np.abs(answer.com - LOAD.com).max() < 4.0 * answer.spread.com.max()
    assert ((answer.com_interval[:, 0] < answer.com) & (answer.com < answer.com_interval[:, 1])).all()
    assert answer.verdict.level in ("use", "mass_and_com_only")
    assert {group.name for group in answer.by_joints.masses} >= {"joint 2", "joint 3", "joints 2-3", "joints 5-6"}


def test_inertia_counts_only_below_thirty_percent(simulator: Simulator, record: Record) -> None:
    light = InertialParameters.from_com(1.0, [0.0, 0.0, 0.05], 1e-3 * np.eye(3))
    answer = weighed(simulator.robot, record((2, 3, 5, 6), load=light))
    assert answer.judged["inertia"].use == "not measured well enough"
    heavy = InertialParameters.from_com(20.0, [0.0, 0.0, 0.1], np.eye(3))
    assert weighed(simulator.robot, record((2, 3, 5, 6), load=heavy)).judged["inertia"].use == "use"


def test_mass_not_visible_and_no_number_instead(record: Record, simulator: Simulator) -> None:
    with pytest.raises(InputError, match="mass not visible"):
        weighed(simulator.robot, record((4, 5, 6)))


def test_swapped_recordings_are_not_used(record: Record, simulator: Simulator) -> None:
    pair = record((2, 3, 5, 6))
    answer = weighed(simulator.robot, Pair(pair.loaded, pair.bare))
    assert answer.verdict.level == "do_not_use"
    assert any("negative" in reason for reason in answer.verdict.reasons)
    result = answer.result
    assert "use" not in {quantity.use for quantity in (result.mass, result.com, result.inertia)}


@pytest.mark.long
def test_coverage_of_the_mass(record: Record, simulator: Simulator) -> None:
    """20 seeds; the benchmark has 100 of each case."""
    hits, places = 0, np.zeros(3)
    for seed in range(20):
        answer = weighed(simulator.robot, record((2, 3, 5, 6), seed))
        low, high = answer.mass_interval
        hits += low <= LOAD.mass <= high
        places += (answer.com_interval[:, 0] <= LOAD.com) & (LOAD.com <= answer.com_interval[:, 1])
    assert hits >= 17  # of 95 %: fewer once in 60
    assert (places >= 16).all()


def test_gain_errors_widen(record: Record, simulator: Simulator, arm: ShortMotion) -> None:
    estimate = payload_estimate(arm, 3).estimate
    plain, unsure = error_model(estimate), error_model(estimate, Gains((0.0,), 0.02))
    wider = unsure.sigma[9] ** 2 - plain.sigma[9] ** 2
    assert np.sqrt(wider) == pytest.approx(0.02 * estimate["M_L"], rel=1e-6)  # common: scales the mass


@pytest.mark.parametrize("seed", range(1, 3))
def test_few_blocks_count(record: Record, simulator: Simulator, seed: int) -> None:
    """3 s give two blocks: sigma alone would do, but the interval is six times as wide as from many."""
    pair = Pair(*(cut(recording, 2.0, 5.0) for recording in record((2, 3, 5, 6), seed)))
    answer = weighed(simulator.robot, pair)
    assert answer.model.degrees_of_freedom == 1
    low, high = answer.mass_interval
    assert (high - low) / 2.0 > 0.1 * answer.mass
    assert answer.spread.mass < 0.05 * answer.mass
    assert answer.judged["mass"].use == "not measured well enough"
    assert answer.verdict.level == "do_not_use"


def test_a_short_motion_is_one_for_one_method(arm: ShortMotion) -> None:
    with pytest.raises(InputError, match="method 1 cannot be used: this short motion is one for method 3"):
        payload_estimate(arm, 1)
