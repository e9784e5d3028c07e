"""Weighing by a short motion, and pairs of one motion: gaps, paths that differ, what changed in between."""

import pickle
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from dynident.benchmarks import invented
from dynident.benchmarks.shared import lasting
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
    identify_payload,
    payload_estimate,
    payload_problem,
)
from dynident.estimation.equations.observer import PATH
from dynident.estimation.fit.settings import FRICTION_CHANGE
from dynident.estimation.payload.by_joints import Repeats
from dynident.estimation.payload.long_motion import cut_alike
from dynident.estimation.payload.methods import ONE_PATH, recommended_method
from dynident.estimation.payload.short_motion import (
    OFFSET_SHARE,
    HeldFriction,
    difference_weighing,
    known_robot_weighing,
)
from dynident.estimation.payload.static import Order
from dynident.estimation.results.payload import numbers
from dynident.estimation.signals.filtering import aligned
from dynident.estimation.signals.recordings import cut, pieces
from dynident.model import InertialParameters, Motion, Processing, Recording, Robot, load_robot
from dynident.model.friction import Friction
from dynident.tests.estimation.conftest import near_pose
from dynident.trajectories import RX90_NOISE, Simulator, Task, random_via_points, run_experiment
from dynident.trajectories.motions.family import Plan
from dynident.trajectories.simulation import CONTROLLERS, no_disturbances

LOAD = InertialParameters.from_com(7.02, [0.01, -0.02, 0.15], np.diag([0.05, 0.05, 0.03]))
NOISE = 0.3 * np.array(RX90_NOISE)


class Pair(NamedTuple):
    """One motion without and with the payload."""

    bare: Recording
    loaded: Recording


Record = Callable[..., Pair]


def weighed(robot: Robot, pair: Pair, **options: Any) -> PayloadAnswer:
    return answer_payload(difference_weighing(robot, [pair.loaded], [pair.bare]), **options)


def short(problem: LongMotion | ShortMotion) -> ShortMotion:
    """The parts of a weighing's problem beside its equations."""
    assert isinstance(problem, ShortMotion)
    return problem


def between(recording: Recording, begin: float, end: float) -> Recording:
    """From a time to a time [s]."""
    inside = (recording.t >= begin) & (recording.t <= end)
    return replace(recording, t=recording.t[inside], q=recording.q[inside], torque=recording.torque[inside])


@pytest.fixture(scope="session")
def simulator() -> Simulator:
    return Simulator(load_robot("rx90"))


@pytest.fixture(scope="session")
def record(simulator: Simulator) -> Record:
    """``record(joints, seed, noise, load)``: a pair of recordings; held joints flicker by their encoders."""

    def make(joints: Sequence[int], seed: int = 0, noise: Array = NOISE, load: InertialParameters = LOAD) -> Pair:
        motion = near_pose(joints).motion(250.0)
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


def test_few_blocks_count(record: Record, simulator: Simulator) -> None:
    """3 s give two blocks: sigma alone would do, but the interval is six times as wide as from many."""
    pair = Pair(*(between(recording, 2.0, 5.0) for recording in record((2, 3, 5, 6), 1)))
    answer = weighed(simulator.robot, pair)
    assert answer.model.degrees_of_freedom == 1
    low, high = answer.intervals[0]
    assert (high - low) / 2.0 > 0.1 * answer.mass
    assert answer.spread.mass < 0.05 * answer.mass
    judged_by, wider = answer.evidence.spread, 12.7062 / 1.95996  # with one degree of freedom
    assert judged_by is not None
    assert judged_by.com == pytest.approx(wider * answer.spread.com, rel=1e-5)
    assert judged_by.inertia_com == pytest.approx(wider * answer.spread.inertia_com, rel=1e-5)
    assert judged_by.mass == pytest.approx(min(wider * answer.spread.mass, (high - low) / 2.0 / 1.95996), rel=1e-5)
    assert answer.evidence.judged["mass"][0] == "not measured well enough"
    assert answer.verdict.level == "do_not_use"


def test_held_joints_are_dropped(arm: ShortMotion) -> None:
    assert short(arm).joints == (2, 3, 5, 6)
    assert [rows > 0 for rows in arm.loaded.rows] == [False, True, True, False, True, True]


def test_a_joint_that_creeps_is_at_rest(record: Record, simulator: Simulator) -> None:
    """Friction holds it, so that its torque follows no load: it is on no scale."""
    pair, rest, rate = record((2, 3, 5, 6), noise=NOISE / 6.0), [0, 3], 1e-4

    def creeping(recording: Recording, held: float) -> Recording:
        q, torque = np.array(recording.q), np.array(recording.torque)
        q[:, rest] = q[:, rest].mean(axis=0) + rate * (recording.t[:, None] - recording.t.mean())
        torque[:, rest] += held * (torque[:, rest].mean(axis=0) - torque[:, rest])
        return replace(recording, q=q, torque=torque)

    answer = weighed(simulator.robot, Pair(creeping(pair.bare, 0.0), creeping(pair.loaded, 0.7)))
    assert answer.verdict.level == weighed(simulator.robot, pair).verdict.level
    assert not any("another scale" in reason for reason in answer.verdict.reasons)


def test_joints_asked_for_must_move(record: Record, simulator: Simulator) -> None:
    pair = record((2, 3, 5))
    with pytest.raises(InputError, match="joint 6 of rx90 hardly moves"):
        difference_weighing(simulator.robot, [pair.loaded], [pair.bare], settings=Settings(joints=(2, 6)))
    some = difference_weighing(simulator.robot, [pair.loaded], [pair.bare], settings=Settings(joints=(2, 5)))
    assert short(some).joints == (2, 5)


@pytest.mark.parametrize(("begin", "end", "off"), [(0.0, 99.0, 2e-3), (2.3, 17.2, 5e-3), (1.1, 18.2, 5e-3)])
def test_without_noise_the_payload_is_exact_and_ends_cut_in_full_motion_cost_little(
    record: Record, simulator: Simulator, begin: float, end: float, off: float
) -> None:
    """The filter errs there, alike in both recordings of a pair: the payload is off by up to 3e-3."""
    pair = record((2, 3, 5, 6), noise=np.zeros(6))
    problem = difference_weighing(
        simulator.robot, [between(pair.loaded, begin, end)], [between(pair.bare, begin, end)]
    )
    assert payload_estimate(problem, 3).ten == pytest.approx(LOAD.vector, abs=off)


def test_a_constant_torque_and_coulomb_friction_that_changed_do_not_matter(
    record: Record, simulator: Simulator
) -> None:
    pair = record((2, 3, 5, 6))
    qd = np.gradient(pair.loaded.q, pair.loaded.t, axis=0)
    changed = pair.loaded.torque + np.array([0, 9, 5, 0, 3, 1]) + np.array([0, 6, 3, 0, 2, 1]) * np.sign(qd)
    changed_pair = Pair(pair.bare, replace(pair.loaded, torque=changed))
    first, second = (weighed(simulator.robot, each_pair) for each_pair in (pair, changed_pair))
    assert np.flatnonzero(short(first.problem).held.sigma).tolist() == [1, 2]  # counted from 0
    assert not short(second.problem).held.sigma.any()  # told by the recordings themselves
    assert second.mass == pytest.approx(first.mass, abs=2.0 * first.spread.mass)
    assert np.abs(second.com - first.com).max() < 2.0 * first.spread.com.max()
    assert second.mass == pytest.approx(LOAD.mass, abs=4.0 * second.spread.mass)
    assert abs(second.evidence.agreement[0].mass - LOAD.mass) > 0.1  # what plain differences make of it


def test_a_constant_torque_within_the_allowance_is_in_the_interval(
    record: Record, simulator: Simulator, arm: ShortMotion
) -> None:
    """The allowance adds what the mass changes by when constant torques differ by as much."""
    motion, payload = short(arm), payload_estimate(arm, 3)
    torques = motion.held
    assert torques.sigma[1] == pytest.approx(OFFSET_SHARE * simulator.robot.parameters["FS2"], rel=0.1)
    pair = record((2, 3, 5, 6))
    moved = np.zeros(10)
    for j in np.flatnonzero(torques.sigma):
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
    draw, pair = np.random.default_rng(0), record((2, 3, 5, 6), noise=0.0 * NOISE)
    logs = []
    for recording, torque in zip(
        pair, (0.0, share * OFFSET_SHARE * simulator.robot.parameters["FS2"]), strict=True
    ):
        slow = 0.03 * NOISE * lasting(draw.standard_normal(recording.torque.shape), 125.0, warm=False)
        logs.append(replace(recording, torque=recording.torque + slow + torque * np.eye(6)[1]))
    motion = short(difference_weighing(simulator.robot, logs[1:], logs[:1]))
    assert np.flatnonzero(motion.held.sigma).tolist() == ([1, 2] if held else [])


def test_an_order_that_takes_a_drift_off_leaves_no_scatter() -> None:
    """Unloaded, loaded, loaded, unloaded: the payload comes after its partner, then before it."""
    order = Order("by their clock", "hour", np.arange(4.0), np.array([1.0, -1.0]))
    repeats = Repeats.made("ab", (5.1, 4.9), (0.02, 0.02), order)
    assert repeats.drift_per_recording == pytest.approx(0.1)
    assert (repeats.excess, repeats.drifts) == (1.0, False)
    assert Repeats.made("ab", (5.1, 4.9), (0.02, 0.02)).excess > 5.0


def test_the_drift_of_four_recordings_of_every_joint_is_told(rx90: Robot) -> None:
    """Torques grow by 5 % in an hour: a pair is wrong by as much, the other way than the second; both are not."""
    motion = random_via_points(rx90, 12, seed=3).motion(100.0)
    body = InertialParameters.from_com(4.0, [0.02, -0.01, 0.08], 0.01 * np.eye(3))
    order: dict[str, list[Recording]] = {"A": [], "B": []}
    for k, kind in enumerate("ABBA"):
        t = motion.t + k * (motion.t[-1] + 60.0)
        torque = np.array(Simulator(rx90).measure(motion, body if kind == "B" else None).torque)
        torque *= 1.0 + 0.05 / 3600.0 * (t[:, None] - 1.5 * motion.t[-1] - 90.0)
        torque += 0.01 * torque.std(axis=0) * np.random.default_rng(k).standard_normal(torque.shape)
        order[kind].append(Recording(t, motion.q, torque, None, f"{kind}{k}", gain_sigma=0.0))
    result = identify_payload(rx90, order["B"], order["A"])
    repeats = result.repeats
    assert repeats
    assert repeats.order == "unloaded, loaded, loaded, unloaded by their clock"
    first, second = repeats.masses
    assert first
    assert second
    assert first > 4.01 > 3.99 > second
    assert result.mass.value == pytest.approx(4.0, abs=0.01)
    # The answer with its problem can be handed to another process.
    assert pickle.loads(pickle.dumps(result.working)).result.mass.value == result.mass.value


def test_repeats_spread_and_drift_as_their_masses_do() -> None:
    masses = [5.0, 5.12, 5.19]
    repeats = Repeats.made("abc", masses, (0.1, 0.1, 0.1))
    assert repeats.spread == pytest.approx(np.std(masses, ddof=1))
    assert repeats.drift_per_recording == pytest.approx(0.095)
    assert not repeats.drifts


@pytest.mark.long
def test_a_drift_is_told_and_widens(record: Record, simulator: Simulator) -> None:
    """Torques that grow by 3 % from one recording to the next."""
    pairs = [record((2, 3, 5, 6), seed) for seed in range(4)]
    loaded = [replace(p.loaded, torque=(1.0 + 0.03 * k) * p.loaded.torque) for k, p in enumerate(pairs)]
    answer = answer_payload(difference_weighing(simulator.robot, loaded, [p.bare for p in pairs]))
    assert answer.evidence.repeats is not None
    assert answer.evidence.repeats.drifts
    assert answer.evidence.repeats.drift_per_recording is not None
    assert answer.evidence.repeats.drift_per_recording > 0.1
    assert answer.evidence.repeats.excess > 1.5
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
    ripples = short(rippled.problem).ripple
    assert {ripple.joint for ripple in ripples} >= {2, 3}
    clear = [ripple for ripple in ripples if ripple.joint in (2, 3)]
    assert all(ripple.waves == pytest.approx(36.0, abs=1.5) for ripple in clear)
    assert all(ripple.amplitude == pytest.approx(size[ripple.joint - 1], rel=0.3) for ripple in clear)
    assert rippled.mass == pytest.approx(plain.mass, abs=plain.spread.mass)
    low, high = rippled.intervals[0]
    assert low < LOAD.mass < high


def test_with_a_scale_the_wrist_alone_will_do(record: Record, simulator: Simulator) -> None:
    rules = (PossibleBody(), KnownMass(7.02, 0.02))
    answer = weighed(simulator.robot, record((4, 5, 6)), constraints=rules)
    assert answer.evidence.judged["mass"][0] == "weighed"
    assert answer.mass == pytest.approx(7.02, abs=1e-3)
    assert not answer.result.best_free.weighed
    assert all(group.mass is None for group in answer.evidence.by_joints.masses)
    assert np.abs(answer.com - LOAD.com).max() < 0.02
    # 0.02 kg of the scale is all that is unsure about it
    assert answer.spread.mass == pytest.approx(0.02)


def test_stand_ins_are_the_bodies_they_say() -> None:
    """A box and a cylinder of many points."""
    draw = np.random.default_rng(0)
    points = draw.uniform(-0.5, 0.5, (200_000, 3)) * [0.06, 0.08, 0.35]
    box = StandIn.parse("box:60x80x350")
    assert box.body(2.0, np.zeros(3)).inertia_com == pytest.approx(inertia(points, 2.0), abs=2e-4)
    inside = draw.uniform(-0.5, 0.5, (300_000, 3)) * [0.1, 0.1, 0.3]
    inside = inside[np.hypot(inside[:, 0], inside[:, 1]) <= 0.05]
    cylinder = StandIn.parse("Cylinder:100x300")
    assert cylinder.body(3.0, np.zeros(3)).inertia_com == pytest.approx(inertia(inside, 3.0), abs=2e-4)
    assert cylinder.body(3.0, np.array([0.0, 0.1, 0.2])).physically_consistent


def inertia(points: Array, mass: float) -> Array:
    centred = points - points.mean(axis=0)
    squares = centred.T @ centred / len(points)
    return np.asarray(mass * (np.trace(squares) * np.eye(3) - squares))


def test_a_stand_in_fills_what_is_missing_only(record: Record, simulator: Simulator) -> None:
    light = InertialParameters.from_com(1.0, [0.0, 0.0, 0.05], 1e-3 * np.eye(3))
    body = StandIn.parse("box:60x60x350")
    plain = weighed(simulator.robot, record((2, 3, 5, 6), load=light)).result
    result = plain.assuming(body)
    assert (result.inertia.use, result.inertia.why) == ("assumed", body.description)
    assert result.assumed
    assert result.working is plain.working
    assumed = InertialParameters(numbers(result.assumed.parameters))
    assert assumed.inertia_com == pytest.approx(body.body(plain.mass.value, plain.com.value).inertia_com, abs=1e-12)
    assert result.inertia.value == pytest.approx(assumed.inertia_com)
    assert assumed.com == pytest.approx(plain.com.value)
    heavy = InertialParameters.from_com(20.0, [0.0, 0.0, 0.1], np.eye(3))
    measured = weighed(simulator.robot, record((2, 3, 5, 6), load=heavy)).result
    assert measured.assuming(body) is measured
    assert measured.working.evidence.judged["inertia"][0] == "use"


SETTINGS = Processing(100.0, 10.0, 4)
LATER = 0.37  # s, of the loaded recording's clock


@pytest.fixture(scope="module")
def pair(rx90: Robot, payload: InertialParameters, wander: Callable[..., Motion]) -> tuple[Recording, Recording]:
    """Without and with payload, the same motion."""
    motion, arm = wander(6, 3, 22), Simulator(rx90)
    bare, heavy = (arm.record(motion, load, [0.2] * 6, k) for k, load in enumerate((None, payload)))
    return (
        Recording(bare.t, bare.q, bare.torque, source="bare.csv"),
        Recording(heavy.t + LATER, heavy.q, heavy.torque, source="heavy.csv"),
    )


def without_rows(recording: Recording, *gaps: tuple[float, float]) -> list[Recording]:
    """The pieces of a recording that lacks the rows between some shares of its time."""
    t = recording.t - recording.t[0]
    keep = t >= 0.0
    for low, high in gaps:
        keep &= (t < low * t[-1]) | (t > high * t[-1])
    rest = Recording(recording.t[keep], recording.q[keep], recording.torque[keep], source=recording.source)
    return list(cut(rest, *pieces(rest.t, SETTINGS.cutoff, rest.source)))


@pytest.mark.parametrize(
    ("bare_gaps", "heavy_gaps", "count"),
    [((), ((0.5, 0.53),), 2), (((0.4, 0.43),), (), 2), (((0.3, 0.33), (0.7, 0.72)), ((0.5, 0.53),), 4)],
    ids=["loaded", "unloaded", "both"],
)
def test_method_3_compares_what_both_have(
    bare_gaps: tuple[tuple[float, float], ...],
    heavy_gaps: tuple[tuple[float, float], ...],
    count: int,
    pair: tuple[Recording, Recording],
    rx90: Robot,
    payload: InertialParameters,
) -> None:
    bare, heavy = without_rows(pair[0], *bare_gaps), without_rows(pair[1], *heavy_gaps)
    assert len(bare) != len(heavy)
    problem = payload_problem(rx90, heavy, bare, settings=Settings(SETTINGS, robust=False))
    assert len(problem.source.pairs) == count
    assert [each.lag for each in problem.source.pairs] == pytest.approx([LATER] * count, abs=2e-3)
    assert problem.source is not None
    text = " ".join(note for each in (*problem.source.loaded, *problem.source.unloaded) for note in each.notes)
    assert "so that method 3 compares what both have" in text
    estimate = payload_estimate(problem, 3)
    assert estimate.mass == pytest.approx(payload.mass, abs=4.0 * float(estimate.estimate.larger_sigma[9]))
    assert float(estimate.estimate.larger_sigma[9]) < 0.05


def test_pairs_and_other_motions_stay_as_they_are(pair: tuple[Recording, Recording]) -> None:
    bare, heavy = pair
    assert cut_alike([heavy], [bare], SETTINGS) == ((heavy,), (bare,), (None,))
    pieces_of = without_rows(heavy, (0.5, 0.53))
    backwards = Recording(bare.t, bare.q[::-1], bare.torque[::-1], source="other.csv")
    assert cut_alike(pieces_of, [backwards], SETTINGS)[:2] == (tuple(pieces_of), (backwards,))


ROBOT = invented.robot("ur10e")
HEAVY = InertialParameters.from_com(5.0, [0.01, -0.02, 0.1], np.diag([0.03, 0.03, 0.02]))


@cache
def sagging(mrad: float, wide: bool = False) -> tuple[Recording, Recording]:
    """Recordings without noise under a controller without integral action."""
    pose = (0.0, -60.0, 90.0, -120.0, -90.0, 0.0)
    plan: Plan = random_via_points(ROBOT, 6, 1) if wide else near_pose((2, 3, 5, 6), pose)
    controller = replace(CONTROLLERS["proportional"], rate=100.0).sagging(ROBOT, HEAVY, [plan], 1e-3 * mrad)
    tasks = [Task("bare", plan), Task("loaded", plan, HEAVY)]
    bare, loaded = (run.recording for run in run_experiment(ROBOT, tasks, no_disturbances(6), 0, controller).runs)
    return bare, loaded


@pytest.mark.long
@pytest.mark.parametrize("mrad", [2.0, 4.0])
def test_what_a_sag_changes_is_taken_off_and_a_quarter_of_it_is_unsure(mrad: float) -> None:
    bare, loaded = sagging(mrad)
    problem = difference_weighing(ROBOT, [loaded], [bare])
    estimate = payload_estimate(problem, 3).estimate
    posed = problem.posed()
    (levels, path) = posed.fixed
    assert path.names == (PATH,)
    as_measured = replace(posed, fixed=(levels, path._replace(values=np.array([-1.0]))))
    plain = as_measured.solved(estimate.weights).values
    change = plain - estimate.values
    assert abs(estimate["M_L"] - HEAVY.mass) < 0.6 * abs(plain[9] - HEAVY.mass)
    assert abs(estimate["M_L"] - HEAVY.mass) < 4e-4 * mrad * HEAVY.mass
    lasting = posed.lasting(estimate.weights)
    exact = replace(posed, fixed=(levels, path._replace(lasting=np.zeros((1, 1)))))
    quarter = lasting - exact.lasting(estimate.weights)
    assert quarter == pytest.approx(np.outer(change, change) / 16.0, rel=1e-6, abs=1e-12)


def test_a_pair_is_refused_by_the_rms_of_the_joint_that_differs_most() -> None:
    """Not by a single sample, on both sides of the limit; 10 mrad by default."""
    bare, loaded = sagging(9.0)
    pair = aligned(bare, loaded, 100.0, 0.05)
    each = np.sqrt(np.mean((pair.loaded.q - pair.unloaded.q) ** 2, axis=0))
    assert pair.rms_mismatch == pytest.approx(each.max())
    assert pair.max_mismatch > 1.2 * pair.rms_mismatch
    assert aligned(bare, loaded, 100.0, 1.001 * pair.rms_mismatch).lag == pair.lag
    with pytest.raises(InputError, match=rf"q{np.argmax(each) + 1} differs by .* \(rms, limit.*max-mismatch"):
        aligned(bare, loaded, 100.0, 0.999 * pair.rms_mismatch)
    assert ROBOT.processing.max_mismatch == 0.01
    farther = replace(loaded, q=bare.q + 1.6 * (loaded.q - bare.q))
    with pytest.raises(InputError, match=r"rms, limit 0\.01"):
        difference_weighing(ROBOT, [farther], [bare])


PROCESSING = Processing(cutoff=10.0, rate=100.0, decimate=2, max_mismatch=0.01)
Problem = Callable[..., LongMotion]


@pytest.fixture(scope="module")
def paired(
    simulated: Callable[[str], Simulator], wander: Callable[..., Motion], payload: InertialParameters
) -> Problem:
    """A pair of an arm: how far the loaded path is off [rad, rms], and its friction, relative, 1 sigma."""

    def problem(
        name: str = "rx90", apart: float = 0.0, friction: float = 0.0, change: float = FRICTION_CHANGE
    ) -> LongMotion:
        simulator = simulated(name)
        robot, motion = simulator.robot, wander(6, 4, points=20)
        turn = 2.0 * np.pi * 0.3
        sag = np.sqrt(2.0) * apart * np.sin(turn * motion.t)[:, None] * np.eye(6)[1]
        speed = np.sqrt(2.0) * apart * turn * np.cos(turn * motion.t)[:, None] * np.eye(6)[1]
        lower = Motion(motion.t, motion.q + sag, motion.qd + speed, motion.qdd - turn**2 * sag)
        draw = np.random.default_rng(5)
        another = {
            key: value * (1.0 + friction * float(draw.standard_normal()) * key.startswith(("FS", "FV")))
            for key, value in robot.parameters.items()
        }
        bare = simulator.record(motion, None, [0.3] * 6, 1)
        loaded = simulator.record(lower, payload, [0.3] * 6, 2, parameters=another)
        return payload_problem(robot, [loaded], [bare], settings=Settings(PROCESSING, friction_change=change))

    return problem


@pytest.mark.parametrize("name", ["rx90", "irb120", "ur10e"])
def test_friction_that_is_another_one_under_load_hardly_moves_method_3(
    name: str, paired: Problem, payload: InertialParameters
) -> None:
    size = payload.mass * np.array([0.45, 0.45, 0.45, 1.0])
    errors = [
        np.linalg.norm((payload_estimate(problem, 3).ten - payload.vector)[6:] / size)
        for problem in (paired(name, friction=0.2), paired(name, friction=0.2, change=0.0))
    ]
    assert errors[0] < 0.5 * errors[1], errors


def test_one_path_is_answered_by_method_3(paired: Problem) -> None:
    answer = answer_payload(paired())
    assert answer.recommended.method == answer.free.method == 3
    assert "one path (within 0.0" in answer.recommendation[1]


def test_a_path_that_sags_is_answered_by_method_4(paired: Problem) -> None:
    problem = paired(apart=2.0 * ONE_PATH)
    assert problem.difference is not None
    method, reason = recommended_method(problem, (1, 2, 3, 4))
    assert (method, reason[:11]) == (4, "no pair fol")
    assert recommended_method(paired(apart=0.5 * ONE_PATH), (1, 2, 3, 4))[0] == 3
    assert recommended_method(problem, (1, 2, 3))[0] == 3
