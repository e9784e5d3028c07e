"""The recommended method: the difference of one path, else all equations; friction under load in method 3."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from dynident.estimation import answer_payload, payload_estimate, payload_problem
from dynident.estimation.fit.settings import FRICTION_CHANGE, Settings
from dynident.estimation.payload.long_motion import LongMotion
from dynident.estimation.payload.methods import ONE_PATH, recommended_method
from dynident.model import InertialParameters, Motion, Processing
from dynident.trajectories import Simulator

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


@pytest.mark.parametrize("name", ["rx90", "irb120", "ur10e"])
def test_method_3_frees_no_friction_where_none_may_change(name: str, paired: Problem) -> None:
    problem = paired(name, change=0.0)
    assert not problem.friction
    estimate = payload_estimate(problem, 3).estimate
    assert problem.difference is not None
    alone = replace(problem, difference=problem.difference.select(problem.difference.columns[:11]))
    assert estimate.values == pytest.approx(payload_estimate(alone, 3).estimate.values, rel=1e-9)


def test_one_path_is_answered_by_method_3(paired: Problem) -> None:
    answer = answer_payload(paired())
    assert answer.recommended.method == answer.free.method == 3
    assert "one path, within 0.0" in answer.recommendation[1]


def test_a_path_that_sags_is_answered_by_method_4(paired: Problem) -> None:
    problem = paired(apart=2.0 * ONE_PATH)
    assert problem.difference is not None
    method, reason = recommended_method(problem, (1, 2, 3, 4))
    assert (method, reason[:11]) == (4, "no pair ran")
    assert recommended_method(paired(apart=0.5 * ONE_PATH), (1, 2, 3, 4))[0] == 3
    assert recommended_method(problem, (1, 2, 3))[0] == 3


def test_another_path_is_answered_by_method_4(paired: Problem) -> None:
    method, reason = recommended_method(paired(apart=20.0 * ONE_PATH), (1, 2, 4))
    assert (method, reason[:11]) == (4, "no pair ran")


def test_what_was_asked_for_needs_no_reason(paired: Problem) -> None:
    problem = paired()
    assert [recommended_method(problem, (method,)) for method in (1, 2, 3, 4)] == [
        (1, ""), (2, ""), (3, ""), (4, ""),
    ]  # fmt: skip
    assert recommended_method(problem, (1, 2, 4)) == (4, "")
