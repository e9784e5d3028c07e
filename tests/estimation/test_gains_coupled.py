"""Drive gains of arms with coupled drives and with a known spring: one gain per motor."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs.read import read_recording
from dynident.common.arrays import Array
from dynident.estimation import Gains, LongMotion, Settings, answer_gains, payload_estimate, payload_problem
from dynident.estimation.fit.least_squares import weighted
from dynident.estimation.gains.known_load import known_mass
from dynident.estimation.gains.problem import gain_problem, gravity_acts, rests_on
from dynident.estimation.payload.methods import METHODS
from dynident.estimation.payload.result import constrain_payload
from dynident.model import InertialParameters, Motion, Processing, Recording, Robot, Spring, load_robot
from dynident.trajectories import Simulator

TRUTH = np.array([40.0, 45.0, 38.0, 20.0, 18.0, 12.0])
"""N·m/A, of the motors on the joint side."""
SPRINGS = {
    "none": None,
    "stiff": Spring(2, 6000.0, 0.15, (0.08, 0.35), np.pi / 2),
    "ideal": Spring(2, 6000.0, 0.0, (0.08, 0.35), np.pi / 2),
}
BODY = InertialParameters.from_com(6.0, [0.03, 0.12, 0.06], np.diag([0.03, 0.04, 0.02]))
SETTINGS = Processing(decimate=5, slow_fraction=0.02)
Currents = Callable[[str, str, int], tuple[Robot, list[Recording]]]


def arm(name: str, spring: str) -> Robot:
    robot = load_robot(name)
    return replace(robot, drives=replace(robot.drives, spring=SPRINGS[spring]))


@pytest.fixture(scope="module")
def currents(wander: Callable[..., Motion]) -> Currents:
    """Recordings of motor currents without and with the payload, white noise of 2 %."""

    def pair(name: str, spring: str, seed: int) -> tuple[Robot, list[Recording]]:
        robot = arm(name, spring)
        assert robot.coupling is not None
        simulator, moved = Simulator(replace(robot, parameters=load_robot("rx90").parameters)), wander(6, 3, 40)
        middle = np.mean([joint.limits.position for joint in robot.joints], axis=1) * (name == "tx40")
        motion = Motion(moved.t, moved.q + middle, moved.qd, moved.qdd)
        draw = np.random.default_rng(seed)
        recordings = []
        for k, load in enumerate((None, BODY)):
            exact = robot.coupling.motor_torques(simulator.measure(motion, load).torque) / TRUTH
            noise = 0.02 * np.sqrt(np.mean(exact**2, axis=0)) * draw.standard_normal(exact.shape)
            recordings.append(Recording(motion.t, motion.q, exact + noise, motion.qd, f"log {k}"))
        return robot, recordings

    return pair


@pytest.mark.parametrize(
    ("name", "spring"),
    [
        *(pytest.param("rx90", spring, marks=pytest.mark.long) for spring in ("none", "stiff", "ideal")),
        ("tx40", "none"),
    ],
)
def test_truth_within_the_stated_sigma(currents: Currents, name: str, spring: str) -> None:
    """One gain per motor, all of them known to 1 %; two draws of noise."""
    errors = []
    for seed in range(2):
        robot, (bare, loaded) = currents(name, spring, seed)
        load = known_mass(6.0)
        problem = gain_problem(robot, [bare], [loaded], Settings(SETTINGS), load=load)
        gains = answer_gains(replace(problem, deletions=() if seed else problem.deletions), load)
        assert gains.values == pytest.approx(TRUTH, rel=0.02)
        assert gains.logarithms.sigma.max() < 0.01
        errors.append(np.log(gains.values / TRUTH) / gains.logarithms.sigma)
        if not seed:
            assert gains.logarithms.robust is not None
            assert (gains.logarithms.robust.sigma / gains.logarithms.sigma).min() > 0.4
            assert (gains.logarithms.robust.sigma / gains.logarithms.sigma).max() < 2.5
    assert 0.3 < np.sqrt(np.mean(np.square(errors))) < 1.7
    assert np.abs(errors).max() < 4.5


@pytest.mark.long
def test_a_coupling_that_is_not_told_spoils_the_gains(currents: Currents) -> None:
    """The test above could fail: with each current taken for its joint's own, motor 5 is off by many sigma."""
    robot, (bare, loaded) = currents("rx90", "none", 0)
    uncoupled = replace(robot, drives=replace(robot.drives, coupling=None))
    problem = gain_problem(uncoupled, [bare], [loaded], Settings(SETTINGS))
    gains = answer_gains(replace(problem, deletions=()), known_mass(6.0))
    assert abs(np.log(gains.values / TRUTH) / gains.logarithms.sigma)[4] > 10.0


def test_words_tell_what_a_gain_rests_on() -> None:
    robot = arm("rx90", "stiff")
    assert gravity_acts(robot) == (False, True, True, True, True, True)
    words = rests_on(robot)
    assert "inertia only" in words[0]
    assert "known spring" in words[1]
    assert words[4].endswith("(the torque of joint 5 less that of joint 6)")
    assert "turns with joints 5 and 6" in words[5]


def test_currents_of_coupled_drives_make_joint_torques(tmp_path: Path) -> None:
    """(9): joint 5 feels both motors."""
    path = tmp_path / "log.csv"
    names = ["t", *(f"{kind}{j}" for kind in ("q", "i") for j in range(1, 7))]
    rows = ["0,0,0,0,0,0,0,1,2,3,4,5,6", "0.01,0,0,0,0,0,0,1,2,3,4,5,7"]
    path.write_text("\n".join([",".join(names), *rows]) + "\n")
    recording = read_recording(path, load_robot("rx90"), (2.0,) * 5 + (10.0,))
    assert recording.torque.tolist() == [[2, 4, 6, 8, 70, 60], [2, 4, 6, 8, 80, 70]]
    coupling = load_robot("rx90").coupling
    assert coupling is not None
    assert coupling.motor_torques(recording.torque)[:, 4:].tolist() == [[10, 60], [10, 70]]


@pytest.mark.long
def test_how_sure_they_are_reaches_the_payload(currents: Currents) -> None:
    """Weighed with gains that were found: as the same currents read with each gain a little larger tell."""
    robot, (bare, loaded) = currents("rx90", "none", 0)
    problem = gain_problem(robot, [bare], [loaded], Settings(SETTINGS))
    gains = answer_gains(replace(problem, deletions=()), known_mass(6.0))
    later = currents("rx90", "none", 7)[1]

    def weighing(K: Array) -> LongMotion:
        assert robot.coupling is not None
        before, after = (
            replace(recording, torque=robot.coupling.joint_torques(recording.torque * K)) for recording in later
        )
        return payload_problem(robot, [after], [before], settings=Settings(SETTINGS, robust=False))

    at_once = weighing(gains.values)
    assert at_once.unloaded is not None
    shifted = [weighing(gains.values * (1.0 + 1e-5 * own)) for own in np.eye(6)]
    for moved_problem in shifted:
        assert moved_problem.unloaded is not None
        vars(moved_problem)["bare"] = weighted(moved_problem.unloaded, weighted(at_once.unloaded).weights)
    unsure = Gains(identified=gains.larger_relative_covariance.tolist())
    for method in (1, 2, 3, 4):
        free = payload_estimate(at_once, method)
        values = [METHODS[method](moved_problem).solved(free.estimate.weights).values for moved_problem in shifted]
        J = (np.column_stack(values) - free.estimate.values[:, None]) / 1e-5
        with_gains, exact = (constrain_payload(free, gains=g) for g in (unsure, None))
        share = with_gains.result.free.covariance - exact.result.free.covariance
        expected = J @ gains.larger_relative_covariance @ J.T
        assert share == pytest.approx(expected, rel=1e-3, abs=1e-4 * np.abs(expected).max())
        assert np.abs((free.estimate.values - BODY.vector) / with_gains.result.free.sigma).max() < 3.5
        low, high = with_gains.intervals.parameters[9]
        assert low <= BODY.mass <= high
