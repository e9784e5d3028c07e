"""Moments between the samples of a search: turns of dry friction, ways between poses, the rehearsal."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.model import InertialParameters, Motion, Robot, load_robot, robot_names, stand_in
from dynident.tests.trajectories.safe_runs import own_torque
from dynident.trajectories import DesignProblem, JointBounds, Loads, NearGoal, NearShape, build_design, score_motion
from dynident.trajectories.design.full_trajectory import harder, kept_throughout, missed_on_run
from dynident.trajectories.design.score import FINER, score_samples
from dynident.trajectories.motions.family import Plan

ARM = stand_in.rehearsed(load_robot("ur10e"))
BOUNDS = JointBounds.of(ARM)
POSE = np.radians([0.0, -60.0, 90.0, -120.0, -90.0, 0.0])
SHAPE = NearShape(POSE[None], (2, 3, 5, 6), np.full(4, np.radians(30.0)), 4.0)
BODY = InertialParameters.from_com(3.0, [0.0, 0.0, 0.1], 0.009 * np.eye(3))


def problem(torque: Array) -> DesignProblem:
    goal = NearGoal(0.007 * BOUNDS.torque, 10.0, BODY)
    return build_design(ARM, SHAPE, goal, bounds=replace(BOUNDS, torque=torque), loads=Loads(ARM.parameters))


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
    score = score_samples(FREE, FREE.family.sample(X, FINER))
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
