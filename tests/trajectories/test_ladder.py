"""The ladder of speeds: each run bears what the one before leaves possible, by bodies put into the regressor."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.model import InertialParameters, load_robot, stand_in
from dynident.tests.trajectories.bodies import worst_shares
from dynident.tests.trajectories.safe_runs import held_case
from dynident.trajectories import (
    Design,
    DesignProblem,
    JointBounds,
    Loads,
    NearGoal,
    NearMotion,
    NearShape,
    PayloadSet,
    build_design,
    solve_design,
)
from dynident.trajectories.design.full_trajectory import speed_ladder

KINDS = ("ur10e", "panda", "rx90")
"""Six axes; seven axes with torques of the link side; coupled drives and a spring."""
ARM = stand_in.rehearsed(load_robot("ur10e"))
BOUNDS = JointBounds.of(ARM)
EXPECTED = InertialParameters.from_com(3.0, [0.0, 0.0, 0.1], 0.009 * np.eye(3))
GOAL = NearGoal(0.007 * BOUNDS.torque, 10.0, EXPECTED)
POSE = np.radians([0.0, -60.0, 90.0, -120.0, -90.0, 0.0])
SHAPE = NearShape(POSE[None], (2, 3, 5, 6), np.full(4, np.radians(30.0)), 8.0)
SET = PayloadSet.within(8.0, 0.15, (0.0, 0.0, 0.1))


def bearing(payloads: PayloadSet | InertialParameters) -> DesignProblem:
    return build_design(ARM, SHAPE, GOAL, bounds=BOUNDS, loads=Loads(ARM.parameters, payloads))


@pytest.fixture(scope="module")
def fast() -> NearMotion:
    """The best motion for 3 kg, which 8 kg are too much for."""
    design: Design = solve_design(bearing(EXPECTED), seed=0, starts=1)
    assert isinstance(design.plan, NearMotion)
    return design.plan


def sigma(run: NearMotion) -> float:
    return GOAL.predicted(ARM, run, SHAPE.joints).mass


def test_a_light_set_needs_one_run(fast: NearMotion) -> None:
    only = speed_ladder(bearing, SET.lighter(1.0), fast, 0.5, sigma)
    assert [(rung.speed, rung.mass) for rung in only] == [(1.0, 1.0)]


def test_what_no_speed_bears_is_refused(fast: NearMotion) -> None:
    heavy = PayloadSet(40.0, SET.centre, SET.axes)
    with pytest.raises(InputError, match="does not bear 40 kg everywhere within bounds"):
        speed_ladder(bearing, heavy, fast, EXPECTED.mass, sigma)


def test_runs_that_tell_nothing_are_refused(fast: NearMotion) -> None:
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
    assert isinstance(fast, NearMotion)
    needed, holding = (
        worst_shares(free.robot, run, payloads, np.ones(free.robot.n))
        for run, payloads in ((fast.motion(200.0), light), (fast.slowed(0.02).motion(5.0), free.payloads))
    )
    limits = np.minimum(free.bounds.torque, np.maximum(1.02 * needed, 1.1 * holding))
    case = free._replace(bounds=replace(free.bounds, torque=limits))

    def sigma(run: NearMotion) -> float:
        return case.goal.predicted(case.robot, run, case.shape.joints).mass

    rungs = speed_ladder(case.problem, case.payloads, fast, expected, sigma)
    assert len(rungs) >= 2
    assert rungs[0].mass == case.payloads.mass
    assert rungs[-1].motion is fast
    for rung, after in pairwise(rungs):
        bearable = case.payloads.lighter(rung.mass)
        slow, faster = (step.motion.motion(200.0 * step.speed) for step in (rung, after))
        assert 0.99 <= worst_shares(case.robot, slow, bearable, limits).max() <= 1.0 + 1e-3
        assert worst_shares(case.robot, faster, bearable, limits).max() > 1.0
        assert after.mass == rung.bound
    last = case.payloads.lighter(rungs[-1].mass)
    assert worst_shares(case.robot, fast.motion(200.0), last, limits).max() <= 1.0 + 1e-3
