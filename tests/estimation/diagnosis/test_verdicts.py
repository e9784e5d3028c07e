"""What checks say together: levels, causes, and what is reported once."""

from dataclasses import replace

import numpy as np
import pytest
from dynident.estimation.diagnosis import causes, checks, hypotheses, joints, scales
from dynident.estimation.diagnosis import verdict as table
from dynident.estimation.diagnosis.checks import COM_FLOOR, allowing, judge_com
from dynident.estimation.diagnosis.evidence import Agreement, Alternative, Evidence, Judged
from dynident.estimation.diagnosis.finding import Finding, error, verdict_of, warning
from dynident.estimation.diagnosis.verdict import judge
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
from dynident.tests.estimation.diagnosis.sides import (
    beside,
    hose,
    lean_of,
    leaning,
    pulling,
    rival,
    scale_of,
    scaled,
)
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

    def likely(_: Robot, __: object, contradicted: bool, free_gains: bool) -> list[Finding]:
        flags.append(contradicted)
        return []

    monkeypatch.setattr(table, "likely_causes", likely)
    for evidence in (of_payload(estimate_of(), source=SOURCE), of_payload(estimate_of(left=0.2), source=SOURCE)):
        judge(evidence)
    judge(of_payload(estimate_of(ten=with_mass(-5.0)), source=SOURCE))
    assert flags == [False, True]


def test_the_scale_of_all_and_that_of_a_joint_are_told_where_either_may_be() -> None:
    """A joint's z of 10, and that of all on both sides of the share from which it explains them as well."""
    for z, words in ((0.999, "joint 4's torques with payload"), (1.001, "all torques, or joint 4's alone, with")):
        whole = scale_of(0, 0.1, 0.1 / (10.0 * z * scales.EITHER), 4.5)
        (finding,) = scales.scale(of_payload(estimate_of(), scales=(whole, scale_of(4, -0.1, 0.01, 5.5))))
        assert finding.text.startswith(words)
    assert "0.900 ± 0.015 or 1.100 ± 0.01 times" in finding.text
    assert "5.5 or 4.5 kg" in finding.text


def test_a_tilt_that_does_not_stand_out_moves_nothing() -> None:
    """But its mean square is in the covariance; one that does is taken out as far as it is believed."""
    for share, moved in ((0.999, False), (1.001, True)):
        lean = lean_of(share * hypotheses.TILT, 1e-4, np.eye(10)[:, :2])
        change, covariance = hypotheses.tilt_correction(lean, 4)
        assert change[:2] == pytest.approx(lean.values if moved else 0.0, rel=1e-3)
        square = lean.values[0] ** 2 * (not moved)
        assert covariance[0, 0] == pytest.approx(square + 1e-8, rel=1e-3)
        assert not hypotheses.tilt_correction(lean, 3)[0].any()


def test_a_tilt_that_no_mounting_has_leaves_nothing() -> None:
    for angle, severity in ((0.999 * hypotheses.STEEP, "note"), (1.001 * hypotheses.STEEP, "error")):
        (finding,) = hypotheses.hypotheses(leaning(angle))
        assert finding.severity == severity


def test_a_pull_that_leaves_the_mass_as_it_is_speaks_against_the_inertia_alone() -> None:
    """The change of the mass and twice its deviation count: 5 kg (x + 2 x / 9) beside 2.5 % of 5 kg."""
    for share, severity in ((0.999, "warning"), (1.001, "error")):
        change = share * hypotheses.MOVED / (1.0 + 2.0 / 9.0)
        (finding,) = hypotheses.hypotheses(pulling(1.0, change=change))
        assert finding.severity == severity


def test_what_a_pull_explains_better_is_not_told() -> None:
    """A scale by fewer deviations, a robot and a turned joint that take off half; the next robot is no matter."""

    def hung(evidence: Evidence, z: float = 9.0) -> Evidence:
        return replace(evidence, diagnosis=replace(evidence.diagnosis, effects=(hose(1.0, z=z),)))

    for evidence, check in (
        (scaled(0, 0.1, 0.1 / 8.9), scales.scale),
        (rival("robot", "ur5e", 0.049), causes.other_readings),
        (rival("robot", "ur5e", 0.0), causes.other_readings),
        (rival("turned", "5", 0.049), causes.other_readings),
    ):
        assert list(check(evidence))
        assert not list(check(hung(evidence)))
        assert list(check(hung(evidence, 0.5)))
    for evidence, check in (
        (scaled(0, 0.1, 0.1 / 9.1), scales.scale),
        (rival("robot", "ur5e", 0.051), causes.other_readings),
        (rival("turned", "5", 0.051), causes.other_readings),
    ):
        assert list(check(hung(evidence)))


def test_another_robot_must_explain_more_than_more_friction_does() -> None:
    """One further friction column a joint on the robot as described."""
    for fall, count in ((0.019, 1), (0.021, 0)):
        both = (Alternative("robot", "ur5e", 0.02, 9.0), Alternative("friction", "", fall, 0.0))
        findings = causes.other_readings(of_payload(estimate_of(), alternatives=both))
        assert sum("it is a recording of robot" in finding.text for finding in findings) == count
        assert sum("do not tell" in finding.text for finding in findings) == 1 - count


def test_a_delay_that_moves_the_mass_leaves_nothing() -> None:
    for change, severity in ((0.999 * hypotheses.MOVED, "warning"), (1.001 * hypotheses.MOVED, "error")):
        (finding,) = hypotheses.hypotheses(beside("late", 0.02, change=change))
        assert finding.severity == severity
    assert "the mass is 5.13 kg" in finding.text


def test_the_verdict_on_a_robot() -> None:
    assert judge(Evidence(ROBOT, parameters=robot_of(0.999 * checks.RESIDUAL))).level == "use"
    verdict = judge(Evidence(ROBOT, parameters=robot_of(1.001 * checks.RESIDUAL)))
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


def test_a_fault_that_takes_off_little_comes_last_and_a_pull_first() -> None:
    """A slip is a cause from a tenth of the squared residual on."""
    wrong = with_mass(-5.0)
    for name, fall, first in (("slip", 0.099, False), ("slip", 0.101, True), ("pull", 0.01, True)):
        evidence = pulling(1.0) if name == "pull" else beside("slip", 0.05)
        effect = evidence.diagnosis.effects[0]._replace(fall=fall)
        reasons = judge(of_payload(estimate_of(ten=wrong), effects=(effect,))).reasons
        told = [("pulls at the flange" in text or "did it slip" in text) for text in reasons]
        assert told.index(True) == (0 if first else len(reasons) - 1)


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
            scales=(scale_of(0, 1.0 - scale, sigma / 10.0),),
            alternatives=(
                Alternative("robot", "ur5e", fall, 100.0 * fall),
                Alternative("turned", "2", fall, 100.0 * fall),
            ),
            spread=spread_of(sigma),
        )
    )
    reasons = [finding for finding in verdict.findings if finding.severity != "note"]
    if verdict.level != "do_not_use":
        assert all(finding.about not in ("mass", "everything") for finding in reasons)
        assert all(abs(share - 1.0) <= max(joints.SHARE, joints.SIGMAS * sigma) for share in shares)
        assert abs(scale - 1.0) <= max(scales.SCALE, scales.SCALE_Z * sigma / 10.0)


def test_a_joint_without_torque_is_judged_by_noise() -> None:
    """A joint's own norm says nothing here: what it leaves is as little as any torque's noise."""
    rows = (100, 100, 100)
    little = Fit(np.array([10.0, 8.0, 1.9]), np.array([200.0, 150.0, 2.0]), rows)
    much = Fit(np.array([10.0, 8.0, 2.1]), np.array([200.0, 150.0, 2.0]), rows)
    assert not list(checks.fit_findings(little, "it"))
    (finding,) = checks.fit_findings(much, "it")
    assert (finding.severity, "joint 3" in finding.text) == ("error", True)
