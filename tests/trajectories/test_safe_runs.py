"""No body within bounds breaks a limit: in a run, in its slow rehearsal, and up a ladder of speeds."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.model import InertialParameters, load_robot, stand_in
from dynident.tests.selection import cases
from dynident.tests.trajectories.safe_runs import (
    RATE,
    Case,
    drawn_bodies,
    drawn_shares,
    held_case,
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
    build_design,
    score_motion,
    solve_design,
)
from dynident.trajectories.design.full_trajectory import REHEARSAL, speed_ladder
from dynident.trajectories.design.limits import State
from dynident.trajectories.design.score import holding_torques
from dynident.trajectories.motions.family import Samples

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
    safe = solve_design(problem, seed=pose, starts=1)
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
    at_fast, at_run = (State(samples, problem.kernel.entries(samples, 0.0)) for samples in (fast, run))
    state = problem.state(x, 0.05)
    slopes, step, h = State(Samples.zeros(state.samples), 0.0 * state.entries), draw.standard_normal(len(x)), 1e-6
    ends = [problem.state(x + sign * h * step, 0.05) for sign in (1.0, -1.0)]
    total = 0.0
    for limit, of_run in zip(slow, own, strict=True):
        assert np.allclose(limit.values(at_fast), of_run.values(at_run), atol=1e-9)
        assert not np.allclose(limit.values(at_fast), of_run.values(at_fast), atol=1e-3)
        weights = draw.standard_normal(limit.values(state).shape)
        limit.pullback(state, weights, slopes)
        total += float(((limit.values(ends[0]) - limit.values(ends[1])) * weights).sum()) / (2.0 * h)
    assert total == pytest.approx(problem.family.pullback(x, slopes.samples) @ step, rel=1e-4)


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
