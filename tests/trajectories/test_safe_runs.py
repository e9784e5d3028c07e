"""No body within bounds breaks a limit: in a run and between its samples, in its rehearsal, up a ladder."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.model import InertialParameters, Motion, Robot, load_robot, robot_names, stand_in
from dynident.tests.selection import cases
from dynident.tests.trajectories.safe_runs import (
    RATE,
    Case,
    drawn_bodies,
    drawn_shares,
    held_case,
    own_torque,
    rest_case,
    seen_of,
    worst_shares,
)
from dynident.trajectories import (
    Design,
    DesignProblem,
    Fourier,
    JointBounds,
    Loads,
    NearGoal,
    NearShape,
    PayloadSet,
    ViaPoints,
    build_design,
    solve_design,
)
from dynident.trajectories.design.score import (
    FINER,
    REHEARSAL,
    harder,
    holding_torques,
    kept_throughout,
    missed_on_run,
    score_motion,
    speed_ladder,
)
from dynident.trajectories.motions.family import Plan, Samples

RUNS = (("ur10e", 0), ("ur10e", 1), ("ur10e", 2), ("panda", 0), ("rx90", 0))
"""Six axes about three poses; seven axes with torques of the link side; coupled drives and a spring."""


@pytest.mark.long
@pytest.mark.parametrize(("arm", "pose"), RUNS)
def test_limits_hold_for_every_body_and_one_is_active(arm: str, pose: int) -> None:
    """By the arm's own regressor, on another grid; torque limits are lowered until one is active."""
    draw = np.random.default_rng(pose)
    free = held_case(stand_in.rehearsed(load_robot(arm)), 0.5, 3.0, draw)
    unsafe = solve_design(free.problem(None), seed=pose, starts=1)
    case = free.lowered(unsafe)
    problem = case.problem(case.payloads)
    safe = solve_design(problem, seed=pose + 1, starts=1)
    assert safe.feasible
    figures = seen_of(case, safe, draw)
    assert figures.violations == 0
    assert 0.99 <= figures.reached <= 1.0
    assert figures.outside > 1.0
    fast = safe.motion(500.0)
    assert score_motion(problem, fast).feasible
    assert "torque" in score_motion(case.problem(case.wider), fast).violations[0]
    assert not score_motion(problem, unsafe.motion(500.0)).feasible


KINDS = ("ur10e", "panda", "rx90")
"""Six axes; seven axes with torques of the link side; coupled drives and a spring."""
ARM = stand_in.rehearsed(load_robot("ur10e"))
BOUNDS = JointBounds.of(ARM)
EXPECTED = InertialParameters.from_com(3.0, [0.0, 0.0, 0.1], 0.009 * np.eye(3))
GOAL = NearGoal(0.007 * BOUNDS.torque, 10.0, EXPECTED)
HELD = np.radians([0.0, -60.0, 90.0, -120.0, -90.0, 0.0])
SHAPE = NearShape(HELD[None], (2, 3, 5, 6), np.full(4, np.radians(30.0)), 8.0)
SET = PayloadSet.within(8.0, 0.15, (0.0, 0.0, 0.1))


def bearing(payloads: PayloadSet | InertialParameters) -> DesignProblem:
    return build_design(ARM, SHAPE, GOAL, bounds=BOUNDS, loads=Loads(ARM.parameters, payloads))


@pytest.fixture(scope="module")
def fast() -> Fourier:
    """The best motion for 3 kg, which 8 kg are too much for."""
    design: Design = solve_design(bearing(EXPECTED), seed=0, starts=1)
    assert isinstance(design.plan, Fourier)
    return design.plan


def sigma(run: Fourier) -> float:
    return GOAL.predicted(ARM, run, SHAPE.joints).mass


def test_a_light_set_needs_one_run(fast: Fourier) -> None:
    only = speed_ladder(bearing, SET.lighter(1.0), fast, 0.5, sigma)
    assert [(rung.speed, rung.mass) for rung in only] == [(1.0, 1.0)]


def test_what_no_speed_bears_is_refused(fast: Fourier) -> None:
    heavy = PayloadSet(40.0, SET.centre, SET.axes)
    with pytest.raises(InputError, match="does not bear 40 kg everywhere within bounds"):
        speed_ladder(bearing, heavy, fast, EXPECTED.mass, sigma)


def test_runs_that_tell_nothing_are_refused(fast: Fourier) -> None:
    with pytest.raises(InputError, match="bounds the mass by 8 kg, which allows no faster one"):
        speed_ladder(bearing, SET, fast, EXPECTED.mass, lambda run: np.inf)


@pytest.mark.long
@pytest.mark.parametrize("arm", KINDS)
def test_arms_of_each_kind_climb(arm: str) -> None:
    """The motion is for half of the mass allowed, on limits that it just keeps; the whole needs a slower one."""
    free = held_case(stand_in.rehearsed(load_robot(arm)), 0.6, 12.0, np.random.default_rng(0))
    light, expected = free.payloads.lighter(0.5 * free.payloads.mass), 0.2 * free.payloads.mass
    design = solve_design(free.problem(light), seed=0, starts=1)
    fast = design.plan
    assert isinstance(fast, Fourier)
    needed, holding = (
        worst_shares(free.robot, run, payloads, np.ones(free.robot.n))
        for run, payloads in ((fast.motion(200.0), light), (fast.slowed(0.02).motion(5.0), free.payloads))
    )
    limits = np.minimum(free.bounds.torque, np.maximum(1.02 * needed, 1.1 * holding))
    case = free._replace(bounds=replace(free.bounds, torque=limits))

    def sigma(run: Fourier) -> float:
        return case.goal.predicted(case.robot, run, case.shape.joints).mass

    rungs = speed_ladder(case.problem, case.payloads, fast, expected, sigma)
    assert len(rungs) >= 2
    assert rungs[0].mass == case.payloads.mass
    assert rungs[-1].duration == fast.duration
    for rung, after in pairwise(rungs):
        bearable = case.payloads.lighter(rung.mass)
        slow, faster = (fast.slowed(step.speed).motion(200.0 * step.speed) for step in (rung, after))
        assert 0.99 <= worst_shares(case.robot, slow, bearable, limits).max() <= 1.0 + 1e-3
        assert worst_shares(case.robot, faster, bearable, limits).max() > 1.0
        assert after.mass == rung.bound
    last = case.payloads.lighter(rungs[-1].mass)
    assert worst_shares(case.robot, fast.motion(200.0), last, limits).max() <= 1.0 + 1e-3


UNSAFE = 4
"""Poses of the UR10e where a motion that keeps lowered limits at full speed breaks one in its rehearsal."""


def a_case(arm: str, pose: int) -> Case:
    return held_case(stand_in.rehearsed(load_robot(arm)), 0.5, 4.0, np.random.default_rng(pose))


@pytest.mark.parametrize("arm", cases(KINDS, lambda arm: arm == "ur10e"))
@pytest.mark.parametrize("bounded", [False, True])
def test_values_are_those_of_the_slow_run_and_slopes_those_of_differences(arm: str, bounded: bool) -> None:
    case, draw = a_case(arm, 0), np.random.default_rng(1)
    problem = case.problem(case.payloads if bounded else None)
    own = [limit for limit in problem.limits if limit.kind == "torque"]
    slow = problem.with_slow_torques(REHEARSAL).limits[len(problem.limits) :]
    x = problem.family.random(draw)
    plan = problem.family.plan(x)
    assert isinstance(plan, Fourier)
    t = np.linspace(0.0, plan.period, 52)[1:-1]
    ways = (plan.at(t), plan.slowed(REHEARSAL).at(t / REHEARSAL))
    fast, run = (Samples(np.ones(len(t)), *states) for states in ways)
    at_fast, at_run = (problem.kernel.state(samples) for samples in (fast, run))
    state = problem.state(x, 0.05)
    slopes, step, h = Samples(*map(np.zeros_like, state)), draw.standard_normal(len(x)), 1e-6
    ends = [problem.state(x + sign * h * step, 0.05) for sign in (1.0, -1.0)]
    total = 0.0
    for limit, of_run in zip(slow, own, strict=True):
        assert np.allclose(limit.values(at_fast), of_run.values(at_run), atol=1e-9)
        assert not np.allclose(limit.values(at_fast), of_run.values(at_fast), atol=1e-3)
        weights = draw.standard_normal(limit.values(state).shape)
        limit.measure(state)[1](weights, slopes)
        total += float(((limit.values(ends[0]) - limit.values(ends[1])) * weights).sum()) / (2.0 * h)
    assert total == pytest.approx(problem.family.pullback(x, slopes) @ step, rel=1e-4)


def weak(case: Case, seed: int) -> Case:
    """Torque limits of 85 % of what a motion for no payload needs, yet 10 % above what holds the pose."""
    unsafe = solve_design(case.problem(None), seed=seed, starts=1)
    fast = worst_shares(case.robot, unsafe.motion(RATE), case.payloads, np.ones(case.robot.n))
    friction = np.array([case.robot.parameters[f"FS{j + 1}"] for j in range(case.robot.n)])
    needed = 1.1 * (holding_torques(case.problem(case.payloads), case.shape.poses) + friction)
    torque = np.minimum(case.bounds.torque, np.maximum(0.85 * fast, needed))
    return case._replace(bounds=replace(case.bounds, torque=torque))


@pytest.mark.long
def test_a_motion_is_found_whose_rehearsal_keeps_its_limits() -> None:
    """By bodies in the arm's own regressor, in the run and in its rehearsal; a heavier one breaks a limit there."""
    case = weak(a_case("ur10e", UNSAFE), UNSAFE)
    safe = solve_design(case.problem(case.payloads), seed=UNSAFE, starts=1)
    assert safe.feasible
    assert isinstance(safe.plan, Fourier)
    slow, limits = safe.plan.slowed(REHEARSAL).motion(50.0), case.bounds.torque
    bodies = drawn_bodies(case.payloads, 2000, np.random.default_rng(2))
    for motion in (safe.motion(500.0), slow):
        assert drawn_shares(case.robot, motion, bodies, limits).max() <= 1.0
        assert worst_shares(case.robot, motion, case.payloads, limits).max() <= 1.0
    heavier = replace(case.payloads, mass=1.1 * case.payloads.mass)
    missed = {limit.name for limit in score_motion(case.problem(heavier), slow).limits if limit.violation > 0.0}
    assert any(name.startswith("torque") for name in missed)


POSE = np.radians([0.0, -60.0, 90.0, -120.0, -90.0, 0.0])
SHORT = NearShape(POSE[None], (2, 3, 5, 6), np.full(4, np.radians(30.0)), 4.0)
BODY = InertialParameters.from_com(3.0, [0.0, 0.0, 0.1], 0.009 * np.eye(3))


def problem(torque: Array) -> DesignProblem:
    goal = NearGoal(0.007 * BOUNDS.torque, 10.0, BODY)
    return build_design(ARM, SHORT, goal, bounds=replace(BOUNDS, torque=torque), loads=Loads(ARM.parameters))


FREE = problem(BOUNDS.torque)
X = FREE.family.random(np.random.default_rng(10))
PLAN = FREE.family.plan(X)


def peaks(t: Array) -> Array:
    """Largest torque of each joint at some moments, by Newton and Euler."""
    return np.asarray(np.abs(own_torque(ARM, Motion(t, *PLAN.at(t)))).max(axis=0))


def at_turns() -> Array:
    """Moments just before and after each turn, by bisection."""
    t = np.linspace(0.0, PLAN.duration, 4001)
    moments = []
    for joint in (1, 2, 4, 5):
        speed = PLAN.at(t)[1][:, joint]
        for k in np.flatnonzero(speed[:-1] * speed[1:] < -1e-12):
            low, high = t[k], t[k + 1]
            for _ in range(40):
                middle = 0.5 * (low + high)
                same = PLAN.at(np.array([middle]))[1][0, joint] * speed[k] > 0.0
                low, high = (middle, high) if same else (low, middle)
            moments += [low - 1e-7, high + 1e-7]
    return np.sort(moments)


def test_a_torque_that_leaps_at_a_turn_is_seen() -> None:
    """The limit lies between what a grid sees and what the turns need: only the whole run misses it."""
    grid, turns = peaks(np.arange(0.0, PLAN.duration, 1.0 / 50.0)), peaks(at_turns())
    joint = int(np.argmax(turns / grid))
    assert turns[joint] > 1.0005 * grid[joint]
    torque = BOUNDS.torque.copy()
    torque[joint] = 0.5 * (grid[joint] + turns[joint])
    tight = problem(torque)
    assert score_motion(tight, PLAN.motion(50.0)).feasible
    missed = missed_on_run(tight, PLAN, 50.0)
    assert [check.worst for check in missed] == [f"joint {joint + 1}"]
    assert abs(missed[0].value) == pytest.approx(turns[joint], rel=1e-6)
    assert missed_on_run(FREE, PLAN, 50.0) == ()


class Way(Plan):
    """A run given by what it does at any moment."""

    def __init__(self, duration: float, states: Callable[[Array], tuple[Array, Array, Array]]) -> None:
        self._duration, self._states = duration, states

    @property
    def duration(self) -> float:
        return self._duration

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        return self._states(t)


def bent(robot: Robot) -> Array:
    """A pose about the middle of the ranges, in which a payload's mass shows."""
    bounds = JointBounds.of(robot)
    return bounds.middle + 0.15 * bounds.half


def assert_most_is_seen(robot: Robot, way: Way, joint: int, peak: float) -> None:
    """A limit 1 % below the peak is missed by the peak itself, which a grid of 50 Hz alone does not see."""
    t = np.arange(0.0, way.duration, 1.0 / 50.0)
    grid = np.abs(own_torque(robot, Motion(t, *way.at(t)))[:, joint - 1]).max()
    assert grid < (1.0 - 1e-4) * peak
    torque = np.where(np.arange(1, robot.n + 1) == joint, 0.99 * peak, np.inf)
    bounds, joints = JointBounds.of(robot), (2, 4, 6, 7) if robot.n == 7 else (2, 3, 5, 6)
    shape = NearShape(bent(robot)[None], joints, np.full(4, np.radians(30.0)), 4.0)
    goal = NearGoal(0.007 * bounds.torque, 10.0, BODY)
    tight = build_design(robot, shape, goal, bounds=replace(bounds, torque=torque), loads=Loads(robot.parameters))
    missed = missed_on_run(tight, way, 50.0)
    assert abs(missed[0].value) == pytest.approx(peak, rel=1e-4)


@pytest.mark.parametrize("name", robot_names())
def test_the_most_is_seen_where_a_joint_leaves_a_rest(name: str) -> None:
    """Friction has no sign at rest, where the acceleration of joint 1 is at its largest."""
    robot = stand_in.rehearsed(load_robot(name))

    def at(t: Array) -> tuple[Array, Array, Array]:
        states = np.zeros((3, len(t), robot.n))
        states[..., 0] = t**2 / 2.0 - 20.0 * t**3 / 3.0, t - 20.0 * t**2, 1.0 - 40.0 * t
        return states[0] + bent(robot), states[1], states[2]

    after = np.array([1e-6])
    assert_most_is_seen(robot, Way(0.04, at), 1, np.abs(own_torque(robot, Motion(after, *at(after))))[0, 0])


def test_the_most_is_seen_where_a_coupled_rotor_turns_round() -> None:
    """Joint 5 of an RX90 goes faster and faster, joint 6 against it, and their sum changes its sign at 1.013 s."""
    robot, turn = stand_in.rehearsed(load_robot("rx90")), 1.013

    def at(t: Array) -> tuple[Array, Array, Array]:
        fifth = np.stack([0.3 * t + 0.01 * t**2, 0.3 + 0.02 * t, 0.02 + 0.0 * t])
        both = np.stack([0.02 * turn * t - 0.01 * t**2, 0.02 * (turn - t), -0.02 + 0.0 * t])
        states = np.zeros((3, len(t), 6))
        states[..., 4], states[..., 5] = fifth, both - fifth
        return states[0] + bent(robot), states[1], states[2]

    before = np.array([turn - 1e-6])
    assert_most_is_seen(robot, Way(1.5, at), 5, np.abs(own_torque(robot, Motion(before, *at(before))))[0, 4])


def test_what_is_missed_by_little_is_eased_and_what_is_missed_by_much_is_told() -> None:
    most = peaks(np.union1d(np.linspace(0.0, PLAN.duration, 8001), at_turns()))
    score = score_motion(FREE, FREE.family.sample(X, FINER))
    for share, mended in ((0.998, True), (0.9, False)):
        tight = problem(np.where(np.arange(6) == 1, share * most, BOUNDS.torque))
        x, after, missed = kept_throughout(tight, X, score)
        assert (missed == ((), ())) == mended == (not np.array_equal(x, X))
        if mended:
            assert missed_on_run(tight, tight.family.plan(x), 900.0) == ()
            assert np.abs(x).max() == pytest.approx(np.abs(X).max(), rel=0.05)
            assert after.value > score.value
        else:
            assert harder(tight, missed) is None
            assert missed[0][0].relative == pytest.approx(1.0 / share - 1.0, rel=1e-3)


@pytest.mark.parametrize("name", cases(robot_names(), lambda name: name in ("rx90", "ur10e")))
def test_a_weighing_at_rest_keeps_its_limits_and_comes_from_both_sides(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On another grid than the search's; the prediction is the dense formula's; a seed gives one plan."""
    monkeypatch.setenv("DYNIDENT_NO_COMPILER", "1")
    case = rest_case(stand_in.rehearsed(load_robot(name)), 6)
    design = solve_design(case.problem, seed=1, starts=1)
    plan, bounds, payload = design.plan, case.bounds, case.goal.expected.vector
    assert isinstance(plan, ViaPoints)
    assert design.feasible
    assert plan.duration < 150.0
    motion = plan.motion(170.0)
    assert ((motion.q >= bounds.low - 1e-9) & (motion.q <= bounds.high + 1e-9)).all()
    assert (np.abs(motion.qd) <= 0.5001 * bounds.speed).all()
    assert (np.abs(motion.qdd) <= 0.5001 * bounds.acceleration).all()
    shares = drawn_shares(case.robot, motion, np.array([0.0 * payload, payload]), bounds.torque)
    assert shares.max() <= 1.0 + 1e-6
    assert case.problem.clear(motion.q[::5])
    # Wherever it stays for the time of a rest: first from below, then from above, with every joint.
    still = np.concatenate([[False], (np.abs(motion.qd) < 1e-12).all(axis=1), [False]])
    begins, ends = np.flatnonzero(np.diff(still.astype(int))).reshape(-1, 2).T
    held = ends - begins > 1.4 * 170.0
    assert held.sum() == 2 * case.shape.count
    poses = motion.q[begins[held]]
    assert poses[::2] == pytest.approx(poses[1::2], abs=1e-9)
    before = motion.q[begins[held] - 100]  # in the last move, of a second
    assert (np.sign(poses - before) == np.tile([[1.0], [-1.0]], (case.shape.count, 1))).all()
    spread = case.goal.predicted(case.robot, plan, case.shape.joints)
    assert spread.mass == pytest.approx(case.sigma(poses[::2])[3], rel=1e-6)
    again = solve_design(case.problem, seed=1, starts=1).plan
    assert isinstance(again, ViaPoints)
    assert np.array_equal(again.points, plan.points)
