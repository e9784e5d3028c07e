"""Weighing by a short motion: each quantity by its own, what changed in between, ripple, repeats, and a scale."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import (
    KnownMass,
    LongMotion,
    PayloadAnswer,
    PossibleBody,
    Settings,
    ShortMotion,
    StandIn,
    answer_payload,
    identify,
    payload_estimate,
)
from dynident.estimation.payload.constant_torques import OFFSET_SHARE, HeldFriction
from dynident.estimation.payload.weighing import difference_weighing, known_robot_weighing
from dynident.model import InertialParameters, Recording, Robot, load_robot
from dynident.model.friction import Friction
from dynident.trajectories import RX90_NOISE, NearMotion, Simulator, random_via_points
from scipy.signal import lfilter

LOAD = InertialParameters.from_com(7.02, [0.01, -0.02, 0.15], np.diag([0.05, 0.05, 0.03]))
NOISE = 0.3 * np.array(RX90_NOISE)


class Pair(NamedTuple):
    """One motion without and with the payload."""

    bare: Recording
    loaded: Recording


Record = Callable[..., Pair]


def weighed(robot: Robot, pair: Pair, stand_in: StandIn | None = None, **options: Any) -> PayloadAnswer:
    answer = answer_payload(difference_weighing(robot, [pair.loaded], [pair.bare]), **options)
    return answer if stand_in is None else answer.assuming(stand_in)


def short(problem: LongMotion | ShortMotion) -> ShortMotion:
    """The parts of a weighing's problem beside its equations."""
    assert isinstance(problem, ShortMotion)
    return problem


def cut(recording: Recording, begin: float, end: float) -> Recording:
    """From a time to a time [s]."""
    inside = (recording.t >= begin) & (recording.t <= end)
    return replace(recording, t=recording.t[inside], q=recording.q[inside], torque=recording.torque[inside])


@pytest.fixture(scope="session")
def simulator() -> Simulator:
    return Simulator(load_robot("rx90"))


@pytest.fixture(scope="session")
def record(simulator: Simulator, near: Callable[..., NearMotion]) -> Record:
    """``record(joints, seed, noise, load)``: a pair of recordings; held joints flicker by their encoders."""

    def make(joints: Sequence[int], seed: int = 0, noise: Array = NOISE, load: InertialParameters = LOAD) -> Pair:
        motion = near(joints).motion(250.0)
        draw = np.random.default_rng([seed, 77])
        pair = []
        for k, body in enumerate((None, load)):
            recording = simulator.record(motion, body, noise, [seed, k], f"run{seed}-{k}")
            flicker = 2e-5 * draw.standard_normal(recording.q.shape)
            flicker[:, [joint - 1 for joint in joints]] = 0.0
            pair.append(replace(recording, q=recording.q + flicker))
        return Pair(*pair)

    return make


@pytest.fixture(scope="session")
def arm(record: Record, simulator: Simulator) -> ShortMotion:
    pair = record((2, 3, 5, 6))
    return difference_weighing(simulator.robot, [pair.loaded], [pair.bare])


def test_mass_not_visible_and_no_number_instead(record: Record, simulator: Simulator) -> None:
    with pytest.raises(InputError, match="mass not visible"):
        weighed(simulator.robot, record((4, 5, 6)))


@pytest.mark.parametrize("seed", range(1, 3))
def test_few_blocks_count(record: Record, simulator: Simulator, seed: int) -> None:
    """3 s give two blocks: sigma alone would do, but the interval is six times as wide as from many."""
    pair = Pair(*(cut(recording, 2.0, 5.0) for recording in record((2, 3, 5, 6), seed)))
    answer = weighed(simulator.robot, pair)
    assert answer.model.degrees_of_freedom == 1
    low, high = answer.mass_interval
    assert (high - low) / 2.0 > 0.1 * answer.mass
    assert answer.spread.mass < 0.05 * answer.mass
    assert answer.judged["mass"].use == "not measured well enough"
    assert answer.verdict.level == "do_not_use"


def test_held_joints_are_dropped(arm: ShortMotion) -> None:
    assert short(arm).joints == (2, 3, 5, 6)
    assert [rows > 0 for rows in arm.loaded.rows] == [False, True, True, False, True, True]


def test_joints_asked_for_must_move(record: Record, simulator: Simulator) -> None:
    pair = record((2, 3, 5))
    with pytest.raises(InputError, match="joint 6 of rx90 does not move"):
        difference_weighing(simulator.robot, [pair.loaded], [pair.bare], settings=Settings(joints=(2, 6)))
    some = difference_weighing(simulator.robot, [pair.loaded], [pair.bare], settings=Settings(joints=(2, 5)))
    assert short(some).joints == (2, 5)


def test_recordings_that_do_not_form_pairs(record: Record, simulator: Simulator) -> None:
    a, b = record((2, 3, 5, 6)), record((2, 3, 5, 6), 1)
    with pytest.raises(InputError, match="one without for all"):
        difference_weighing(simulator.robot, [a.loaded, b.loaded, record((2, 3, 5, 6), 2).loaded], [a.bare, b.bare])


def test_without_noise_the_payload_is_exact(record: Record, simulator: Simulator) -> None:
    pair = record((2, 3, 5, 6), noise=np.zeros(6))
    payload = payload_estimate(difference_weighing(simulator.robot, [pair.loaded], [pair.bare]), 3)
    assert payload.ten == pytest.approx(LOAD.vector, abs=2e-3)


@pytest.mark.parametrize(("begin", "end"), [(2.3, 17.2), (1.1, 18.2), (3.1, 16.3)])
def test_ends_cut_in_full_motion_cost_little(
    record: Record, simulator: Simulator, begin: float, end: float
) -> None:
    """The filter errs there, alike in both recordings of a pair: the payload is off by up to 3e-3."""
    pair = record((2, 3, 5, 6), noise=np.zeros(6))
    problem = difference_weighing(simulator.robot, [cut(pair.loaded, begin, end)], [cut(pair.bare, begin, end)])
    assert payload_estimate(problem, 3).ten == pytest.approx(LOAD.vector, abs=5e-3)


def test_a_constant_torque_and_coulomb_friction_that_changed_do_not_matter(
    record: Record, simulator: Simulator
) -> None:
    pair = record((2, 3, 5, 6))
    qd = np.gradient(pair.loaded.q, pair.loaded.t, axis=0)
    changed = pair.loaded.torque + np.array([0, 9, 5, 0, 3, 1]) + np.array([0, 6, 3, 0, 2, 1]) * np.sign(qd)
    changed_pair = Pair(pair.bare, replace(pair.loaded, torque=changed))
    first, second = (weighed(simulator.robot, each_pair) for each_pair in (pair, changed_pair))
    assert first.short.held.joints == (1, 2)  # counted from 0
    assert second.short.held.joints == ()  # told by the recordings themselves
    assert second.mass == pytest.approx(first.mass, abs=2.0 * first.spread.mass)
    assert np.abs(second.com - first.com).max() < 2.0 * first.spread.com.max()
    assert second.mass == pytest.approx(LOAD.mass, abs=4.0 * second.spread.mass)
    assert abs(second.agreement[0].mass - LOAD.mass) > 0.1  # what plain differences make of it


def test_a_constant_torque_within_the_allowance_is_in_the_interval(
    record: Record, simulator: Simulator, arm: ShortMotion
) -> None:
    """The allowance adds what the mass changes by when constant torques differ by as much."""
    motion, payload = short(arm), payload_estimate(arm, 3)
    torques = motion.held
    assert torques.sigma[1] == pytest.approx(OFFSET_SHARE * simulator.robot.parameters["FS2"], rel=0.1)
    pair = record((2, 3, 5, 6))
    moved = np.zeros(10)
    for j in torques.joints:
        torque = pair.loaded.torque + np.eye(6)[j] * torques.sigma[j]
        moved_pair = difference_weighing(simulator.robot, [replace(pair.loaded, torque=torque)], [pair.bare])
        moved_payload = payload_estimate(moved_pair, 3)
        moved += (moved_payload.ten - payload.ten) ** 2
    free = replace(motion, held=HeldFriction({}, np.zeros(6), np.ones(6)))
    assert payload_estimate(free, 3).ten == pytest.approx(payload.ten, abs=5.0 * np.max(payload.estimate.sigma))
    assert payload.estimate.robust is not None
    assert moved[9] > 0.0
    assert payload.estimate.robust.covariance[9, 9] > 0.9 * moved[9]


@pytest.mark.parametrize(("share", "held"), [(2.0, True), (6.0, False)])
def test_a_constant_torque_beyond_the_allowance_is_free(
    record: Record, simulator: Simulator, share: float, held: bool
) -> None:
    """Its square in allowances is what the residual rises by, however long the errors remember."""
    rho, draw, pair = np.exp(-1.0 / 125.0), np.random.default_rng(0), record((2, 3, 5, 6), noise=0.0 * NOISE)
    logs = []
    for recording, torque in zip(
        pair, (0.0, share * OFFSET_SHARE * simulator.robot.parameters["FS2"]), strict=True
    ):
        white = 0.03 * NOISE * np.sqrt(1.0 - rho**2) * draw.standard_normal(recording.torque.shape)
        slow = lfilter([1.0], [1.0, -rho], white, axis=0)
        logs.append(replace(recording, torque=recording.torque + slow + torque * np.eye(6)[1]))
    motion = short(difference_weighing(simulator.robot, logs[1:], logs[:1]))
    assert motion.held.joints == ((1, 2) if held else ())


@pytest.mark.long
def test_a_drift_is_told_and_widens(record: Record, simulator: Simulator) -> None:
    """Torques that grow by 3 % from one recording to the next."""
    pairs = [record((2, 3, 5, 6), seed) for seed in range(4)]
    loaded = [replace(p.loaded, torque=(1.0 + 0.03 * k) * p.loaded.torque) for k, p in enumerate(pairs)]
    answer = answer_payload(difference_weighing(simulator.robot, loaded, [p.bare for p in pairs]))
    assert answer.repeats is not None
    assert answer.repeats.drifts
    assert answer.repeats.drift_per_recording is not None
    assert answer.repeats.drift_per_recording > 0.1
    assert answer.repeats.excess > 1.5
    assert any("drifts" in text for text in (*answer.verdict.reasons, *answer.verdict.notes))


def test_a_known_robot_with_asymmetric_friction(record: Record, simulator: Simulator) -> None:
    """While a joint moves FA is a constant torque, and both are free under load."""
    robot = simulator.robot.with_friction((*simulator.robot.drives.friction, Friction("FA")))
    motion = random_via_points(robot, 14, 1).motion(250.0)
    known = identify(robot, [simulator.record(motion, None, NOISE, 1)], Settings(robust=False)).estimate
    answer = answer_payload(known_robot_weighing(robot, [record((2, 3, 5, 6)).loaded], known))
    assert answer.mass == pytest.approx(LOAD.mass, abs=3.0 * answer.spread.mass)


def shaken(pair: Pair) -> Pair:
    """With ripple of 5 % of each moving joint's torque, 36 waves a turn, beside the payload."""
    q, places = pair.loaded.q, [1, 2, 4, 5]
    wave = np.zeros_like(q)
    wave[:, places] = (sizes(pair) * np.sin(36.0 * q + 0.7))[:, places]
    return Pair(pair.bare, replace(pair.loaded, torque=pair.loaded.torque + wave))


def sizes(pair: Pair) -> Array:
    return np.asarray(0.05 * np.sqrt(np.mean(pair.loaded.torque**2, axis=0)))


@pytest.mark.long
def test_ripple_that_comes_with_the_payload_is_found(record: Record, simulator: Simulator) -> None:
    """A ripple's waves are found; mass and interval's width are as if it were not there, or wide enough."""
    pair = record((2, 3, 5, 6))
    size = sizes(pair)
    plain, rippled = weighed(simulator.robot, pair), weighed(simulator.robot, shaken(pair))
    ripples = rippled.short.runs[0].ripple
    assert {ripple.joint for ripple in ripples} >= {2, 3}
    clear = [ripple for ripple in ripples if ripple.joint in (2, 3)]
    assert all(ripple.waves == pytest.approx(36.0, abs=1.5) for ripple in clear)
    assert all(ripple.amplitude == pytest.approx(size[ripple.joint - 1], rel=0.3) for ripple in clear)
    assert rippled.mass == pytest.approx(plain.mass, abs=plain.spread.mass)
    low, high = rippled.mass_interval
    assert low < LOAD.mass < high


def test_with_a_scale_the_wrist_alone_will_do(record: Record, simulator: Simulator) -> None:
    rules = (PossibleBody(), KnownMass(7.02, 0.02))
    answer = weighed(simulator.robot, record((4, 5, 6)), constraints=rules)
    assert answer.judged["mass"].use == "weighed"
    assert answer.mass == pytest.approx(7.02, abs=1e-3)
    assert answer.weighing is None
    assert all(group.mass is None for group in answer.by_joints.masses)
    assert np.abs(answer.com - LOAD.com).max() < 0.02
    # 0.02 kg of the scale is all that is unsure about it
    assert answer.spread.mass == pytest.approx(0.02)


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
