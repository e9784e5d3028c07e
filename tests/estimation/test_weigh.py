"""Weighing by a short motion of an RX90: visibility, coverage, scale, repeats, stand-ins, agreement."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from dynident.estimation import (
    OFFSET_SHARE,
    GainErrors,
    KnownMass,
    PossibleBody,
    StandIn,
    WeighAnswer,
    WeighProblem,
    answer_weighing,
    difference_weighing,
    identify,
    known_robot_weighing,
    solve_weighing,
)
from dynident.estimation.weigh.run import free_offsets
from dynident.model import InertialParameters, InputError, Recording, Robot, load_robot
from dynident.model.arrays import Array
from dynident.trajectories import RX90_NOISE, NearMotion, Simulator, random_via_points

LOAD = InertialParameters.from_com(7.02, [0.01, -0.02, 0.15], np.diag([0.05, 0.05, 0.03]))
NOISE = 0.3 * np.array(RX90_NOISE)
POSE = np.radians([0.0, -45.0, 90.0, 0.0, 45.0, 0.0])


def near(joints: Sequence[int], duration: float = 20.0, seed: int = 0) -> NearMotion:
    """Periods of 5 s of random harmonics, within 30 degrees."""
    draw, n, harmonics = np.random.default_rng(seed), 6, 4
    a, b = np.zeros((2, 1, n, harmonics))
    for joint in joints:
        own = 0.6 * draw.standard_normal(harmonics)
        a[0, joint - 1] = own - own.mean()  # at rest where it begins
    return NearMotion(POSE[None], a, b, 5.0, int(duration / 5.0), 0.0)


class Pair(NamedTuple):
    """One motion without and with the payload."""

    bare: Recording
    loaded: Recording


@pytest.fixture(scope="module")
def simulator() -> Simulator:
    return Simulator(load_robot("rx90"))


Record = Callable[..., Pair]


@pytest.fixture(scope="module")
def record(simulator: Simulator) -> Record:
    """``record(joints, seed, noise, load)``: a pair of recordings; held joints flicker by their encoders."""

    def make(joints: Sequence[int], seed: int = 0, noise: Array = NOISE, load: InertialParameters = LOAD) -> Pair:
        motion = near(joints).motion(250.0)
        draw = np.random.default_rng([seed, 77])
        pair = []
        for k, body in enumerate((None, load)):
            one = simulator.record(motion, body, noise, [seed, k], f"run{seed}-{k}")
            flicker = 2e-5 * draw.standard_normal(one.q.shape)
            flicker[:, [joint - 1 for joint in joints]] = 0.0
            pair.append(replace(one, q=one.q + flicker))
        return Pair(*pair)

    return make


@pytest.fixture(scope="module")
def arm(record: Record, simulator: Simulator) -> WeighProblem:
    pair = record((2, 3, 5, 6))
    return difference_weighing(simulator.robot, [pair.loaded], [pair.bare])


def weighed(robot: Robot, pair: Pair, **options: Any) -> WeighAnswer:
    return answer_weighing(difference_weighing(robot, [pair.loaded], [pair.bare]), **options)


def test_held_joints_are_dropped(arm: WeighProblem) -> None:
    assert arm.joints == (2, 3, 5, 6)
    assert [rows > 0 for rows in arm.problem.rows] == [False, True, True, False, True, True]


def test_without_noise_the_payload_is_exact(record: Record, simulator: Simulator) -> None:
    pair = record((2, 3, 5, 6), noise=np.zeros(6))
    found = solve_weighing(difference_weighing(simulator.robot, [pair.loaded], [pair.bare]))
    assert found.ten == pytest.approx(LOAD.vector, abs=2e-3)


def test_a_constant_torque_and_coulomb_friction_that_changed_do_not_matter(
    record: Record, simulator: Simulator
) -> None:
    pair = record((2, 3, 5, 6))
    qd = np.gradient(pair.loaded.q, pair.loaded.t, axis=0)
    changed = pair.loaded.torque + np.array([0, 9, 5, 0, 3, 1]) + np.array([0, 6, 3, 0, 2, 1]) * np.sign(qd)
    other = Pair(pair.bare, replace(pair.loaded, torque=changed))
    first, second = (weighed(simulator.robot, one) for one in (pair, other))
    assert first.problem.held.joints == (1, 2)  # counted from 0
    assert second.problem.held.joints == ()  # told by the recordings themselves
    assert second.mass == pytest.approx(first.mass, abs=2.0 * first.spread.mass)
    assert np.abs(second.com - first.com).max() < 2.0 * first.spread.com.max()
    assert second.mass == pytest.approx(LOAD.mass, abs=4.0 * second.spread.mass)
    assert abs(second.agreement[0].mass - LOAD.mass) > 0.1  # what plain differences make of it


def test_a_constant_torque_within_the_allowance_is_in_the_interval(
    record: Record, simulator: Simulator, arm: WeighProblem
) -> None:
    """What the allowance adds is what the mass changes by when constant torques differ by as much."""
    held, found = arm.held, solve_weighing(arm)
    assert held.sigma[1] == pytest.approx(OFFSET_SHARE * simulator.robot.parameters["FS2"], rel=0.1)
    pair = record((2, 3, 5, 6))
    moved = np.zeros(10)
    for j in held.joints:
        torque = pair.loaded.torque + np.eye(6)[j] * held.sigma[j]
        other = solve_weighing(
            difference_weighing(simulator.robot, [replace(pair.loaded, torque=torque)], [pair.bare])
        )
        moved += (other.ten - found.ten) ** 2
    free = replace(arm, runs=tuple(replace(run, held=free_offsets(6)) for run in arm.runs))
    assert solve_weighing(free).ten == pytest.approx(found.ten, abs=5.0 * np.max(found.estimate.sigma))
    assert found.estimate.robust is not None
    assert moved[9] > 0.0
    assert found.estimate.robust.covariance[9, 9] > 0.9 * moved[9]


def test_ripple_that_comes_with_the_payload_is_found(record: Record, simulator: Simulator) -> None:
    """Its waves; the mass, and the interval's width, as if it were not there or wide enough."""
    pair = record((2, 3, 5, 6))
    q, places = pair.loaded.q, [1, 2, 4, 5]
    size = 0.05 * np.sqrt(np.mean(pair.loaded.torque**2, axis=0))
    wave = np.zeros_like(q)
    wave[:, places] = (size * np.sin(36.0 * q + 0.7))[:, places]
    plain = weighed(simulator.robot, pair)
    rippled = weighed(simulator.robot, Pair(pair.bare, replace(pair.loaded, torque=pair.loaded.torque + wave)))
    found = rippled.problem.runs[0].ripple
    assert {one.joint for one in found} >= {2, 3}
    clear = [one for one in found if one.joint in (2, 3)]
    assert all(one.waves == pytest.approx(36.0, abs=1.5) for one in clear)
    assert all(one.amplitude == pytest.approx(size[one.joint - 1], rel=0.3) for one in clear)
    assert rippled.mass == pytest.approx(plain.mass, abs=plain.spread.mass)
    low, high = rippled.mass_interval
    assert low < LOAD.mass < high


def test_white_noise_has_no_ripple(record: Record, simulator: Simulator) -> None:
    waves = [len(weighed(simulator.robot, record((2, 3, 5, 6), seed)).problem.runs[0].ripple) for seed in range(4)]
    assert sum(waves) <= 2  # of 16 joints, each with one chance in twenty


def test_every_quantity_is_judged_by_its_own(record: Record, simulator: Simulator) -> None:
    answer = weighed(simulator.robot, record((2, 3, 5, 6)))
    assert answer.judged["mass"].use == "use"
    assert answer.judged["centre of mass"].use == "use"
    low, high = answer.mass_interval
    assert low < LOAD.mass < high
    assert np.abs(answer.com - LOAD.com).max() < 4.0 * answer.spread.com.max()
    assert ((answer.com_interval[:, 0] < answer.com) & (answer.com < answer.com_interval[:, 1])).all()
    assert answer.verdict.level in ("use", "mass_and_com_only")
    assert {one.name for one in answer.by_joints.masses} >= {"joint 2", "joint 3", "joints 2-3", "joints 5-6"}


def test_inertia_counts_only_below_thirty_percent(simulator: Simulator, record: Record) -> None:
    light = InertialParameters.from_com(1.0, [0.0, 0.0, 0.05], 1e-3 * np.eye(3))
    answer = weighed(simulator.robot, record((2, 3, 5, 6), load=light))
    assert answer.judged["inertia"].use == "not measured well enough"
    heavy = InertialParameters.from_com(20.0, [0.0, 0.0, 0.1], np.eye(3))
    assert weighed(simulator.robot, record((2, 3, 5, 6), load=heavy)).judged["inertia"].use == "use"


def test_mass_not_visible_and_no_number_instead(record: Record, simulator: Simulator) -> None:
    with pytest.raises(InputError, match="mass not visible"):
        weighed(simulator.robot, record((4, 5, 6)))


def test_with_a_scale_the_wrist_alone_will_do(record: Record, simulator: Simulator) -> None:
    rules = (PossibleBody(), KnownMass(7.02, 0.02))
    answer = weighed(simulator.robot, record((4, 5, 6)), constraints=rules)
    assert answer.judged["mass"].use == "weighed"
    assert answer.mass == pytest.approx(7.02, abs=1e-3)
    assert answer.weighing is None
    assert all(one.mass is None for one in answer.by_joints.masses)
    assert np.abs(answer.com - LOAD.com).max() < 0.02
    # 0.02 kg of the scale is all that is unsure about it
    assert answer.spread.mass == pytest.approx(0.02)


def test_one_joint_with_a_scale_tells_what_it_shows(record: Record, simulator: Simulator) -> None:
    pair = record((6,))
    rules = (PossibleBody(), KnownMass(7.02, 0.02))
    answer = weighed(simulator.robot, pair, constraints=rules)
    assert answer.constrained is None
    assert np.flatnonzero(np.isfinite(answer.ten)).tolist() == [5, 6, 7, 9]  # ZZ, MX, MY, M
    assert np.isfinite(answer.com).tolist() == [True, True, False]
    assert answer.judged["centre of mass"].use == "not visible"
    assert answer.verdict.level == "do_not_use"
    with pytest.raises(InputError, match="centre of mass that is not known"):
        weighed(simulator.robot, pair, constraints=rules, stand_in=StandIn.parse("box:60x60x350"))


def test_a_scale_that_is_wrong_is_told(record: Record, simulator: Simulator) -> None:
    rules = (PossibleBody(), KnownMass(9.0, 0.02))
    answer = weighed(simulator.robot, record((2, 3, 5, 6)), constraints=rules)
    assert answer.verdict.level == "do_not_use"
    assert any("the scale 9" in reason for reason in answer.verdict.reasons)


def test_a_scale_sharpens(record: Record, simulator: Simulator) -> None:
    pair = record((2, 3, 5, 6))
    free = weighed(simulator.robot, pair)
    known = weighed(simulator.robot, pair, constraints=(PossibleBody(), KnownMass(7.02, 0.005)))
    assert known.spread.com[2] < free.spread.com[2]
    assert np.ptp(known.mass_interval) < np.ptp(free.mass_interval)


def test_gain_errors_widen(record: Record, simulator: Simulator, arm: WeighProblem) -> None:
    plain, unsure = answer_weighing(arm), answer_weighing(arm, gains=GainErrors((0.0,), 0.02))
    wider = unsure.model.sigma[9] ** 2 - plain.model.sigma[9] ** 2
    assert np.sqrt(wider) == pytest.approx(0.02 * plain.found.ten[9], rel=1e-6)  # common: scales the mass


def test_coverage_of_the_mass(record: Record, simulator: Simulator) -> None:
    """20 seeds; the benchmark has 100 of each case."""
    held, places = 0, np.zeros(3)
    for seed in range(20):
        answer = weighed(simulator.robot, record((2, 3, 5, 6), seed))
        low, high = answer.mass_interval
        held += low <= LOAD.mass <= high
        places += (answer.com_interval[:, 0] <= LOAD.com) & (LOAD.com <= answer.com_interval[:, 1])
    assert held >= 17  # of 95 %: fewer once in 60
    assert (places >= 16).all()


def test_repeats_spread_and_no_drift(record: Record, simulator: Simulator) -> None:
    pairs = [record((2, 3, 5, 6), seed) for seed in range(4)]
    answer = answer_weighing(
        difference_weighing(simulator.robot, [p.loaded for p in pairs], [p.bare for p in pairs])
    )
    repeats = answer.repeats
    assert repeats is not None
    assert len(repeats.masses) == 4
    assert repeats.spread == pytest.approx(np.std(repeats.masses, ddof=1))
    assert not repeats.drifts
    assert answer.spread.mass / repeats.excess < min(repeats.sigmas)
    one = answer_weighing(difference_weighing(simulator.robot, [p.loaded for p in pairs], [pairs[0].bare]))
    assert one.mass == pytest.approx(LOAD.mass, abs=0.3)


def test_a_drift_is_told_and_widens(record: Record, simulator: Simulator) -> None:
    """Torques that grow by 3 % from one recording to the next."""
    pairs = [record((2, 3, 5, 6), seed) for seed in range(4)]
    loaded = [replace(p.loaded, torque=(1.0 + 0.03 * k) * p.loaded.torque) for k, p in enumerate(pairs)]
    answer = answer_weighing(difference_weighing(simulator.robot, loaded, [p.bare for p in pairs]))
    assert answer.repeats is not None
    assert answer.repeats.drifts
    assert answer.repeats.drift is not None
    assert answer.repeats.drift[0] > 0.1
    assert answer.repeats.excess > 1.5
    assert any("drifts" in reason for reason in answer.verdict.reasons)


def test_robot_parameters_instead_of_a_recording(record: Record, simulator: Simulator) -> None:
    robot = simulator.robot
    motion = random_via_points(robot, 14, 1).motion(250.0)
    known = identify(robot, [simulator.record(motion, None, NOISE, 1)]).estimate
    pair = record((2, 3, 5, 6))
    problem = known_robot_weighing(robot, [pair.loaded], known)
    answer = answer_weighing(
        problem, gains=GainErrors((0.01,)), others=[difference_weighing(robot, [pair.loaded], [pair.bare])]
    )
    assert answer.mass == pytest.approx(LOAD.mass, abs=3.0 * answer.spread.mass)
    certain = answer_weighing(replace(problem, known=replace(known, covariance=0.0 * known.covariance)))
    assert answer.found.estimate.sigma[9] > certain.found.estimate.sigma[9]
    assert [way.name for way in answer.agreement] == ["torque difference (method 3)"]
    with pytest.raises(InputError, match="another model"):
        known_robot_weighing(robot.with_offsets(True), [pair.loaded], known)


def test_joints_asked_for_must_move(record: Record, simulator: Simulator) -> None:
    pair = record((2, 3, 5))
    with pytest.raises(InputError, match="joint 6 of rx90 does not move"):
        difference_weighing(simulator.robot, [pair.loaded], [pair.bare], joints=(2, 6))
    some = difference_weighing(simulator.robot, [pair.loaded], [pair.bare], joints=(2, 5))
    assert some.joints == (2, 5)


def test_recordings_that_do_not_form_pairs(record: Record, simulator: Simulator) -> None:
    a, b = record((2, 3, 5, 6)), record((2, 3, 5, 6), 1)
    with pytest.raises(InputError, match="one without for all"):
        difference_weighing(simulator.robot, [a.loaded, b.loaded, record((2, 3, 5, 6), 2).loaded], [a.bare, b.bare])


def test_swapped_recordings_are_not_used(record: Record, simulator: Simulator) -> None:
    pair = record((2, 3, 5, 6))
    answer = weighed(simulator.robot, Pair(pair.loaded, pair.bare))
    assert answer.verdict.level == "do_not_use"
    assert any("negative" in reason for reason in answer.verdict.reasons)


def test_stand_ins_are_the_bodies_they_say() -> None:
    """A box and a cylinder of many points."""
    draw = np.random.default_rng(0)
    points = draw.uniform(-0.5, 0.5, (200_000, 3)) * [0.06, 0.08, 0.35]
    box = StandIn.parse("box:60x80x350")
    assert box.inertia(2.0) == pytest.approx(inertia(points, 2.0), abs=2e-4)
    inside = draw.uniform(-0.5, 0.5, (300_000, 3)) * [0.1, 0.1, 0.3]
    inside = inside[np.hypot(inside[:, 0], inside[:, 1]) <= 0.05]
    cylinder = StandIn.parse("Cylinder:100x300")
    assert cylinder.inertia(3.0) == pytest.approx(inertia(inside, 3.0), abs=2e-4)
    assert cylinder.body(3.0, np.array([0.0, 0.1, 0.2])).physically_consistent


def inertia(points: Array, mass: float) -> Array:
    centred = points - points.mean(axis=0)
    squares = centred.T @ centred / len(points)
    return np.asarray(mass * (np.trace(squares) * np.eye(3) - squares))


@pytest.mark.parametrize("text", ["", "box", "box:60x60", "box:0x1x1", "ball:60", "cylinder:1x2x3", "box:1x..x3"])
def test_stand_ins_that_are_none(text: str) -> None:
    with pytest.raises(InputError, match="cylinder"):
        StandIn.parse(text)


def test_a_stand_in_fills_what_is_missing_only(record: Record, simulator: Simulator) -> None:
    light = InertialParameters.from_com(1.0, [0.0, 0.0, 0.05], 1e-3 * np.eye(3))
    body = StandIn.parse("box:60x60x350")
    answer = weighed(simulator.robot, record((2, 3, 5, 6), load=light), stand_in=body)
    assert answer.judged["inertia"].use == "assumed"
    assert answer.assumed is not None
    assert answer.assumed.inertia_com == pytest.approx(body.inertia(answer.mass), abs=1e-12)
    assert answer.assumed.com == pytest.approx(answer.com)
    heavy = InertialParameters.from_com(20.0, [0.0, 0.0, 0.1], np.eye(3))
    measured = weighed(simulator.robot, record((2, 3, 5, 6), load=heavy), stand_in=body)
    assert measured.stand_in is None
    assert measured.judged["inertia"].use == "use"
