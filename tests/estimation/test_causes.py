"""Wrong assumptions are undone one by one; good recordings give no cause."""

from dataclasses import replace

import numpy as np
import pytest
from dynident.benchmarks import invented
from dynident.estimation.diagnosis.causes import Comparison, likely_causes
from dynident.estimation.diagnosis.engine import System
from dynident.estimation.diagnosis.states import States, states_of
from dynident.estimation.payload.long_motion import Source
from dynident.model import Spring
from dynident.tests.estimation import mistakes
from dynident.trajectories import Simulator


def causes(name: str, change: mistakes.Change, contradicted: bool = True) -> str:
    _, bare, loaded, _ = mistakes.good(name)
    robot = invented.robot(name)
    states = states_of(Source((change(loaded),), (change(bare),), robot.processing))
    return " ".join(finding.text for finding in likely_causes(robot, states, contradicted))


@pytest.mark.parametrize("name", invented.NAMES)
def test_good_recordings_give_no_cause(name: str) -> None:
    assert causes(name, mistakes.same) == ""


@pytest.mark.parametrize("delay", [-0.1, 0.05, 0.3])
def test_a_delay_is_found_with_its_sign_and_size(delay: float) -> None:
    words = causes("rx90", mistakes.read_at(lambda t: t - delay))
    assert f"torque {'lags' if delay > 0 else 'leads'} position by about {abs(delay):.2f} s" in words


def test_what_is_told_is_what_is_left() -> None:
    """Chi2 after undoing a delay is that of the good recordings."""
    _, bare, loaded, _ = mistakes.good("rx90")
    robot = invented.robot("rx90")
    late = mistakes.read_at(lambda t: t - 0.2)
    good, wrong = (
        states_of(Source((change(loaded),), (change(bare),), robot.processing)) for change in (mistakes.same, late)
    )
    assert good is not None
    assert wrong is not None
    (cause,) = likely_causes(robot, wrong)
    left = [Comparison(robot, states).fit.relative() for states in (good, wrong)]
    assert 1.0 - cause.explains == pytest.approx(float(np.exp(2.0 * np.mean(np.log(left[0] / left[1])))), rel=0.3)
    assert cause.explains > 0.9


def test_a_coupling_does_not_hide_which_sign_is_wrong() -> None:
    words = causes("rx90", mistakes.scaled(5, -1.0))
    assert "sign of the torque of joint 5 is wrong" in words
    assert "joint 6" not in words


def test_the_one_wrong_recording_of_many_is_named() -> None:
    robot = invented.robot("rx90")
    good = [invented.recorded("rx90", invented.motion("rx90", k), None, k, 0.05) for k in range(6)]
    named = [replace(recording, source=f"{k}.csv") for k, recording in enumerate(good)]
    named[3] = replace(mistakes.scaled(3, -1.0)(good[3]), source="3.csv")
    (finding,) = likely_causes(robot, states_of(Source((), tuple(named), robot.processing)))
    assert finding.text.startswith("3.csv looks as if the sign of the torque of joint 3 is wrong")


def test_a_known_spring_is_no_misfit() -> None:
    """The spring's torque is taken off before anything is tried."""
    robot = invented.robot("rx90")
    spring = Spring(joint=2, stiffness=2e4, length=0.2, arms=(0.3, 0.1), zero=0.1)
    sprung = replace(robot, drives=replace(robot.drives, spring=spring))
    recording = Simulator(sprung).record(mistakes.good("rx90")[0])
    states = States.of(recording, robot.processing)
    with_spring, without = (System.of(arm, states).fit(np.ones(6)).relative()[1] for arm in (sprung, robot))
    assert without > 2.0 * with_spring


def test_a_model_without_noise_fits_to_what_the_filters_leave() -> None:
    recording = invented.simulator("tx40").record(mistakes.good("tx40")[0])
    states = States.of(recording, invented.robot("tx40").processing)
    fit = System.of(invented.robot("tx40"), states).fit(np.ones(6))
    assert np.sqrt(np.mean(fit.relative() ** 2)) < 0.03
    assert fit.root.shape[1] == 54
