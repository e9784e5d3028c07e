"""Wrong assumptions are undone one by one; good recordings give no cause."""

import numpy as np
import pytest
from dynident.benchmarks import invented
from dynident.estimation.diagnosis.misfit import Model
from dynident.estimation.diagnosis.sample import Sample
from dynident.estimation.diagnosis.search import likely_causes
from dynident.estimation.payload import Source
from dynident.model import Spring
from dynident.tests.estimation import mistakes
from dynident.trajectories import Simulator


def causes(name: str, change: mistakes.Change, contradicted: bool = True) -> str:
    _, bare, loaded, _ = mistakes.good(name)
    robot = invented.robot(name)
    likely = likely_causes(robot, Source((change(loaded),), (change(bare),), robot.processing), contradicted)
    return " ".join(cause.words for cause in likely)


@pytest.mark.parametrize("name", invented.NAMES)
def test_good_recordings_give_no_cause(name: str) -> None:
    assert causes(name, mistakes.same) == ""


@pytest.mark.parametrize("delay", [-0.1, 0.05, 0.3])
def test_a_delay_is_found_with_its_sign_and_size(delay: float) -> None:
    words = causes("rx90", mistakes.read_at(lambda t: t - delay))
    assert f"torque {'lags' if delay > 0 else 'leads'} position by about {abs(delay):.2f} s" in words


def test_what_is_told_is_what_is_left() -> None:
    """The residual after undoing a delay is that of the good recording."""
    _, bare, loaded, _ = mistakes.good("rx90")
    robot = invented.robot("rx90")
    late = mistakes.read_at(lambda t: t - 0.2)
    (cause,) = likely_causes(robot, Source((late(loaded),), (late(bare),), robot.processing))
    own = loaded if cause.source == loaded.source else bare
    good = Model.of(robot, Sample.of(own, robot.processing)).misfit()
    assert cause.after == pytest.approx(good, rel=0.15)
    assert cause.before > 4.0 * cause.after


def test_causes_that_cannot_be_told_apart_are_all_told() -> None:
    """On the RX90 the coupling lets a wrong sign of torque 5 look like one of torque 6."""
    words = causes("rx90", mistakes.scaled(5, -1.0))
    assert "sign of the torque of joint 5 is wrong, or the sign of the torque of joint 6 is wrong" in words


def test_a_known_spring_is_no_misfit() -> None:
    """The spring's torque is taken off before anything is tried."""
    from dataclasses import replace

    robot = invented.robot("rx90")
    spring = Spring(joint=2, stiffness=2e4, length=0.2, arms=(0.3, 0.1), zero=0.1)
    sprung = replace(robot, drives=replace(robot.drives, spring=spring))
    recording = Simulator(sprung).record(mistakes.good("rx90")[0])
    sample = Sample.of(recording, robot.processing)
    with_spring, without = (Model.of(variant, sample).per_joint()[1] for variant in (sprung, robot))
    assert without > 2.0 * with_spring


def test_a_model_without_noise_fits_to_what_the_filters_leave() -> None:
    recording = invented.simulator("tx40").record(mistakes.good("tx40")[0])
    model = Model.of(invented.robot("tx40"), Sample.of(recording, invented.robot("tx40").processing))
    assert model.misfit() < 0.03
    assert model.Q.shape[1] == 54
    assert np.allclose(model.Q.T @ model.Q, np.eye(54), atol=1e-6)
