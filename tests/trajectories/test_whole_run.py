"""What a run misses between the samples of a search: turns of dry friction, ways between poses, the rehearsal."""

from dataclasses import replace

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.model import InertialParameters, Motion, load_robot, stand_in
from dynident.tests.trajectories.bodies import own_torque
from dynident.trajectories import (
    DesignProblem,
    JointBounds,
    Loads,
    NearGoal,
    NearMotion,
    NearShape,
    build_design,
    score_motion,
)
from dynident.trajectories.design import holding_torques, missed_on_run
from dynident.trajectories.design.score import FINER, score_samples
from dynident.trajectories.design.settle import drawn_back
from dynident.trajectories.design.whole_run import REHEARSAL, harder, kept_throughout

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


def test_what_is_missed_by_little_is_eased_and_what_is_missed_by_much_is_told() -> None:
    most = peaks(np.union1d(np.linspace(0.0, PLAN.duration, 8001), at_turns()))
    score = score_samples(FREE, FREE.family.sample(X, FINER))
    for share, mended in ((0.998, True), (0.9, False)):
        tight = problem(np.where(np.arange(6) == 1, share * most, BOUNDS.torque))
        outcome = kept_throughout(tight, X, score)
        assert (outcome.missed == ()) == mended == (not np.array_equal(outcome.x, X))
        if mended:
            assert missed_on_run(tight, tight.family.plan(outcome.x), 900.0) == ()
            assert np.abs(outcome.x).max() == pytest.approx(np.abs(X).max(), rel=0.05)
            assert outcome.score.value > score.value
        else:
            assert harder(tight, outcome) is None
            assert outcome.missed[0].relative == pytest.approx(1.0 / share - 1.0, rel=1e-3)


@pytest.mark.parametrize("times", [1.5, 2.0])
def test_a_motion_that_is_too_large_is_drawn_back_until_it_keeps_its_limits(times: float) -> None:
    """No further than a few steps; where no size helps it stays as it is."""
    large = times * X
    before, after = (score_samples(FREE, FREE.family.sample(x, FINER)) for x in (large, drawn_back(FREE, large)))
    assert not before.feasible
    assert after.feasible
    assert after.value > before.value
    assert min(limit.room for limit in after.limits) < 0.35
    hopeless = problem(0.5 * holding_torques(FREE, POSE[None]) + 1.0)
    assert np.array_equal(drawn_back(hopeless, large), large)


def test_the_rehearsal_counts() -> None:
    """A limit that the slow run breaks and the fast one keeps."""
    slow = PLAN.slowed(REHEARSAL) if isinstance(PLAN, NearMotion) else None
    assert slow is not None
    fast, holding = (
        peaks(np.linspace(0.0, PLAN.duration, 8001)),
        np.abs(own_torque(ARM, slow.motion(50.0))).max(axis=0),
    )
    score = score_samples(FREE, FREE.family.sample(X, FINER))
    loose = problem(np.maximum(fast, holding) * 1.01)
    assert kept_throughout(loose, X, score).missed == ()
    weak = problem(np.where(holding > 0.1, 0.97 * holding, BOUNDS.torque))
    assert {check.worst for check in missed_on_run(weak, slow, 50.0)} <= {
        check.worst for check in kept_throughout(weak, X, score).missed
    }


def test_a_share_of_the_limits_is_asked_for() -> None:
    lower = FREE.with_torque_share(0.5)
    full, half = (score_samples(task, FREE.family.sample(X)).limits for task in (FREE, lower))
    for before, after in zip(full, half, strict=True):
        share = 0.5 if before.name.startswith("torque") else 1.0
        assert after.limit == pytest.approx(share * before.limit)
        assert after.value == pytest.approx(before.value)
