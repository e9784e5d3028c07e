"""Repeated recordings, and a robot known beforehand instead of one without payload."""

from dataclasses import replace

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.estimation import Gains, Settings, answer_payload, identify, payload_estimate
from dynident.estimation.payload.weighing import difference_weighing, known_robot_weighing
from dynident.tests.estimation.payload.recordings import LOAD, NOISE, Record
from dynident.trajectories import Simulator, random_via_points


@pytest.mark.long
def test_repeats_spread_and_no_drift(record: Record, simulator: Simulator) -> None:
    pairs = [record((2, 3, 5, 6), seed) for seed in range(4)]
    answer = answer_payload(
        difference_weighing(simulator.robot, [p.loaded for p in pairs], [p.bare for p in pairs])
    )
    repeats = answer.repeats
    assert repeats is not None
    assert len(repeats.masses) == 4
    assert repeats.spread == pytest.approx(np.std(np.array(repeats.masses, dtype=float), ddof=1))
    assert not repeats.drifts
    assert answer.spread.mass / repeats.excess < np.array(repeats.sigmas, dtype=float).min()
    single = answer_payload(difference_weighing(simulator.robot, [p.loaded for p in pairs], [pairs[0].bare]))
    assert single.mass == pytest.approx(LOAD.mass, abs=0.3)


@pytest.mark.long
def test_a_drift_is_told_and_widens(record: Record, simulator: Simulator) -> None:
    """Torques that grow by 3 % from one recording to the next."""
    pairs = [record((2, 3, 5, 6), seed) for seed in range(4)]
    loaded = [replace(p.loaded, torque=(1.0 + 0.03 * k) * p.loaded.torque) for k, p in enumerate(pairs)]
    answer = answer_payload(difference_weighing(simulator.robot, loaded, [p.bare for p in pairs]))
    assert answer.repeats is not None
    assert answer.repeats.drifts
    assert answer.repeats.drift_per_recording is not None
    assert answer.repeats.drift_per_recording > 0.1
    assert answer.repeats.excess > 1.5
    assert any("drifts" in text for text in (*answer.verdict.reasons, *answer.verdict.notes))


@pytest.mark.long
def test_robot_parameters_instead_of_a_recording(record: Record, simulator: Simulator) -> None:
    robot = simulator.robot
    motion = random_via_points(robot, 14, 1).motion(250.0)
    known = identify(robot, [simulator.record(motion, None, NOISE, 1)], Settings(robust=False)).estimate
    pair = record((2, 3, 5, 6))
    problem = known_robot_weighing(robot, [pair.loaded], known)
    answer = answer_payload(
        problem, gains=Gains((0.01,)), others=[difference_weighing(robot, [pair.loaded], [pair.bare])]
    )
    assert answer.mass == pytest.approx(LOAD.mass, abs=3.0 * answer.spread.mass)
    exact = replace(problem, known=replace(known, covariance=1e-6 * known.covariance))
    unsure, certain = (payload_estimate(variant, 1).estimate.sigma[9] for variant in (problem, exact))
    assert unsure > certain
    assert [way.name for way in answer.agreement] == ["torque difference (method 3)"]
    with pytest.raises(InputError, match="another model"):
        known_robot_weighing(robot.with_offsets(True), [pair.loaded], known)
