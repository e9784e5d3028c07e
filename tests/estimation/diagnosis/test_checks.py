"""Each check of the table alone, on both sides of each of its thresholds."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from dynident.estimation.diagnosis import loaded_rows
from dynident.estimation.diagnosis import nuisances as beside_both
from dynident.estimation.diagnosis.checks import gains, joints, loaded, nuisances, payload, recordings
from dynident.estimation.diagnosis.checks import robot as rival_checks
from dynident.estimation.diagnosis.evidence import KNOWN_WELL, Evidence, Gained, KnownWeight
from dynident.estimation.diagnosis.finding import Finding, Verdict, error, verdict_of, warning
from dynident.estimation.diagnosis.loaded_rows import Scale
from dynident.estimation.diagnosis.nuisances import Bursts, Nuisance, Tilt
from dynident.estimation.diagnosis.quantities import (
    COM_FLOOR,
    COM_SIGMA,
    INERTIA_SIGMA,
    MASS_SIGMA,
    Agreement,
    Judged,
    allowing,
    judge_com,
)
from dynident.estimation.diagnosis.rivals import Rival
from dynident.estimation.diagnosis.search import SERIOUS, Cause
from dynident.estimation.diagnosis.verdict import BEFOREHAND, CHECKS, judge, robot_verdict
from dynident.estimation.fit.estimate import Estimate, Fit
from dynident.estimation.payload.by_joints import ByJoints, JointShare, JointsMass
from dynident.estimation.possible.constraints import PossibleBody
from dynident.estimation.possible.result import CONFLICT
from dynident.estimation.signals import alignment
from dynident.estimation.signals.alignment import AlignedPair
from dynident.model import Recording, Robot
from dynident.model.inertia import PayloadSpread
from dynident.tests.estimation.diagnosis.made import (
    BODY,
    MOMENTS,
    ROBOT,
    SIZE,
    SOURCE,
    active,
    by_masses,
    by_share,
    com_sigma,
    drift_of,
    drifting,
    estimate_of,
    held_out,
    in_time,
    inertia_sigma,
    mismatched,
    of_payload,
    of_possible,
    of_spread,
    of_weighing,
    one_joint,
    possible_of,
    robot_of,
    spread_of,
    two_masses,
    weighed_as,
    with_mass,
)
from hypothesis import given
from hypothesis import strategies as st

ONE_PERCENT = 2.5758
"""Standard deviations that a difference exceeds with a probability of 1 %."""
FIVE_PERCENT = 2.7764
"""Quantile of Student's t of 4 degrees of freedom that is exceeded, of either sign, with one of 5 %."""
OWN = float(MOMENTS.sum()) / 2.0


class Side(NamedTuple):
    """A threshold: evidence made of a number, the limit that is wrong to exceed, and what is then said."""

    check: str
    severity: str
    words: str
    make: Callable[[float], Evidence]
    limit: float
    below: bool = False
    """Whether it is wrong to stay below it."""


def rival(kind: str, name: str, fall: float, z: float = 9.0) -> Evidence:
    """Another way to take the recordings."""
    return of_payload(estimate_of(), rivals=(Rival(kind, name, fall, z),))


def scaled(joint: int, off: float, sigma: float) -> Evidence:
    """Torques with payload on another scale."""
    return of_payload(estimate_of(), scales=(Scale(joint, 1.0 - off, sigma, 5.5),))


def leaning_on(change: float, sigma: float) -> Evidence:
    """A mass, known to ``sigma`` [kg], that changes by so much [kg] with 1 % of the loaded torques' scale."""
    spread = PayloadSpread(sigma, np.full(3, 1e-3), np.full((3, 3), 1e-4))
    return of_payload(estimate_of(), scales=(Scale(0, 1.0, 0.01, 5.0, 100.0 * change),), spread=spread)


def leaning(angle: float, sigma: float = 1e-4) -> Evidence:
    """Gravity that leans by an angle [rad]."""
    effects = np.zeros((10, 2)), np.zeros((10, 2))
    return of_payload(estimate_of(), tilt=Tilt(np.array([0.6, 0.8]) * angle, sigma**2 * np.eye(2), effects))


def beside(kind: str, size: float, z: float = 9.0, change: float = 0.0) -> Evidence:
    """Something else in the torques, that changes the mass by a share."""
    found = Nuisance(kind, " with payload", size, abs(size) / z, z, 5.0 * change * np.eye(10)[9])
    return of_payload(estimate_of(), nuisances=(found,))


def apart(constant: float, changing: float = 0.0, other: float = 0.0) -> Evidence:
    """A pair whose third joint differs by a constant, and another one by something that changes [rad]."""
    t = np.linspace(0.0, 1.0, 50)
    bare, heavy = (Recording(t, np.zeros((50, 6)), np.zeros((50, 6)), source=name) for name in ("U", "L"))
    pair = AlignedPair(
        bare, heavy, 0.0, 0.1, 0.1, (0.0, 0.0, constant, 0.0, 0.0, 0.0), (0.0, 0.0, changing, other, 0.0, 0.0)
    )
    return Evidence(ROBOT, compared=(pair,))


def weighing_arm(share: float) -> Evidence:
    """An RX90 whose torques show this share of its weight."""
    moment = share * ROBOT_MASS * sum(float(np.hypot(joint.d, joint.r)) for joint in ROBOT.joints[1:])
    names, values = ("MX2", "MY2", "MX3", "MY3"), np.array([0.6 * moment, 0.0, 0.0, 0.4 * moment])
    parameters = Estimate(names, values, np.eye(4), 500.0, robot_of().fit, np.ones(6))
    return of_payload(estimate_of(), parameters=parameters)


ROBOT_MASS = 111.0
DRIFT = drift_of(9.0)


def _weighed(agreement: float) -> Evidence:
    way = Agreement("other way", 5.0 * (1.0 + agreement), np.full(3, np.nan))
    return of_weighing(agreement=(way,))


def of_motor(off: float, sigma: float) -> Evidence:
    """A third motor whose currents with payload are too small by a share."""
    return Evidence(ROBOT, gained=Gained(np.full(3, 0.01), ()), scales=(Scale(3, 1.0 - off, sigma, 5.5),))


def of_weights(ratio: float, sigma: float) -> Evidence:
    """Two weights, the first of which weighs ``ratio`` times as much as was told, to ``sigma``."""
    weights = (KnownWeight(1, 2.0, 2.0 * ratio, 2.0 * ratio * sigma), KnownWeight(2, 4.0, 4.0, 1e-9))
    return Evidence(ROBOT, gained=Gained(np.full(3, 0.01), weights))


SIDES = (
    Side(
        "residual",
        "error",
        "payload leaves 25 %",
        lambda x: Evidence(ROBOT, parameters=robot_of(x)),
        recordings.RESIDUAL,
    ),
    Side(
        "residual",
        "error",
        "50 % of the torque of joint 3",
        lambda x: Evidence(ROBOT, parameters=robot_of(one_joint(x))),
        recordings.JOINT_RESIDUAL,
    ),
    Side(
        "residual",
        "error",
        "method 4 leaves 25 % of the torque unexplained",
        lambda x: of_payload(estimate_of(left=x), parameters=robot_of(0.2)),
        recordings.RESIDUAL,
    ),
    Side(
        "residual",
        "error",
        "of the torque with payload",
        lambda x: of_payload(estimate_of(left=0.05 * x), parameters=robot_of(0.05)),
        recordings.LOADED_RATIO,
    ),
    Side(
        "residual",
        "error",
        "of the torque with payload",
        lambda x: of_payload(estimate_of(left=0.01 * x), parameters=robot_of(0.001)),
        recordings.LOADED_RATIO,
    ),
    Side(
        "validation",
        "warning",
        "does not carry over",
        lambda x: held_out(0.05 * x, 0.05),
        recordings.VALIDATION_RATIO,
    ),
    Side("validation", "warning", "does not carry over", lambda x: held_out(x, 0.01), recordings.VALIDATION_FLOOR),
    Side("validation", "error", "does not carry over", lambda x: held_out(x, 0.1), recordings.RESIDUAL),
    Side(
        "friction",
        "error",
        "friction of joint 2 comes out negative",
        lambda x: Evidence(ROBOT, parameters=robot_of(friction=(-9.0, x))),
        -recordings.DRIVEN_SIGMAS,
    ),
    Side(
        "friction",
        "error",
        "friction of joint 2 comes out negative",
        lambda x: Evidence(ROBOT, parameters=robot_of(friction=(x, -9.0))),
        -recordings.DRIVEN_SIGMAS,
    ),
    Side(
        "sign",
        "error",
        "gives a negative mass",
        lambda x: of_payload(estimate_of(ten=with_mass(0.01 * x))),
        -payload.SIGMAS,
    ),
    Side(
        "sign",
        "error",
        "does not differ from zero",
        lambda x: of_payload(estimate_of(ten=with_mass(0.01 * x))),
        payload.SIGMAS,
        True,
    ),
    Side("weighed_sign", "error", "mass is negative", lambda x: of_weighing(mass=0.01 * x), -payload.SIGMAS),
    Side(
        "weighed_sign",
        "error",
        "does not differ from zero",
        lambda x: of_weighing(mass=0.01 * x),
        payload.SIGMAS,
        True,
    ),
    Side(
        "methods_apart",
        "error",
        "masses spread from 5 to",
        lambda x: two_masses(5.0 * x / (1.0 - x / 2.0)),
        payload.MASS_SPREAD,
    ),
    Side(
        "methods_apart",
        "error",
        "methods 1 and 3 disagree",
        lambda x: two_masses(5.0 * x / (1.0 - x / 2.0)),
        payload.APART,
    ),
    Side(
        "methods_apart",
        "error",
        "methods 1 and 3 disagree",
        lambda x: two_masses(x * float(np.hypot(0.03, 0.03)), 0.03),
        payload.SIGMAS,
    ),
    Side(
        "rating",
        "error",
        "more than the 12 kg that this arm carries",
        lambda x: of_payload(estimate_of(ten=with_mass(1.02 * 12.0 + 0.01 * x))),
        payload.TOLD,
    ),
    Side(
        "uncertain",
        "error",
        "leaves the mass uncertain by 5 %",
        lambda x: of_payload(estimate_of(sigma=np.full(10, 5.0 * x))),
        MASS_SIGMA,
    ),
    Side(
        "uncertain", "error", "centre of mass uncertain by 20 mm along x", lambda x: com_sigma(x, 0.01), COM_FLOOR
    ),
    Side(
        "uncertain",
        "error",
        "centre of mass uncertain by 60 mm along x",
        lambda x: com_sigma(0.2 * x, 0.2),
        COM_SIGMA,
    ),
    Side("judged_mass", "error", "mass: 1 sigma", lambda x: of_spread(mass=5.0 * x), MASS_SIGMA),
    Side(
        "judged_com_and_inertia",
        "error",
        "centre of mass: not measured",
        lambda x: of_spread(com=SIZE * x),
        COM_SIGMA,
    ),
    Side(
        "judged_com_and_inertia",
        "warning",
        "inertia: not measured",
        lambda x: of_spread(inertia=float(MOMENTS[2]) * x),
        INERTIA_SIGMA,
    ),
    Side(
        "unexplained",
        "error",
        "50 % of the torque of joint 3",
        lambda x: of_weighing(unexplained=one_joint(x)),
        recordings.JOINT_RESIDUAL,
    ),
    Side(
        "joints",
        "error",
        "joint 2 5.5",
        lambda x: of_payload(estimate_of(), by_joints=by_masses((5.0 + 5.0 * x, 0.001))),
        joints.WRONG,
    ),
    Side(
        "joints",
        "error",
        "joint 2 5.9",
        lambda x: of_payload(estimate_of(), by_joints=by_masses((5.0 + 0.2 * x, 0.2))),
        joints.SIGMAS,
    ),
    Side(
        "joints",
        "error",
        "joint 2 5 ± 0.001 kg, joint 3 5.15",
        lambda x: of_payload(estimate_of(), by_joints=by_masses((5.0, 0.001), (5.0 + 5.0 * x, 0.001))),
        joints.NOTABLE,
    ),
    Side(
        "joints",
        "warning",
        "joint 2 5 ± 0.03 kg, joint 3 5.17",
        lambda x: of_payload(estimate_of(), by_joints=by_masses((5.0, 0.03), (5.0 + 0.05 * x, 0.04))),
        joints.NOTABLE_SIGMAS,
    ),
    Side(
        "joints",
        "error",
        "joint 2 4.86 ± 0.01 kg, joint 3 5.15",
        lambda x: of_payload(
            estimate_of(),
            by_joints=by_masses((4.86, 0.01), (5.1 + 0.01 * x, 0.01)),
            spread=spread_of(0.1 / 1.96),
        ),
        joints.SIGMAS,
    ),
    Side(
        "joints",
        "error",
        "joint 3 shows 1.15",
        lambda x: of_payload(estimate_of(), by_joints=by_share(1.0 + x)),
        joints.SHARE,
    ),
    Side(
        "joints",
        "error",
        "joint 3 shows 0.85",
        lambda x: of_payload(estimate_of(), by_joints=by_share(1.0 - x)),
        joints.SHARE,
    ),
    Side(
        "joints",
        "error",
        "joint 3 shows 1.23",
        lambda x: of_payload(estimate_of(), by_joints=by_share(1.0 + 0.05 * x, 0.05)),
        joints.SIGMAS,
    ),
    Side(
        "shares_together",
        "note",
        "every interval is widened",
        lambda x: of_payload(estimate_of(), disagreement=x),
        joints.TOGETHER,
    ),
    Side(
        "shares_together",
        "error",
        "that of joint 3 over 5 % off",
        lambda x: of_payload(estimate_of(), by_joints=by_share(1.06, 0.05), disagreement=x),
        joints.TOO_FAR,
    ),
    Side(
        "shares_together",
        "error",
        "that of joint 3 over 5 % off",
        lambda x: of_payload(estimate_of(), by_joints=by_share(1.0 + x, 0.05), disagreement=3.0),
        joints.CARRIED,
    ),
    Side("scale", "error", "the torques with payload", lambda x: scaled(0, x, 0.0), loaded_rows.SCALE),
    Side("scale", "error", "the torques with payload", lambda x: scaled(0, 0.1 * x, 0.1), loaded_rows.SCALE_Z),
    Side("scale", "error", "joint 3's torques with payload", lambda x: scaled(3, x, 0.0), loaded_rows.JOINT_SCALE),
    Side(
        "scale",
        "error",
        "joint 3's torques with payload",
        lambda x: scaled(3, 0.1 * x, 0.1),
        loaded_rows.JOINT_SCALE_Z,
    ),
    Side("sensitive", "note", "3.0 %, out of its interval", lambda x: leaning_on(5.0 * x, 0.01), loaded.SENSITIVE),
    Side("sensitive", "note", "3.9 %, out of its interval", lambda x: leaning_on(0.1 * x, 0.1), 1.96),
    Side(
        "burst",
        "note",
        "without them the mass is 5.13",
        lambda x: of_payload(estimate_of(), bursts=Bursts(1, 20, 1.0, 5.0 * x * np.eye(10)[9])),
        loaded.MOVED,
    ),
    Side("tilted", "note", "gravity leans by 0.5", leaning, beside_both.TILT),
    Side("tilted", "note", "gravity leans by 2.9", lambda x: leaning(0.05, 0.05 / x), beside_both.TILT_Z),
    Side("late", "warning", "lag position by about 8", lambda x: beside("late", x), nuisances.LATE),
    Side("late", "warning", "lead position by about 8", lambda x: beside("late", -x), nuisances.LATE),
    Side("late", "warning", "lag position by about 20", lambda x: beside("late", 0.02, x), nuisances.LATE_Z),
    Side("slipped", "error", "moves by 10", lambda x: beside("slip", x), nuisances.SLIP),
    Side("slipped", "error", "moves by 50", lambda x: beside("slip", 0.05, x), nuisances.SLIP_Z),
    Side("zeros_apart", "error", "q3 of L differs from that of U", apart, alignment.OFFSET),
    Side(
        "zeros_apart", "error", "constant -20.0", lambda x: apart(-0.02, 0.02 * x), alignment.CONSTANT, below=True
    ),
    Side("zeros_apart", "error", "constant +50.0", lambda x: apart(0.05, 0.0, x), alignment.CHANGING, below=True),
    Side("other_robots", "error", "robot 'ur5e'", lambda x: rival("robot", "ur5e", x), rival_checks.ROBOT),
    Side("other_robots", "error", "robot 'ur5e'", lambda x: rival("robot", "ur5e", 0.1, x), rival_checks.ROBOT_Z),
    Side(
        "other_robots",
        "note",
        "do not tell 'rx90' from 'ur5e'",
        lambda x: rival("robot", "ur5e", -x),
        rival_checks.ALIKE,
        True,
    ),
    Side("turned_joints", "error", "joint 5 is counted", lambda x: rival("turned", "5", x), rival_checks.TURNED),
    Side(
        "turned_joints",
        "error",
        "joint 5 is counted",
        lambda x: rival("turned", "5", 0.1, x),
        rival_checks.TURNED_Z,
    ),
    Side("arm_weight", "note", "the arm weighs 0.12", weighing_arm, rival_checks.LIGHT, True),
    Side("arm_weight", "error", "the arm weighs 0.08", weighing_arm, rival_checks.WEIGHTLESS, True),
    Side("arm_weight", "note", "the arm weighs 0.51", weighing_arm, rival_checks.HEAVY + 12.0 / 111.0),
    Side(
        "joints",
        "error",
        "joint 2 5.5",
        lambda x: of_weighing(by_joints=by_masses((5.0 + 5.0 * x, 0.001))),
        joints.WRONG,
    ),
    Side(
        "contradictions", "error", "the torques contradict: mass", lambda x: of_weighing(active(x)), CONFLICT, True
    ),
    Side("contradictions", "error", "the scale 5 ± 0.03 kg", lambda x: of_weighing(weighed_as(x)), ONE_PERCENT),
    Side(
        "contradictions",
        "error",
        "known beforehand contradicts",
        lambda x: of_weighing(possible_of(estimate_of(), x)),
        CONFLICT,
        True,
    ),
    Side(
        "conflicts",
        "error",
        "method 4 contradict the constraint: mass",
        lambda x: of_possible(active(x)),
        CONFLICT,
        True,
    ),
    Side("conflicts", "error", "the scale shows 5 kg", lambda x: of_possible(weighed_as(x)), ONE_PERCENT),
    Side(
        "conflicts",
        "error",
        "constraints together contradict",
        lambda x: of_possible(possible_of(estimate_of(), x)),
        CONFLICT,
        True,
    ),
    Side("other_ways", "error", "by the other way the mass is 5.25", _weighed, payload.OTHER_WAY),
    Side("drift", "error", "mass drifts", drifting, FIVE_PERCENT),
    Side("drift", "error", "mass drifts", lambda x: drifting(9.0, spread_of(DRIFT / x)), 2.0 * 1.96),
    Side(
        "steadiness",
        "error",
        "the mass changes",
        lambda x: in_time(9, 5.0 * x / (1.0 - x / 2.0)),
        recordings.CHANGE,
    ),
    Side(
        "steadiness",
        "error",
        "the mass changes",
        lambda x: in_time(9, x * float(np.hypot(0.05, 0.05)), 0.05),
        recordings.CHANGE_SIGMAS,
    ),
    Side("steadiness", "error", "centre of mass moves", lambda x: in_time(6, 5.0 * SIZE * x), recordings.CHANGE),
    Side("alignment", "warning", "U and L differ by 5.0 mrad", mismatched, recordings.MISMATCH),
    Side("condition", "warning", "nearly dependent", lambda x: Evidence(ROBOT, condition=x), payload.CONDITION),
    Side("inertia", "warning", "YY by 30 %", lambda x: inertia_sigma(YY=float(MOMENTS[1]) * x), INERTIA_SIGMA),
    Side(
        "inertia",
        "warning",
        "hardly shows XY",
        lambda x: inertia_sigma(YY=0.31 * float(MOMENTS[1]), XY=OWN * x),
        payload.OWN_SIZE,
    ),
    Side(
        "known_gains",
        "warning",
        "motor 2: the gain is known to 5 % only",
        lambda x: Evidence(ROBOT, gained=Gained(np.array([0.01, x, 0.01]), ())),
        KNOWN_WELL,
    ),
    Side(
        "known_gains",
        "error",
        "take a heavier weight",
        lambda x: Evidence(ROBOT, gained=Gained(np.array([0.06, x, 0.06]), ())),
        KNOWN_WELL,
    ),
    Side("motors_apart", "warning", "motor 3", lambda x: of_motor(x, x / 4.0), loaded_rows.JOINT_SCALE),
    Side("motors_apart", "warning", "motor 3", lambda x: of_motor(0.1, 0.1 / x), gains.OWN_SCALE_Z),
    Side("weights_apart", "error", "do not go together", lambda x: of_weights(1.0 + x, 1e-4), gains.APART),
    Side("weights_apart", "error", "do not go together", lambda x: of_weights(1.05, 0.05 / x), gains.APART_SIGMAS),
    Side(
        "causes",
        "warning",
        "L looks as if q1 is late",
        lambda x: of_payload(estimate_of(left=one_joint(x)), source=SOURCE),
        recordings.SUSPICIOUS,
    ),
)
FUNCTIONS: dict[str, Callable[[Evidence], list[Finding]]] = {
    check.__name__: check for check in (*CHECKS, *BEFOREHAND)
} | {"causes": lambda evidence: recordings.causes(evidence, [])}


@pytest.fixture(autouse=True)
def _one_cause(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where causes are looked for, one is found that is not serious."""
    monkeypatch.setattr(recordings, "likely_causes", lambda *_: (Cause("L", "q1 is late", 0.2, 0.15),))


def test_every_check_has_a_threshold_here() -> None:
    assert {side.check for side in SIDES} == set(FUNCTIONS)
    assert len(FUNCTIONS) == len(CHECKS) + len(BEFOREHAND) + 1


@pytest.mark.parametrize("side", SIDES, ids=[f"{side.check}: {side.words}" for side in SIDES])
def test_a_check_speaks_on_one_side_of_its_threshold(side: Side) -> None:
    """And what it says reaches the verdict."""
    near, beyond = (1.001, 0.999) if side.below else (0.999, 1.001)
    quiet, loud = side.make(near * side.limit), side.make(beyond * side.limit)

    def said(evidence: Evidence) -> list[Finding]:
        findings = FUNCTIONS[side.check](evidence)
        return [one for one in findings if one.severity == side.severity and side.words in one.text]

    assert said(quiet) == []
    (finding,) = said(loud)
    verdict = judge(loud)
    assert finding in verdict.findings
    assert finding not in judge(quiet).findings
    partly = "mass_and_com_only" if loud.gained is None else "identified_only"
    assert verdict.level == {"error": "do_not_use", "warning": partly, "note": "use"}[side.severity]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_check_is_silent_about_what_was_not_computed(name: str) -> None:
    assert FUNCTIONS[name](Evidence(ROBOT)) == []


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
    few = replace(many, masses=tuple(replace(one, degrees_of_freedom=1.0) for one in many.masses))
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
    asked: list[bool] = []

    def causes(_: Robot, __: object, contradicted: bool, apart: bool) -> tuple[Cause, ...]:
        asked.append(contradicted)
        return ()

    monkeypatch.setattr(recordings, "likely_causes", causes)
    for evidence in (of_payload(estimate_of(), source=SOURCE), of_payload(estimate_of(left=0.2), source=SOURCE)):
        judge(evidence)
    judge(of_payload(estimate_of(ten=with_mass(-5.0)), source=SOURCE))
    assert asked == [False, True]


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
        seen = Tilt(values, 1e-8 * np.eye(2), effects)
        change, covariance = seen.change(4)
        assert change[:2] == pytest.approx(values if moved else 0.0, rel=1e-3)
        square = values[0] ** 2 * (not moved)
        assert covariance[0, 0] == pytest.approx(square + 1e-8, rel=1e-3)
        assert not seen.change(3)[0].any()


def test_a_tilt_that_no_mounting_has_leaves_nothing() -> None:
    for angle, severity in ((0.999 * nuisances.STEEP, "note"), (1.001 * nuisances.STEEP, "error")):
        (finding,) = nuisances.tilted(leaning(angle))
        assert finding.severity == severity


def test_a_delay_that_moves_the_mass_leaves_nothing() -> None:
    for change, severity in ((0.999 * loaded.MOVED, "warning"), (1.001 * loaded.MOVED, "error")):
        (finding,) = nuisances.late(beside("late", 0.02, change=change))
        assert finding.severity == severity
    assert "the mass is 5.13 kg" in finding.text


def test_what_is_mixed_up_is_looked_for_where_a_guard_is_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    """And told on both sides of its thresholds."""
    tried = Rival("mixed up", "joints 2 and 3 are exchanged", rival_checks.TURNED, rival_checks.TURNED_Z)
    for fall, z, told in ((1.001, 1.001, 1), (0.999, 1.001, 0), (1.001, 0.999, 0)):
        found = tried._replace(fall=fall * tried.fall, z=z * tried.z)
        monkeypatch.setattr(nuisances, "mixed_up", lambda *_, found=found: (found,))
        evidence = of_payload(estimate_of(), source=SOURCE)
        assert len(nuisances.mixtures(evidence, ["scale"])) == told
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
