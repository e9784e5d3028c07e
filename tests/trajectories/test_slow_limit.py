"""Limits that are active in the slow rehearsal alone: values, slopes, and motions that are found for them."""

from dataclasses import replace

import numpy as np
import pytest
from dynident.model import load_robot, stand_in
from dynident.tests.selection import cases
from dynident.tests.trajectories.bodies import drawn_bodies, drawn_shares, worst_shares
from dynident.tests.trajectories.safe_runs import RATE, Case, held_case
from dynident.trajectories import NearMotion, score_motion, solve_design
from dynident.trajectories.design.full_trajectory import REHEARSAL, harder, kept_throughout
from dynident.trajectories.design.limits import LimitCheck, State
from dynident.trajectories.design.score import FINER, holding_torques, score_samples
from dynident.trajectories.motions.family import Samples

KINDS = ("ur10e", "panda", "rx90")
"""Six axes; seven axes with torques of the link side; coupled drives and a spring."""
POSE = 4
"""Of the UR10e, where a motion that keeps lowered limits at full speed breaks one in its rehearsal."""


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
    assert isinstance(plan, NearMotion)
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
    case = weak(a_case("ur10e", POSE), POSE)
    safe = solve_design(case.problem(case.payloads), seed=POSE, starts=1)
    assert safe.feasible
    assert isinstance(safe.plan, NearMotion)
    slow, limits = safe.plan.slowed(REHEARSAL).motion(50.0), case.bounds.torque
    bodies = drawn_bodies(case.payloads, 2000, np.random.default_rng(2))
    for motion in (safe.motion(500.0), slow):
        assert drawn_shares(case.robot, motion, bodies, limits).max() <= 1.0
        assert worst_shares(case.robot, motion, case.payloads, limits).max() <= 1.0
    heavier = replace(case.payloads, mass=1.1 * case.payloads.mass)
    missed = {limit.name for limit in score_motion(case.problem(heavier), slow).limits if limit.violation > 0.0}
    assert any(name.startswith("torque") for name in missed)


def test_what_a_search_goes_on_with() -> None:
    """Rehearsals' torques as limits of their own; lower limits for a run; nothing for what a search sees itself."""
    case = a_case("ur10e", 0)
    problem = case.problem(case.payloads)
    x = problem.family.random(np.random.default_rng(0))
    _, _, missed = kept_throughout(problem, x, score_samples(problem, problem.family.sample(x, FINER)))
    little, much, touched = (
        (LimitCheck(name, "joint 2", 1.0, 1.0, share, share, -share),)
        for name, share in (("torque", 0.01), ("torque", 0.2), ("clearance", 0.01))
    )
    assert harder(problem, missed) is None
    assert harder(problem, (much, missed[1])) is None
    assert harder(problem, (missed[0], touched)) is None
    count = len(problem.limits)
    for outcome, share, more in (
        ((little, missed[1]), 0.985, 0),
        ((missed[0], much), 1.0, 1),
        ((little, much), 0.985, 1),
    ):
        further = harder(problem, outcome)
        assert further is not None
        assert len(further.limits) == count + more
        for before, after in zip(problem.limits, further.limits, strict=False):
            expected = share if before.kind == "torque" else 1.0
            assert np.allclose(after.high, expected * before.high)
