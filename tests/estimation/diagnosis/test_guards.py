"""Guards on recordings: what they are made for is found, and good recordings pass."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from dynident.benchmarks import invented
from dynident.common.arrays import Array
from dynident.estimation import PayloadAnswer, Settings, answer_payload, payload_estimate, payload_problem
from dynident.estimation.diagnosis.causes import alternatives
from dynident.estimation.diagnosis.engine import System
from dynident.estimation.diagnosis.evidence import Alternative
from dynident.estimation.diagnosis.hypotheses import BURST, BY_NAME, seen, tilt_correction
from dynident.estimation.diagnosis.scales import scales
from dynident.estimation.diagnosis.states import states_of
from dynident.estimation.diagnosis.verdict import system_of
from dynident.estimation.payload.long_motion import LongMotion, Source
from dynident.model import InertialParameters, Recording, load_robot
from dynident.trajectories import Simulator, random_via_points

NAME = "ur10e"
BODY = InertialParameters.from_com(5.0, [0.01, 0.03, 0.08], np.diag([0.03, 0.03, 0.02]))
NOISE = (4.0, 5.0, 2.5, 0.8, 0.8, 0.5)


@pytest.fixture(scope="module")
def pair() -> tuple[Recording, Recording]:
    """Without and with 5 kg, the same motion of some 20 s."""
    simulator = Simulator(invented.robot(NAME))
    motion = random_via_points(simulator.robot, 12, seed=3).motion(200.0)
    return simulator.record(motion, None, NOISE, 1), simulator.record(motion, BODY, NOISE, 2)


@pytest.fixture(scope="module")
def posed(pair: tuple[Recording, Recording]) -> Callable[..., LongMotion]:
    """``posed(factor)``: the problem with the loaded torques times a factor, one for each joint."""

    def problem(factor: float | Array = 1.0, scale_sigma: float = 0.0) -> LongMotion:
        loaded = replace(pair[1], torque=pair[1].torque * factor)
        return payload_problem(
            invented.robot(NAME), [loaded], [pair[0]], settings=Settings(scale_sigma=scale_sigma)
        )

    return problem


def answered(problem: LongMotion) -> PayloadAnswer:
    return answer_payload(problem)


def weights(problem: LongMotion) -> Array:
    assert problem.bare is not None
    return problem.bare.weights


def test_the_joint_on_another_scale_stands_out(posed: Callable[..., LongMotion]) -> None:
    problem = posed(np.array([1.0, 1.0, 0.85, 1.0, 1.0, 1.0]))
    worst = max(scales(problem, weights(problem)), key=lambda scale: abs(scale.size) / scale.sigma)
    assert worst.where == "joint 3"
    assert 0.7 < 1.0 + worst.size < 0.9  # the payload takes a part of it


@pytest.mark.long
def test_contact_is_a_burst(pair: tuple[Recording, Recording]) -> None:
    """One second of contact: what is left out reaches into the standard deviation."""
    assert BURST > 1.0
    problem = payload_problem(invented.robot(NAME), [struck(pair[1])], [pair[0]])
    free = payload_estimate(problem, 4).estimate
    system = system_of(problem, states_of(problem.source)) if problem.source else None
    assert system is not None
    burst = seen(system)["bursts"]
    assert burst.size <= 3
    whole = next(estimate for estimate in answered(problem).estimates if estimate.method == 4).estimate
    assert 1.96 * whole.sigma[9] >= 0.999 * abs(burst.change[9])
    assert whole.sigma[9] > free.sigma[9]


def struck(recording: Recording) -> Recording:
    """One second of contact at joints 2 and 3."""
    torque = np.array(recording.torque)
    torque[(recording.t > 8.0) & (recording.t < 9.0), 1:3] += [60.0, 30.0]
    return replace(recording, torque=torque)


def named(found: tuple[Alternative, ...], kind: str, name: str) -> Alternative:
    return next(rival for rival in found if (rival.kind, rival.name) == (kind, name))


def test_the_robot_that_was_recorded_explains_most(pair: tuple[Recording, Recording]) -> None:
    source = Source((pair[1],), (pair[0],), load_robot(NAME).processing)
    right, wrong = (
        alternatives(load_robot(NAME), states_of(source)),
        alternatives(load_robot("ur20"), states_of(source)),
    )
    assert all(rival.fall < 0.0 for rival in right if rival.kind == "robot")
    assert max(wrong, key=lambda rival: rival.fall).name == NAME
    assert named(wrong, "robot", NAME).z > 2.0


def test_a_joint_counted_the_other_way_is_found(pair: tuple[Recording, Recording]) -> None:
    """Positions and torques of a joint have the other sign in both recordings: nothing else would show it."""
    sign = np.array([1.0, 1.0, 1.0, -1.0, 1.0, 1.0])
    turned = [
        replace(
            recording,
            q=recording.q * sign,
            qd=None if recording.qd is None else recording.qd * sign,
            torque=recording.torque * sign,
        )
        for recording in pair
    ]
    source = Source((turned[1],), (turned[0],), load_robot(NAME).processing)
    best = max(alternatives(load_robot(NAME), states_of(source)), key=lambda rival: rival.fall)
    assert (best.kind, best.name) == ("turned", "4")
    assert best.z > 3.0


def beside(loaded: Recording, bare: Recording) -> System:
    problem = payload_problem(invented.robot(NAME), [loaded], [bare])
    assert problem.source is not None
    system = system_of(problem, states_of(problem.source))
    assert system is not None
    return system


def test_good_recordings_hold_nothing_else(pair: tuple[Recording, Recording]) -> None:
    system = beside(pair[1], pair[0])
    effects = seen(system)
    assert not tilt_correction(effects["tilt"], 4)[0].any()
    assert effects.keys() == {"pull", "tilt", "late", "slip", "change"}
    assert not any(BY_NAME[name].stands_out(effect) for name, effect in effects.items())


@pytest.mark.long
@pytest.mark.parametrize("degrees", [0.2, 2.0])
def test_a_base_that_leans_is_seen(pair: tuple[Recording, Recording], degrees: float) -> None:
    """On both sides of half a degree; what is seen is right to a fifth."""
    arm = invented.robot(NAME)
    across = 9.81 * np.sin(np.radians(degrees))
    leaning = Simulator(replace(arm, gravity=(across, 0.0, -float(np.sqrt(9.81**2 - across**2)))))
    motion = random_via_points(arm, 12, seed=3).motion(200.0)
    heavy, bare = leaning.record(motion, BODY, NOISE, 2), leaning.record(motion, None, NOISE, 1)
    lean = seen(beside(heavy, bare))["tilt"]
    assert BY_NAME["tilt"].stands_out(lean) == (degrees > 0.5)
    assert np.degrees(lean.size) == pytest.approx(degrees, abs=0.2 * degrees + 3.0 * np.degrees(lean.sigma))


def test_torques_that_are_late_are_seen(pair: tuple[Recording, Recording]) -> None:
    torque = np.column_stack([np.interp(pair[1].t - 0.03, pair[1].t, column) for column in pair[1].torque.T])
    delay = seen(beside(replace(pair[1], torque=torque), pair[0]))["late"]
    assert delay.where == " with payload"
    assert delay.size > 0.0
    assert BY_NAME["late"].stands_out(delay)


def test_a_payload_that_slips_is_seen(pair: tuple[Recording, Recording]) -> None:
    """By 30 mm half way."""
    slipped = InertialParameters.from_com(5.0, [0.04, 0.03, 0.08], np.diag([0.03, 0.03, 0.02]))
    arm = Simulator(invented.robot(NAME))
    later = arm.record(random_via_points(arm.robot, 12, seed=3).motion(200.0), slipped, NOISE, 2)
    half = pair[1].t > 0.5 * pair[1].t[-1]
    torque = np.where(half[:, None], later.torque, pair[1].torque)
    effects = seen(beside(replace(pair[1], torque=torque), pair[0]))
    assert effects["slip"].size == pytest.approx(0.03, abs=0.01)
    assert BY_NAME["slip"].stands_out(effects["slip"])
    assert not BY_NAME["change"].stands_out(effects["change"])


@pytest.mark.parametrize("begin", [0.25, 0.5, 0.8])
def test_a_payload_that_is_taken_up_is_seen(pair: tuple[Recording, Recording], begin: float) -> None:
    """At a quarter, half or four fifths of the recording."""
    torque = np.where((pair[1].t > begin * pair[1].t[-1])[:, None], pair[1].torque, pair[0].torque)
    effects = seen(beside(replace(pair[1], torque=torque), pair[0]))
    assert effects["change"].size > 0.0
    assert BY_NAME["change"].stands_out(effects["change"])
