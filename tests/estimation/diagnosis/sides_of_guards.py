"""Both sides of each threshold of the guards, and of the checks on constraints, gains and other ways."""

import numpy as np
from dynident.estimation.diagnosis import loaded_rows
from dynident.estimation.diagnosis import nuisances as beside_both
from dynident.estimation.diagnosis import pull as at_flange
from dynident.estimation.diagnosis.checks import gains, joints, loaded, nuisances, payload, recordings
from dynident.estimation.diagnosis.checks import robot as rival_checks
from dynident.estimation.diagnosis.evidence import KNOWN_WELL, Evidence, Gained
from dynident.estimation.diagnosis.nuisances import Bursts
from dynident.estimation.diagnosis.quantities import (
    INERTIA_SIGMA,
)
from dynident.estimation.possible.result import CONFLICT
from dynident.estimation.signals import alignment
from dynident.tests.estimation.diagnosis.made import (
    MOMENTS,
    ROBOT,
    SIZE,
    SOURCE,
    active,
    by_masses,
    drifting,
    estimate_of,
    in_time,
    inertia_sigma,
    mismatched,
    of_payload,
    of_possible,
    of_weighing,
    one_joint,
    possible_of,
    spread_of,
    weighed_as,
)
from dynident.tests.estimation.diagnosis.sides import (
    DRIFT,
    FIVE_PERCENT,
    ONE_PERCENT,
    OWN,
    Side,
    apart,
    beside,
    leaning,
    leaning_on,
    of_motor,
    of_weights,
    pulling,
    rival,
    scaled,
    weighed_apart,
    weighing_arm,
)

OF_GUARDS = (
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
    Side("pulled", "error", "without it the mass would be 10 ± 0.6 kg", pulling, at_flange.PULL),
    Side("pulled", "error", "(7.01 ± 1 N/m", lambda x: pulling(1.0, x), at_flange.PULL_Z),
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
    Side("other_ways", "error", "by the other way the mass is 5.25", weighed_apart, payload.OTHER_WAY),
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
