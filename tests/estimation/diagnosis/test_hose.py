"""A hose or cable that pulls at the tool: what the recordings show of it, and what nothing can.

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
from dynident.estimation.diagnosis.engine import Effect, System
from dynident.estimation.diagnosis.hypotheses import BY_NAME, WHERE, WITH_PAYLOAD, effects_of, seen, upright
from dynident.estimation.diagnosis.states import states_of
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


@pytest.fixture(scope="module")
def pair() -> tuple[Recording, Recording]:
    """Without and with payload, 20 s of one motion."""
    simulator = Simulator(ROBOT)
    motion = random_via_points(ROBOT, 12, seed=3).motion(100.0)
    return first(simulator.record(motion, None, NOISE, 1)), first(simulator.record(motion, BODY, NOISE, 2))


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
    """Names of all that is said to pull."""
    return [effect for effect in effects_of(system) if effect.name == "pull"]


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
    bare, heavy = (first(invented.recorded(name, motion, load, k, 0.02)) for k, load in enumerate((None, body)))
    stiffness = body.mass * G / 4.0

    def hung(recording: Recording) -> Recording:
        return pulled(recording, stiffness, ABOVE, name=name)

    system, force = pull_of(heavy, bare, name)
    assert acting(system) == []
    for where, pair_of in zip(
        WHERE, ((hung(heavy), hung(bare)), (heavy, hung(bare)), (hung(heavy), bare)), strict=True
    ):
        system, force = pull_of(*pair_of, name)
        mass = float(system.values[system.payload][9])
        assert (force.where, stands_out(force)) == (where, True)
        assert force.values[0] == pytest.approx(stiffness, abs=4.0 * float(np.sqrt(force.covariance[0, 0])))
        assert abs(mass + force.change[9] - body.mass) < 4.0 * mass_sigma(force) + 0.02 * body.mass


@pytest.mark.parametrize("name", every(6, robot_names()))
def test_a_tilted_base_is_no_pull(name: str) -> None:
    """Two degrees in both recordings: it looks like a force to the side, which explains no more."""
    robot = invented.robot(name)
    body = InertialParameters.from_com(0.5 * robot.rated_payload, [0.02, -0.02, 0.08], 0.003 * np.eye(3))
    motion = random_via_points(robot, 12, seed=7).motion(100.0)
    aside = G * np.sin(np.radians(2.0))
    arm = Simulator(replace(robot, gravity=(0.6 * aside, 0.8 * aside, -G * np.cos(np.radians(2.0)))))
    bare, heavy = (
        first(invented.recorded(name, motion, load, k, 0.02, arm=arm)) for k, load in enumerate((None, body))
    )
    system, _ = pull_of(heavy, bare, name)
    assert BY_NAME["tilt"].stands_out(seen(system)["tilt"])
    assert acting(system) == []


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
