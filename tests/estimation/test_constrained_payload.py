"""The constrained payload beside each method's own, and what contradicts the data."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs.read import read_recording
from dynident.apps.report.sections.estimates import method_notes
from dynident.estimation import (
    CentreOfMassInBox,
    Gains,
    InEllipsoid,
    KnownMass,
    LongMotion,
    MassBounds,
    PossibleBody,
    Settings,
    SolverError,
    answer_payload,
    payload_estimate,
    payload_problem,
    solve_constrained,
)
from dynident.estimation.fit.estimate import error_model
from dynident.estimation.payload.result import constrain_payload
from dynident.estimation.possible import payload as possible_payload
from dynident.estimation.possible.constraints import Constraint
from dynident.model import InertialParameters, Motion, load_robot
from dynident.model.friction import PAPER
from dynident.trajectories import Simulator


@pytest.fixture(scope="module")
def problem(
    simulated: Callable[[str], Simulator], wander: Callable[..., Motion], payload: InertialParameters
) -> LongMotion:
    """An RX90 with 7.025 kg, in blocks of time."""
    simulator = simulated("rx90")
    motion = wander(6, 4, points=20)
    noise = [3.0] * 6
    bare, loaded = (simulator.record(motion, body, noise, [9, k]) for k, body in enumerate((None, payload)))
    return payload_problem(simulator.robot, [loaded], [bare])


def test_every_method_has_one(problem: LongMotion, payload: InertialParameters) -> None:
    answer = answer_payload(problem)
    assert [estimate.method for estimate in answer.constrained] == [1, 2, 3, 4]
    assert answer.recommended.method == 3
    assert answer.recommended.free is answer.estimates[2]
    for estimate in answer.constrained:
        robust = estimate.free.estimate.robust
        assert robust is not None
        assert estimate.body.physically_consistent
        assert estimate.sigma == pytest.approx(robust.sigma, rel=1e-9)
        assert estimate.result.free.degrees_of_freedom == robust.degrees_of_freedom
        ends = estimate.intervals.parameters
        assert ((ends[:, 0] <= estimate.result.values) & (estimate.result.values <= ends[:, 1])).all()
        assert (estimate.intervals.com[:, 0] <= estimate.body.com).all()
        assert (estimate.body.com <= estimate.intervals.com[:, 1]).all()
        assert (estimate.intervals.inertia_com[..., 0] <= estimate.body.inertia_com).all()
        assert ends[9, 0] <= payload.mass <= ends[9, 1]
        assert not estimate.conflict
    few = answer_payload(problem, methods=(2, 3))
    assert few.recommended.method == 3


def test_the_error_model_keeps_the_correlations(problem: LongMotion) -> None:
    estimate = answer_payload(problem, methods=(4,)).estimates[0].estimate
    model = error_model(estimate)
    sigma = np.outer(estimate.sigma, estimate.sigma)
    assert model.covariance / np.outer(model.sigma, model.sigma) == pytest.approx(estimate.covariance / sigma)
    assert (model.values == estimate.values).all()


def test_a_weighed_mass_enters_every_method(problem: LongMotion) -> None:
    """Two measurements of one mass; their difference in standard deviations."""
    plain, weighed = answer_payload(problem), answer_payload(problem, constraints=[KnownMass(7.03, 0.005)])
    for before, after in zip(plain.constrained, weighed.constrained, strict=True):
        (scale,) = after.weighings
        assert scale.identified == before.free.mass
        assert scale.z == pytest.approx((before.free.mass - 7.03) / np.hypot(0.005, before.sigma[9]))
        assert not scale.conflict
        assert np.ptp(after.intervals.parameters[9]) < 0.5 * np.ptp(before.intervals.parameters[9])
        assert after.mass == pytest.approx(7.03, abs=0.005)
        assert [rule.description for rule in after.result.constraints][-1].startswith("mass weighed as 7.03 kg")


WRONG: dict[str, Constraint] = {
    "mass bound": MassBounds(high=6.0),
    "ellipsoid": InEllipsoid([0.0, 0.0, -0.2], [0.1, 0.1, 0.1]),
    "box": CentreOfMassInBox([0.2, -0.1, 0.0], [0.4, 0.1, 0.3]),
}


@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG)
def test_what_excludes_the_truth_is_named(problem: LongMotion, wrong: Constraint) -> None:
    """And a true constraint beside it is not blamed; no interval is told."""
    right = CentreOfMassInBox([-0.5] * 3, [0.5] * 3)
    answer = answer_payload(problem, constraints=[right, wrong])
    assert answer.verdict.level == "do_not_use"
    assert any(wrong.description in reason for reason in answer.verdict.reasons)
    for estimate in answer.constrained:
        assert wrong in [conflict.constraint for conflict in estimate.conflicts]
        assert right not in [conflict.constraint for conflict in estimate.conflicts]
        assert estimate.conflict
        assert np.isnan(estimate.intervals.parameters).all()
    notes = method_notes(answer.result)
    assert any(note.startswith("Contradicted by method 1, 2, 3, 4: " + wrong.description) for note in notes)
    assert notes[0].startswith("No intervals")


def test_a_scale_that_errs_is_named(problem: LongMotion) -> None:
    answer = answer_payload(problem, constraints=[KnownMass(8.0, 0.02)])
    assert answer.verdict.level == "do_not_use"
    (reason,) = [reason for reason in answer.verdict.reasons if "the scale shows" in reason]
    assert "8 kg" in reason
    assert "sigma apart" in reason
    assert all(estimate.weighings[0].conflict for estimate in answer.constrained)


def test_no_body_at_all_is_an_error_that_names_the_constraints(problem: LongMotion) -> None:
    apart = [
        InEllipsoid([0.0, 0.0, -0.5], [0.1] * 3),
        CentreOfMassInBox([0.0] * 3, [0.3] * 3),
        MassBounds(5.0, 9.0),
    ]
    with pytest.raises(SolverError, match="no body holds all constraints") as caught:
        answer_payload(problem, constraints=apart)
    for constraint in apart:
        assert constraint.description in str(caught.value)


@pytest.mark.long
def test_a_true_constraint_is_rarely_called_a_conflict(problem: LongMotion, payload: InertialParameters) -> None:
    """A mass bound at the very truth contradicts 1 % of the data at most."""
    model = error_model(answer_payload(problem, methods=(4,)).estimates[0].estimate)
    draw = np.random.default_rng(0)
    root = np.linalg.cholesky(model.covariance)
    called = 0
    for _ in range(300):
        scale = draw.chisquare(model.degrees_of_freedom) / model.degrees_of_freedom
        values = payload.vector + root @ draw.standard_normal(10)
        sample = replace(model, values=values, covariance=scale * model.covariance)
        rules: list[Constraint] = [PossibleBody(), MassBounds(high=payload.mass)]
        called += any(test.conflict for test in possible_payload.tested(solve_constrained(sample, rules)))
    assert called <= 6


def test_ur10e(recordings: Path) -> None:
    """The real pair: no conflict, and with 2 % per joint every method's interval holds the weighed 2.805 kg.

    All rows, friction the same under load, no tilt: as its figures were established independently.
    """
    robot, gains = load_robot("ur10e"), (11.976, 11.976, 9.839, 10.763, 10.757, 10.680)
    loaded, bare = (
        read_recording(recordings / "ur10e" / f"{name}.csv.gz", robot, gains)
        for name in ("loaded_2.805kg", "unloaded")
    )
    every_row = replace(robot.processing, slow_speed=0.0)
    problem = payload_problem(
        robot, [loaded], [bare], settings=Settings(every_row, friction_change=0.0, friction=PAPER)
    )
    plain = constrain_payload(payload_estimate(problem, 3))  # without a tilt's share of the covariance
    assert plain.body.first_moments == pytest.approx([0.083, 0.476, 0.137], abs=0.001)
    answer = answer_payload(problem, gains=Gains((0.02,)))
    for estimate in answer.constrained:
        low, high = estimate.intervals.parameters[9]
        assert low < 2.805 < high
        assert high - low < 0.21
        assert estimate.p_value > 0.5
        assert not estimate.conflict
        assert estimate.mass == pytest.approx(2.792, abs=0.01)
