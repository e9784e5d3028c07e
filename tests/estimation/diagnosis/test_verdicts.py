"""What checks say together: levels, causes, and what is reported once."""

from dataclasses import replace

import numpy as np
import pytest
from dynident.estimation.diagnosis import loaded_rows
from dynident.estimation.diagnosis import nuisances as beside_both
from dynident.estimation.diagnosis.checks import joints, loaded, nuisances, recordings
from dynident.estimation.diagnosis.checks import robot as rival_checks
from dynident.estimation.diagnosis.evidence import Evidence
from dynident.estimation.diagnosis.finding import Finding, Verdict, error, verdict_of, warning
from dynident.estimation.diagnosis.loaded_rows import Scale
from dynident.estimation.diagnosis.nuisances import Tilt
from dynident.estimation.diagnosis.quantities import COM_FLOOR, Agreement, Judged, allowing, judge_com
from dynident.estimation.diagnosis.rivals import Rival
from dynident.estimation.diagnosis.search import SERIOUS, Cause
from dynident.estimation.diagnosis.verdict import judge, robot_verdict
from dynident.estimation.fit.estimate import Fit
from dynident.estimation.payload.by_joints import ByJoints, JointShare, JointsMass
from dynident.estimation.possible.constraints import PossibleBody
from dynident.model import Robot
from dynident.model.inertia import PayloadSpread
from dynident.tests.estimation.diagnosis.made import (
    BODY,
    ROBOT,
    SOURCE,
    active,
    by_masses,
    estimate_of,
    of_payload,
    of_possible,
    of_weighing,
    robot_of,
    spread_of,
    with_mass,
)
from dynident.tests.estimation.diagnosis.sides import beside, hose, leaning, pulling, rival, scaled
from dynident.tests.estimation.diagnosis.sides import one_cause as one_cause
from hypothesis import given
from hypothesis import strategies as st


def test_good_evidence_is_used() -> None:
    good = of_payload(
        estimate_of(1), estimate_of(3), estimate_of(4), parameters=robot_of(), condition=10.0, source=SOURCE
    )
    assert judge(good).level == "use"
    assert judge(of_weighing()).level == "use"
    assert judge(good).reasons == judge(of_weighing()).reasons == ()


def test_bounds_that_hold_the_answer_are_told_and_possibility_is_not() -> None:
    for evidence in (of_possible(active(0.5)), of_weighing(active(0.5))):
        assert judge(evidence).reasons == ("the answer is held at a bound that was given: mass from 0 to 4.9 kg",)
        assert judge(evidence).level == "mass_and_com_only"
    for evidence in (of_possible(active(0.5, PossibleBody())), of_weighing(active(0.5, PossibleBody()))):
        assert judge(evidence).level == "use"


def test_one_conflict_is_told_once_and_not_as_a_bound() -> None:
    (reason,) = judge(of_possible(active(1e-3), active(1e-3))).reasons
    assert "contradict the constraint" in reason
    (reason,) = judge(of_weighing(active(1e-3))).reasons
    assert "the torques contradict" in reason


def test_a_scale_leaves_nothing_to_say_of_the_sign() -> None:
    assert judge(of_weighing(mass=0.0, from_scale=True)).level == "use"


def test_a_way_that_only_shows_frictions_part_does_not_count() -> None:
    way = Agreement("friction not freed", 9.0, np.full(3, np.nan), counts=False)
    assert judge(of_weighing(agreement=(way,))).level == "use"


def test_few_blocks_widen_what_joints_of_a_weighing_show() -> None:
    """0.6 kg are 6 standard deviations, but one degree of freedom makes them one."""
    many = by_masses((5.6, 0.1))
    few = replace(many, masses=tuple(replace(group, degrees_of_freedom=1.0) for group in many.masses))
    assert judge(of_weighing(by_joints=many)).level == "do_not_use"
    assert judge(of_weighing(by_joints=few)).level == "use"
    assert judge(of_payload(estimate_of(), by_joints=few)).level == "do_not_use"


def test_hidden_and_unknown_quantities() -> None:
    """What joints do not show is not visible; a payload of unknown size has 20 mm."""
    unknown = np.full(10, np.nan)
    for sigma, use in ((0.999 * COM_FLOOR, "use"), (1.001 * COM_FLOOR, "not measured well enough")):
        assert judge_com(unknown, PayloadSpread(0.01, np.full(3, sigma), np.eye(3))).use == use
    hidden = judge_com(BODY.vector, PayloadSpread(0.01, np.array([0.0, np.inf, 0.0]), np.eye(3)))
    assert hidden == Judged("not visible", "these joints do not show y")


def test_causes_are_looked_for_where_something_contradicts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Then a smaller gain is told as well."""
    flags: list[bool] = []

    def causes(_: Robot, __: object, contradicted: bool, apart: bool) -> tuple[Cause, ...]:
        flags.append(contradicted)
        return ()

    monkeypatch.setattr(recordings, "likely_causes", causes)
    for evidence in (of_payload(estimate_of(), source=SOURCE), of_payload(estimate_of(left=0.2), source=SOURCE)):
        judge(evidence)
    judge(of_payload(estimate_of(ten=with_mass(-5.0)), source=SOURCE))
    assert flags == [False, True]


def test_a_cause_is_serious_where_it_explains_half() -> None:
    for after, severity in ((1.001 * SERIOUS, "warning"), (0.999 * SERIOUS, "error")):
        finding = Cause("L", "q1 is late", 1.0, after).finding("It")
        assert (finding.severity, finding.about, finding.cause) == (severity, "L", True)
        assert finding.text.startswith("It looks as if q1 is late: corrected for it")


def test_the_scale_of_all_and_that_of_a_joint_are_told_where_either_may_be() -> None:
    """A joint's z of 10, and that of all on both sides of the share from which it explains them as well."""
    for z, words in ((0.999, "joint 4's torques with payload"), (1.001, "all torques, or joint 4's alone, with")):
        whole = Scale(0, 0.9, 0.1 / (10.0 * z * loaded.EITHER), 5.5)
        (finding,) = loaded.scale(of_payload(estimate_of(), scales=(whole, Scale(4, 1.1, 0.01, 4.5))))
        assert finding.text.startswith(words)
    assert "0.900 ± 0.015 or 1.100 ± 0.01 times" in finding.text
    assert "5.5 or 4.5 kg" in finding.text


def test_a_tilt_that_does_not_stand_out_moves_nothing() -> None:
    """But its mean square is in the covariance; one that does is taken out as far as it is believed."""
    effects = np.eye(10)[:, :2], np.zeros((10, 2))
    for share, moved in ((0.999, False), (1.001, True)):
        values = np.array([0.6, 0.8]) * share * beside_both.TILT
        lean = Tilt(values, 1e-8 * np.eye(2), effects)
        change, covariance = lean.change(4)
        assert change[:2] == pytest.approx(values if moved else 0.0, rel=1e-3)
        square = values[0] ** 2 * (not moved)
        assert covariance[0, 0] == pytest.approx(square + 1e-8, rel=1e-3)
        assert not lean.change(3)[0].any()


def test_a_tilt_that_no_mounting_has_leaves_nothing() -> None:
    for angle, severity in ((0.999 * nuisances.STEEP, "note"), (1.001 * nuisances.STEEP, "error")):
        (finding,) = nuisances.tilted(leaning(angle))
        assert finding.severity == severity


def test_a_pull_that_leaves_the_mass_as_it_is_speaks_against_the_inertia_alone() -> None:
    """The change of the mass and twice its deviation count: 5 kg (x + 2 x / 9) beside 2.5 % of 5 kg."""
    for share, severity in ((0.999, "warning"), (1.001, "error")):
        change = share * loaded.MOVED / (1.0 + 2.0 / 9.0)
        (finding,) = nuisances.pulled(pulling(1.0, change=change))
        assert finding.severity == severity


def test_what_a_pull_explains_better_is_not_told() -> None:
    """A scale by fewer deviations, a robot and a turned joint that take off half; the next robot is no matter."""
    for evidence, check in (
        (scaled(0, 0.1, 0.1 / 8.9), loaded.scale),
        (rival("robot", "ur5e", 0.049), rival_checks.other_robots),
        (rival("robot", "ur5e", 0.0), rival_checks.other_robots),
        (rival("turned", "5", 0.049), rival_checks.turned_joints),
    ):
        assert check(evidence)
        assert not check(replace(evidence, pulls=(hose(1.0),)))
        assert check(replace(evidence, pulls=(hose(1.0, z=0.5),)))
    for evidence, check in (
        (scaled(0, 0.1, 0.1 / 9.1), loaded.scale),
        (rival("robot", "ur5e", 0.051), rival_checks.other_robots),
        (rival("turned", "5", 0.051), rival_checks.turned_joints),
    ):
        assert check(replace(evidence, pulls=(hose(1.0),)))


def test_a_delay_that_moves_the_mass_leaves_nothing() -> None:
    for change, severity in ((0.999 * loaded.MOVED, "warning"), (1.001 * loaded.MOVED, "error")):
        (finding,) = nuisances.late(beside("late", 0.02, change=change))
        assert finding.severity == severity
    assert "the mass is 5.13 kg" in finding.text


def test_what_is_mixed_up_is_looked_for_where_a_guard_is_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    """And told on both sides of its thresholds."""
    tried = Rival("mixed up", "joints 2 and 3 are exchanged", rival_checks.TURNED, rival_checks.TURNED_Z)
    for fall, z, count in ((1.001, 1.001, 1), (0.999, 1.001, 0), (1.001, 0.999, 0)):
        mixture = tried._replace(fall=fall * tried.fall, z=z * tried.z)
        monkeypatch.setattr(nuisances, "mixed_up", lambda *_, mixture=mixture: (mixture,))
        evidence = of_payload(estimate_of(), source=SOURCE)
        assert len(nuisances.mixtures(evidence, ["scale"])) == count
        assert nuisances.mixtures(evidence, ["other_robots"]) == []
        assert nuisances.mixtures(of_payload(estimate_of()), ["scale"]) == []


def test_the_verdict_on_a_robot() -> None:
    def verdict_of_fit(left: float) -> Verdict:
        return robot_verdict(Evidence(ROBOT, parameters=robot_of(left)))

    assert verdict_of_fit(0.999 * recordings.RESIDUAL).level == "use"
    verdict = verdict_of_fit(1.001 * recordings.RESIDUAL)
    assert verdict.level == "do_not_use"
    assert verdict.reasons[0].startswith("the model leaves 25 %")


def test_what_is_told_of_findings() -> None:
    """Against all first; of the rest, where nothing may be used, only causes unless all is asked for."""
    bad, vague, cause = error("bad"), warning("vague"), Finding("warning", "log", "cause", cause=True)
    note = Finding("note", "time", "uneven")
    assert verdict_of([note]).level == "use"
    assert verdict_of([note]).notes == ("uneven",)
    assert verdict_of([vague, vague, note]).reasons == ("vague",)
    assert verdict_of([vague, cause]).level == "mass_and_com_only"
    assert verdict_of([vague, cause, bad]).reasons == ("cause", "bad")
    assert verdict_of([vague, bad, cause], brief=False).reasons == ("bad", "cause", "vague")
    assert verdict_of([vague, bad]).level == "do_not_use"


def test_what_explains_most_comes_first_and_what_it_outdoes_is_not_told() -> None:
    """A turned joint may look like another robot; a cause in one recording stands beside one of all."""

    def cause(about: str, text: str, explains: float) -> Finding:
        return Finding("error", about, text, cause=True, explains=explains)

    turned, robot = cause("everything", "turned", 0.9), cause("everything", "robot", 0.8)
    assert verdict_of([robot, turned]).reasons == ("turned",)
    assert verdict_of([robot._replace(explains=0.86), turned]).reasons == ("turned", "robot")
    late = cause("loaded.csv", "late", 0.3)
    assert verdict_of([late, error("bad"), turned]).reasons == ("turned", "late", "bad")
    assert verdict_of([late._replace(explains=0.9), turned]).reasons == ("turned", "late")
    alike = late._replace(severity="warning", explains=0.5)  # too little to be told first: it outdoes nothing
    assert verdict_of([alike, robot._replace(explains=0.2)]).reasons == ("robot", "late")


def test_few_blocks_widen_what_every_quantity_is_judged_by() -> None:
    """Half of a 95 % interval over 1.96: 12.7 over 1.96 with one degree of freedom."""
    plain = PayloadSpread(0.02, np.array([1e-3, 2e-3, 3e-3]), np.full((3, 3), 4e-4))
    wide = allowing(plain, 1.0)
    for name in ("mass", "com", "inertia_com"):
        assert getattr(wide, name) == pytest.approx(12.7062 / 1.95996 * getattr(plain, name), rel=1e-5)
    same = allowing(plain, 1e9)
    assert same.com == pytest.approx(plain.com)


_SHARES = st.floats(0.5, 1.5)
_MASSES = st.floats(4.0, 6.0)


@given(
    shares=st.lists(_SHARES, min_size=2, max_size=5),
    masses=st.lists(_MASSES, max_size=4),
    sigma=st.floats(1e-3, 0.3),
    scale=st.floats(0.9, 1.1),
    factor=st.floats(1.0, 4.0),
    fall=st.floats(-0.1, 0.1),
    left=st.floats(0.02, 0.3),
)
def test_no_reason_speaks_against_a_mass_that_may_be_used(
    shares: list[float], masses: list[float], sigma: float, scale: float, factor: float, fall: float, left: float
) -> None:
    """Whatever is made up: what is said of the mass, or of everything, leaves nothing to be used."""
    by_joints = ByJoints(
        tuple(JointsMass((j,), mass, sigma) for j, mass in enumerate(masses, 2)),
        tuple(JointShare(j, share, sigma) for j, share in enumerate(shares, 2)),
    )
    verdict = judge(
        of_payload(
            estimate_of(left=left),
            by_joints=by_joints,
            disagreement=factor,
            scales=(Scale(0, scale, sigma / 10.0, 5.0),),
            rivals=(Rival("robot", "ur5e", fall, 100.0 * fall), Rival("turned", "2", fall, 100.0 * fall)),
            spread=spread_of(sigma),
        )
    )
    reasons = [finding for finding in verdict.findings if finding.severity != "note"]
    if verdict.level != "do_not_use":
        assert all(finding.about not in ("mass", "everything") for finding in reasons)
        assert all(abs(share - 1.0) <= max(joints.SHARE, joints.SIGMAS * sigma) for share in shares)
        assert abs(scale - 1.0) <= max(loaded_rows.SCALE, loaded_rows.SCALE_Z * sigma / 10.0)


def test_a_joint_without_torque_is_judged_by_noise() -> None:
    """A joint's own norm says nothing here: what it leaves is as little as any torque's noise."""
    rows = (100, 100, 100)
    little = Fit(np.array([10.0, 8.0, 1.9]), np.array([200.0, 150.0, 2.0]), rows)
    much = Fit(np.array([10.0, 8.0, 2.1]), np.array([200.0, 150.0, 2.0]), rows)
    assert not recordings.fit_findings(little, "it")
    assert [finding.severity for finding in recordings.fit_findings(much, "it")] == ["error"]
    assert "joint 3" in recordings.fit_findings(much, "it")[0].text
