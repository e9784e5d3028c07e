"""Arms of each kind: no body within bounds breaks a limit, one comes to it, one outside does."""

import numpy as np
import pytest
from dynident.model import load_robot, stand_in
from dynident.tests.trajectories.safe_runs import held_case, seen_of
from dynident.trajectories import score_motion, solve_design

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
