"""Effects beside the model: what is put into recordings is found, and good recordings hold none.

A pull that changes with the place of the tool leaves residuals that no payload explains. A constant one that points
up is a lighter payload while the arm moves slowly: only weighing the payload, or taking the hose off, shows it.
"""

from dataclasses import replace

import numpy as np
import pytest
from dynident.apps.logs.log_check import check_log
from dynident.benchmarks import invented
from dynident.common.arrays import Array
from dynident.estimation import Settings, answer_payload, identify, payload_estimate, payload_problem
from dynident.estimation.diagnosis.causes import Comparison, channels
from dynident.estimation.diagnosis.engine import Effect, States, System, states_of
from dynident.estimation.diagnosis.hypotheses import (
    BY_NAME,
    WHERE,
    WITH_PAYLOAD,
    effects_of,
    seen,
    tilt_correction,
    upright,
)
from dynident.estimation.diagnosis.scales import scales
from dynident.estimation.diagnosis.verdict import system_of as system_on
from dynident.estimation.payload.methods import PayloadProblem
from dynident.model import InertialParameters, Recording, robot_names
from dynident.tests.estimation.diagnosis.hung import ABOVE, BESIDE, NOTHING, first, pulled
from dynident.tests.selection import every
from dynident.trajectories import Simulator, random_via_points

ROBOT = invented.robot("ur10e")
BODY = InertialParameters.from_com(5.0, [0.01, 0.03, 0.08], np.diag([0.03, 0.03, 0.02]))
NOISE = (4.0, 5.0, 2.5, 0.8, 0.8, 0.5)
G = 9.81


def moved(arm: Simulator, load: InertialParameters | None, seed: int) -> Recording:
    """One motion of some 20 s."""
    return arm.record(random_via_points(ROBOT, 12, seed=3).motion(200.0), load, NOISE, seed)


@pytest.fixture(scope="module")
def pair() -> tuple[Recording, Recording]:
    """Without and with payload."""
    return moved(Simulator(ROBOT), None, 1), moved(Simulator(ROBOT), BODY, 2)


def test_a_constant_pull_upwards_is_a_lighter_payload(pair: tuple[Recording, Recording]) -> None:
    """By F/g, with no more residual than before: not knowable, as the page on verdicts says."""
    bare, heavy = pair
    free, hung = (
        payload_estimate(payload_problem(ROBOT, [loaded], [bare], settings=Settings(robust=False)), 1)
        for loaded in (heavy, pulled(heavy, 0.0, NOTHING, np.array([0.0, 0.0, 10.0])))
    )
    assert free.mass - hung.mass == pytest.approx(10.0 / G, rel=0.02)
    assert hung.estimate.fit.relative == pytest.approx(free.estimate.fit.relative, rel=0.2)


def system_of(problem: PayloadProblem) -> System:
    """The problem on thinned states."""
    assert problem.source is not None
    system = system_on(problem, states_of(problem.source))
    assert system is not None
    return system


def pull_of(loaded: Recording, bare: Recording, name: str = "ur10e") -> tuple[System, Effect]:
    """The pull at the flange, where it explains most."""
    system = system_of(payload_problem(invented.robot(name), [loaded], [bare], settings=Settings(robust=False)))
    return system, seen(system)["pull"]


stands_out = BY_NAME["pull"].stands_out


def acting(system: System) -> list[Effect]:
    """All that is said to pull."""
    return [effect for name, effect in effects_of(system).items() if name == "pull"]


def mass_sigma(pull: Effect) -> float:
    """Standard deviation of the mass's change [kg]."""
    return float(np.sqrt(pull.effect[9] @ pull.covariance @ pull.effect[9]))


@pytest.mark.parametrize("end", [ABOVE, BESIDE], ids=["above", "beside"])
def test_a_spring_is_measured(pair: tuple[Recording, Recording], end: Array) -> None:
    """Stiffness and horizontal force are right; corrected for them, the mass is too, within its deviation."""
    system, force = pull_of(pulled(pair[1], 5.0, end), pair[0])
    sigmas = np.sqrt(np.diag(force.covariance))
    assert np.all(np.abs(force.values - 5.0 * np.array([1.0, *(upright(ROBOT) @ end)])) < 3.0 * sigmas)
    mass = float(system.values[system.payload][9])
    assert abs(mass + force.change[9] - 5.0) < 3.0 * mass_sigma(force)
    (found,) = acting(system)
    assert found.where == WITH_PAYLOAD


@pytest.mark.parametrize("name", every(6, robot_names()))
def test_a_spring_is_seen_where_it_is(name: str) -> None:
    """A quarter of the payload's weight for each metre, in all recordings or some; good ones show none."""
    robot = invented.robot(name)
    body = InertialParameters.from_com(0.5 * robot.rated_payload, [0.02, -0.02, 0.08], 0.003 * np.eye(3))
    motion = random_via_points(robot, 12, seed=7).motion(100.0)
    bare, heavy = (
        first(invented.recorded(name, motion, load, k, 0.02), 40.0) for k, load in enumerate((None, body))
    )
    stiffness = body.mass * G / 4.0

    def hung(recording: Recording) -> Recording:
        return pulled(recording, stiffness, ABOVE, name=name)

    system, force = pull_of(heavy, bare, name)
    assert acting(system) == []
    assert not BY_NAME["weight"].stands_out(seen(system)["weight"])
    light = answer_payload(payload_problem(replace(robot, gravity=(0.0, 0.0, -9.0)), [heavy], [bare])).verdict
    assert not any("pulls at the flange" in text or "of robot" in text for text in light.reasons)
    for where, pair_of in zip(
        WHERE, ((hung(heavy), hung(bare)), (heavy, hung(bare)), (hung(heavy), bare)), strict=True
    ):
        system, force = pull_of(*pair_of, name)
        mass = float(system.values[system.payload][9])
        assert (force.where, stands_out(force)) == (where, True)
        assert force.values[0] == pytest.approx(stiffness, abs=4.0 * float(np.sqrt(force.covariance[0, 0])))
        assert abs(mass + force.change[9] - body.mass) < 4.0 * mass_sigma(force) + 0.02 * body.mass


def test_a_spring_in_all_recordings_leaves_the_mass_of_one_motion(pair: tuple[Recording, Recording]) -> None:
    """And is told; without payload alone it spoils the mass as much as with it."""
    bare, heavy = pair
    both, before = (
        answer_payload(payload_problem(ROBOT, [loaded], [pulled(bare, 10.0, ABOVE)]))
        for loaded in (pulled(heavy, 10.0, ABOVE), heavy)
    )
    assert both.verdict.level == "mass_and_com_only"
    assert both.verdict.reasons[0].startswith("something pulls at the flange")
    assert both.mass == pytest.approx(5.0, rel=0.03)
    assert before.verdict.level == "do_not_use"
    assert before.verdict.reasons[0].startswith("without payload something pulls at the flange")


def test_a_spring_at_the_robot_alone_is_told(pair: tuple[Recording, Recording]) -> None:
    """By ``identify`` and ``check``; the robot without it is told of nothing."""
    for recording, count in ((pulled(pair[0], 10.0, ABOVE), 1), (pair[0], 0)):
        notes = identify(ROBOT, [recording], Settings(robust=False)).verdict.notes
        findings = [finding.text for finding in check_log(ROBOT, recording).findings]
        for texts in (notes, findings):
            assert sum("omething pulls at the flange" in text for text in texts) == count


def test_the_joint_on_another_scale_stands_out(pair: tuple[Recording, Recording]) -> None:
    loaded = replace(pair[1], torque=pair[1].torque * [1.0, 1.0, 0.85, 1.0, 1.0, 1.0])
    problem = payload_problem(ROBOT, [loaded], [pair[0]], settings=Settings(scale_sigma=0.0))
    assert problem.bare is not None
    worst = max(scales(problem, problem.bare.weights, None), key=lambda scale: abs(scale.size) / scale.sigma)
    assert worst.where == "joint 3"
    assert 0.7 < 1.0 + worst.size < 0.9  # the payload takes a part of it
    for factor, is_unit in ((0.03, True), (0.012, False)):  # of less than a fiftieth nothing is left
        bare, heavy = (replace(one, torque=one.torque * [1.0, 1.0, factor, 1.0, 1.0, 1.0]) for one in pair)
        states = system_of(payload_problem(ROBOT, [heavy], [bare], settings=Settings(robust=False))).states
        read = channels(Comparison(ROBOT, states), np.ones(len(states.t), dtype=bool))
        assert any("joint 3 is about" in text for text, *_ in read) == is_unit


@pytest.mark.long
def test_contact_is_a_burst(pair: tuple[Recording, Recording]) -> None:
    """One second of contact at joints 2 and 3: what is left out reaches into the standard deviation."""
    torque = np.array(pair[1].torque)
    torque[(pair[1].t > 8.0) & (pair[1].t < 9.0), 1:3] += [60.0, 30.0]
    problem = payload_problem(ROBOT, [replace(pair[1], torque=torque)], [pair[0]])
    free, burst = payload_estimate(problem, 4).estimate, seen(system_of(problem))["bursts"]
    assert burst.size <= 3
    (whole,) = (each.estimate for each in answer_payload(problem).estimates if each.method == 4)
    assert 1.96 * whole.sigma[9] >= 0.999 * abs(burst.change[9])
    assert whole.sigma[9] > free.sigma[9]


def found(torque: Array, pair: tuple[Recording, Recording]) -> dict[str, Effect]:
    """Effects in a pair whose torques with payload are these."""
    return dict(seen(system_of(payload_problem(ROBOT, [replace(pair[1], torque=torque)], [pair[0]]))))


def test_a_drift_is_measured(pair: tuple[Recording, Recording]) -> None:
    ramp = 8.0 * np.linspace(0.0, 1.0, len(pair[1].t))[:, None] * (np.arange(6) == 1)
    effect = found(pair[1].torque + ramp, pair)["drift"]
    assert BY_NAME["drift"].stands_out(effect)
    assert effect.where == "2 with payload"
    assert abs(effect.values[0] - 8.0) < 3.0 * effect.sigma


def test_good_recordings_hold_nothing_else(pair: tuple[Recording, Recording]) -> None:
    effects = found(pair[1].torque, pair)
    assert not tilt_correction(effects["tilt"], 4)[0].any()
    assert " ".join(sorted(effects)) == "change compensated drift gain late pull slip tilt weight zero"
    assert not any(BY_NAME[name].stands_out(effect) for name, effect in effects.items())


@pytest.mark.long
@pytest.mark.parametrize("degrees", [0.2, 2.0])
def test_a_base_that_leans_is_seen(degrees: float) -> None:
    """On both sides of half a degree; what is seen is right to a fifth."""
    across = G * np.sin(np.radians(degrees))
    arm = Simulator(replace(ROBOT, gravity=(across, 0.0, -float(np.sqrt(G**2 - across**2)))))
    bare, heavy = moved(arm, None, 1), moved(arm, BODY, 2)
    lean = seen(system_of(payload_problem(ROBOT, [heavy], [bare])))["tilt"]
    assert BY_NAME["tilt"].stands_out(lean) == (degrees > 0.5)
    assert np.degrees(lean.size) == pytest.approx(degrees, abs=0.2 * degrees + 3.0 * np.degrees(lean.sigma))


def test_torques_that_are_late_are_seen(pair: tuple[Recording, Recording]) -> None:
    torque = np.column_stack([np.interp(pair[1].t - 0.03, pair[1].t, column) for column in pair[1].torque.T])
    delay = found(torque, pair)["late"]
    assert delay.where == WITH_PAYLOAD
    assert delay.size > 0.0
    assert BY_NAME["late"].stands_out(delay)


def test_a_payload_that_slips_is_seen(pair: tuple[Recording, Recording]) -> None:
    """By 30 mm half way."""
    slipped = moved(Simulator(ROBOT), InertialParameters.from_com(5.0, [0.04, 0.03, 0.08], BODY.inertia_com), 2)
    effects = found(np.where(late_half(pair[1], 0.5), slipped.torque, pair[1].torque), pair)
    assert effects["slip"].size == pytest.approx(0.03, abs=0.01)
    assert BY_NAME["slip"].stands_out(effects["slip"])
    assert not BY_NAME["change"].stands_out(effects["change"])


@pytest.mark.parametrize("begin", [0.25, 0.5, 0.8])
def test_a_payload_that_is_taken_up_is_seen(pair: tuple[Recording, Recording], begin: float) -> None:
    """At a quarter, half or four fifths of the recording."""
    change = found(np.where(late_half(pair[1], begin), pair[1].torque, pair[0].torque), pair)["change"]
    assert change.size > 0.0
    assert BY_NAME["change"].stands_out(change)


def late_half(recording: Recording, begin: float) -> Array:
    """Rows after a share of the time."""
    return np.asarray(recording.t > begin * recording.t[-1])[:, None]


@pytest.mark.parametrize(("passages", "count"), [(1, 20), (3, 15)])
def test_passages_of_one_path_are_left_out_together(passages: int, count: int) -> None:
    """The second recording begins elsewhere on its way; a motion that does not repeat has 20 blocks of time."""
    period = 7.0 if passages > 1 else 40.0
    t = np.arange(passages * 700) / 100.0
    q = np.sin(2.0 * np.pi / period * t[:, None] * [1, 1, 2, 2, 3, 3] + np.arange(6))
    both = [Recording(t, np.roll(q, -150 * k, axis=0), q, source=str(k)) for k in range(min(passages, 2))]
    states = States.joined([States.of(one, ROBOT.processing, 70 * passages) for one in both])
    phase = np.exp(2j * np.pi / period * (states.t + 1.5 * states.recording))
    assert states.block.max() + 1 == count
    assert all(abs(phase[states.block == k].mean()) > 0.95 for k in range(count))
