"""A payload is answered in the robot's payload frame, and arms with sensors on the link side work alike."""

from collections.abc import Callable
from dataclasses import replace
from math import radians

import numpy as np
import pytest
from dynident.apps.report.sections.evidence import gain_error_notes
from dynident.estimation import (
    Gains,
    KnownMass,
    PayloadAnswer,
    PossibleBody,
    Settings,
    answer_payload,
    payload_problem,
)
from dynident.estimation.payload.result import frame_change
from dynident.estimation.payload.weighing import difference_weighing
from dynident.model import Drives, InertialParameters, Motion, Pose, Robot, mounted, standard_columns, with_tool
from dynident.model.frames import MOUNTS
from dynident.trajectories import RX90_NOISE, NearMotion, Simulator

NOISE = 0.3 * np.array(RX90_NOISE)
TOOL = Pose.from_rpy((0.03, -0.01, 0.12), (radians(180), 0.4, -0.2))


def simulator_of(robot: Robot) -> Simulator:
    known = {name: robot.parameters.get(name, 0.5) for name in standard_columns(robot)}
    return Simulator(replace(robot, parameters=known))


@pytest.mark.long
@pytest.mark.parametrize(("side", "mount"), [("motor", "floor"), ("link", "wall"), ("motor", "ceiling")])
def test_answer_stands_in_the_tool_frame(
    rx90: Robot, payload: InertialParameters, wander: Callable[..., Motion], side: str, mount: str
) -> None:
    """On the floor, the wall and the ceiling; with sensors before and behind the gear."""
    rpy = tuple(radians(angle) for angle in MOUNTS[mount])
    robot = with_tool(mounted(rx90, (rpy[0], rpy[1], rpy[2])), TOOL, "tool 1")
    if side == "link":
        robot = replace(robot, drives=Drives.on_link_side())
    simulator = simulator_of(robot)
    motion = wander(6, 4)
    bare, loaded = simulator.record(motion, None, [0.1] * 6, 1), simulator.record(motion, payload, [0.1] * 6, 2)
    problem = payload_problem(simulator.robot, [loaded], [bare], settings=Settings(robust=False))
    answer = answer_payload(problem)
    assert [estimate.method for estimate in answer.estimates] == [1, 2, 3, 4]
    for estimate in answer.estimates:
        assert estimate.frame == "tool 1"
        assert estimate.mass == pytest.approx(payload.mass, rel=2e-3)
        np.testing.assert_allclose(estimate.body.com, payload.com, atol=1e-3)
        # No standard deviation is of another frame: white noise is told right within a few sigma.
        off = np.abs(estimate.estimate.values - payload.vector) / estimate.estimate.sigma
        assert off.max() < 5.0


@pytest.mark.long
def test_friction_behind_link_side_sensors(
    rx90: Robot, payload: InertialParameters, wander: Callable[..., Motion]
) -> None:
    """Seals rub there as well: a file that says so explains the torque, one that does not leaves it over."""
    plain = replace(rx90, drives=Drives.on_link_side())
    rubbing = replace(plain, drives=replace(plain.drives, friction=True))
    simulator, motion = simulator_of(rubbing), wander(6, 4)
    bare, loaded = simulator.record(motion, None, [0.1] * 6, 1), simulator.record(motion, payload, [0.1] * 6, 2)
    first, second = (
        answer_payload(payload_problem(robot, [loaded], [bare], settings=Settings(robust=False)))
        for robot in (rubbing, plain)
    )
    assert first.robot_fit is not None
    assert second.robot_fit is not None
    assert first.robot_fit.relative < 0.3 * second.robot_fit.relative
    assert first.recommended.mass == pytest.approx(payload.mass, rel=2e-3)
    notes = " ".join(gain_error_notes(first.result.settings, first.gains))
    assert "Scales of the torque sensors are taken as exact: no residual shows their errors" in notes
    assert "rive gains" not in notes
    gain_notes = gain_error_notes(first.result.settings, Gains((0.01,)))
    assert gain_notes == ["Intervals include errors of the scales of the torque sensors: 1 % per joint."]


def test_robust_covariance_moves_along(
    rx90: Robot, payload: InertialParameters, wander: Callable[..., Motion]
) -> None:
    simulator = simulator_of(rx90)
    motion = wander(6, 4)
    bare, loaded = simulator.record(motion, None, [0.1] * 6, 1), simulator.record(motion, payload, [0.1] * 6, 2)
    robots = (simulator.robot, with_tool(simulator.robot, TOOL, "tool 1"))
    plain, tool = (
        answer_payload(payload_problem(robot, [loaded], [bare]), (3,)).estimates[0].estimate for robot in robots
    )
    T = frame_change(TOOL.inverse())
    assert plain.robust is not None
    assert tool.robust is not None
    np.testing.assert_allclose(tool.values, T @ plain.values, atol=1e-12)
    np.testing.assert_allclose(tool.robust.covariance, T @ plain.robust.covariance @ T.T, atol=1e-14)
    np.testing.assert_allclose(tool.covariance, T @ plain.covariance @ T.T, atol=1e-14)


@pytest.mark.parametrize("method", [1, 2, 3, 4])
def test_moving_the_flange_moves_the_answer(
    method: int, rx90: Robot, payload: InertialParameters, wander: Callable[..., Motion]
) -> None:
    """Values, both covariances, and the torques that are drawn from them."""
    simulator = simulator_of(rx90)
    motion = wander(6, 4)
    bare, loaded = simulator.record(motion, None, [0.1] * 6, 1), simulator.record(motion, payload, [0.1] * 6, 2)
    robots = simulator.robot, with_tool(simulator.robot, TOOL, "tool 1")
    problems = [payload_problem(robot, [loaded], [bare]) for robot in robots]
    same_but_for_the_frame(*(answer_payload(problem, (method,)) for problem in problems))


@pytest.mark.long
@pytest.mark.parametrize("joints", [(2, 3, 5, 6), (4, 5, 6), (6,)])
def test_moving_the_flange_moves_a_weighing(
    rx90: Robot, payload: InertialParameters, near: Callable[..., NearMotion], joints: tuple[int, ...]
) -> None:
    """Also where a scale gives the mass, and where one joint shows four of the ten."""
    simulator = simulator_of(rx90)
    motion = near(joints).motion(250.0)
    bare, loaded = simulator.record(motion, None, NOISE, 1), simulator.record(motion, payload, NOISE, 2)
    tool = TOOL if len(joints) > 1 else Pose.from_rpy((0.0, 0.0, 0.12), (0.0, 0.0, 0.7))
    scale = (KnownMass(7.025, 0.02),) if 2 not in joints else ()
    plain, moved = (
        answer_payload(difference_weighing(robot, [loaded], [bare]), constraints=(PossibleBody(), *scale))
        for robot in (simulator.robot, with_tool(simulator.robot, tool, "tool 1"))
    )
    assert moved.free.frame == "tool 1"
    assert moved.mass == pytest.approx(plain.mass, abs=0.01 * plain.spread.mass)
    if len(joints) > 1:
        same_but_for_the_frame(plain, moved)
        return
    columns = [6, 7]  # MX and MY turn into each other
    turn = frame_change(tool.inverse())[np.ix_(columns, columns)]
    np.testing.assert_allclose(moved.ten[columns], turn @ plain.ten[columns], atol=1e-9)
    assert np.isfinite(moved.ten).tolist() == np.isfinite(plain.ten).tolist()


def same_but_for_the_frame(plain: PayloadAnswer, moved: PayloadAnswer) -> None:
    T = frame_change(TOOL.inverse())
    plain_estimate, moved_estimate = plain.free.estimate, moved.free.estimate
    for a, b in ((plain_estimate, moved_estimate), (plain_estimate.robust, moved_estimate.robust)):
        assert a is not None
        assert b is not None
        C = T @ a.covariance @ T.T
        np.testing.assert_allclose(b.covariance, C, atol=1e-8 * np.abs(C).max())
    np.testing.assert_allclose(
        moved_estimate.values, T @ plain_estimate.values, atol=1e-6 * moved_estimate.sigma.min()
    )
    # The possible payload goes by the formula's correlations and the jackknife's deviations of each axis' own.
    assert moved.mass == pytest.approx(plain.mass, abs=0.01 * plain.spread.mass)
    for drawn, again in zip(plain.predictions, moved.predictions, strict=True):
        for before, after in zip(*(next(iter(each.curves.values())) for each in (drawn, again)), strict=True):
            np.testing.assert_allclose(after, before, atol=1e-3 * np.abs(before).max())


def test_gain_errors_move_along(rx90: Robot, payload: InertialParameters, wander: Callable[..., Motion]) -> None:
    """The gains' share of the covariance and the constrained payload stand in the tool's frame too."""
    simulator = simulator_of(rx90)
    motion = wander(6, 4)
    bare, loaded = simulator.record(motion, None, [0.1] * 6, 1), simulator.record(motion, payload, [0.1] * 6, 2)
    gains = Gains((0.02,), 0.01)
    plain, tool = (
        answer_payload(
            payload_problem(robot, [loaded], [bare], settings=Settings(robust=False)), (3,), gains=gains
        ).recommended
        for robot in (simulator.robot, with_tool(simulator.robot, TOOL, "tool 1"))
    )
    T = frame_change(TOOL.inverse())
    expected = T @ plain.result.free.covariance @ T.T
    np.testing.assert_allclose(tool.result.free.covariance, expected, atol=1e-7 * np.abs(expected).max())
    assert plain.sigma[9] == pytest.approx(tool.sigma[9], rel=1e-6)
    assert plain.mass == pytest.approx(tool.mass, rel=1e-6)
    assert tool.free.frame == "tool 1"


def test_frame_change_is_that_of_a_body(payload: InertialParameters) -> None:
    moved = payload.moved(TOOL.R, TOOL.p).vector
    np.testing.assert_allclose(frame_change(TOOL) @ payload.vector, moved, atol=1e-14)
    np.testing.assert_allclose(frame_change(TOOL.inverse()) @ moved, payload.vector, atol=1e-12)
