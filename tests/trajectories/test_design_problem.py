"""Design problems: exact gradients and Jacobians, honest answers where there is none."""

from dataclasses import replace

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.model import INERTIAL, Robot, inverse_dynamics
from dynident.model.kernel.kernel import Kernel
from dynident.tests.conftest import CROOKED
from dynident.tests.trajectories.design_problems import (
    BOUNDS,
    GOALS,
    ROBOT,
    SCENE,
    SHAPES,
    constraint_jacobian,
    constraint_values,
    problem,
)
from dynident.trajectories import Earlier, FourierShape, Goal, JointBounds, Loads, ViaPointShape, build_design
from dynident.trajectories.design.descent import Lagrangian
from dynident.trajectories.simulation.simulator import parameter_vector


def derivative(function: object, x: Array, direction: Array, step: float = 2e-4) -> float:
    """Central differences of two steps, extrapolated (Richardson)."""
    assert callable(function)
    coarse, two = (
        (function(x + h * direction) - function(x - h * direction)) / (2.0 * h) for h in (step, 0.5 * step)
    )
    return float((4.0 * two - coarse) / 3.0)


@pytest.mark.parametrize("goal", GOALS)
@pytest.mark.parametrize("shape", SHAPES)
def test_gradient_is_the_derivative(goal: str, shape: str) -> None:
    """With the terms of every limit that bites: joints, torques of two loads, duration and obstacles."""
    bounds = JointBounds.of(ROBOT) if goal == "payload" else BOUNDS
    task = problem(goal, shape, bounds=bounds, **({} if shape in ("fixed", "fourier") else {"longest": 12.0}))
    draw = np.random.default_rng(0)
    x = task.family.random(draw) + 0.02 * draw.standard_normal(task.family.size)
    limits = Lagrangian(task, x, 3.0, 0.4)
    assert limits.violation(task.state(x, 0.5)) > 0.0
    value, slope = task.evaluate(x, 8.0, 0.5, limits)
    assert np.isfinite(value)
    direction = draw.standard_normal(len(x)) / np.sqrt(len(x))
    expected = derivative(lambda y: task.evaluate(y, 8.0, 0.5, limits)[0], x, direction)
    assert slope @ direction == pytest.approx(expected, rel=1e-6, abs=1e-6 * float(np.linalg.norm(slope)) / len(x))


def test_fixed_durations_leave_no_other(rx90: Robot) -> None:
    with pytest.raises(InputError, match="durations of the moves are fixed"):
        build_design(rx90, ViaPointShape(5, fixed=1.0, longest=10.0), Goal("cond", payload_only=True))


def test_limits_have_exact_jacobians() -> None:
    task = problem("d", "via", longest=12.0)
    task = replace(task, family=ViaPointShape(3, samples=3).family(ROBOT, BOUNDS))
    draw = np.random.default_rng(1)
    x = task.family.random(draw) + 0.05 * draw.standard_normal(task.family.size)
    J, direction, step = constraint_jacobian(task, x, 0.5), draw.standard_normal(task.family.size), 1e-5
    ahead, behind = (constraint_values(task, x + s * direction, 0.5) for s in (step, -step))
    difference = (ahead - behind) / (2.0 * step)
    assert J.shape == (len(difference), task.family.size)
    assert np.abs(J @ direction - difference).max() < 1e-6 * np.abs(difference).max()


@pytest.mark.long
def test_parameters_that_cannot_be_told_apart_are_named() -> None:
    with pytest.raises(InputError, match=r"rank 2 of 4\): XX1 has no effect; YY2 .* with ZZ1, XX2"):
        build_design(ROBOT, goal=Goal("cond", columns=("ZZ1", "XX2", "XX1", "YY2")))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Goal("e"), "'e' is not one of d, a, cond, cond-scaled"),
        (lambda: Goal("a"), "needs reference values"),
        (lambda: Goal("cond", interest=("FV1",)), "counts for d and a only"),
        (lambda: Goal("d", earlier=Earlier(("FV1",), np.eye(1))), "data length to come"),
        (lambda: build_design(ROBOT, goal=Goal(columns=("FV9",))), "FV9"),
        (lambda: build_design(ROBOT, goal=Goal(noise=(1.0,))), "6 positive numbers"),
        (lambda: build_design(ROBOT, ViaPointShape(start=(9.0,) * 6)), "6 positions within the limits"),
        (
            lambda: build_design(ROBOT, ViaPointShape(start=(0.0, 1.2, 1.2, 0.0, 0.0, 0.0)), scene=SCENE),
            "another start pose: clearance of .* against 0, violated",
        ),
        (lambda: build_design(ROBOT, goal=Goal("a", reference={"FV1": 1.0})), "reference value other than zero"),
        (
            lambda: build_design(ROBOT, bounds=BOUNDS, loads=Loads({"FV1": 1.0})),
            "torque limits need the parameters",
        ),
    ],
)
def test_requests_that_cannot_be(make: object, message: str) -> None:
    assert callable(make)
    with pytest.raises(InputError, match=message):
        make()


def test_a_spring_is_part_of_the_torque() -> None:
    """Torques in the limits are those of inverse dynamics, the known spring taken off."""
    draw = np.random.default_rng(0)
    names = [*(f"{kind}{j}" for j in range(1, 6) for kind in (*INERTIAL, "IA", "FS", "FV", "OFF")), "FVM5", "FSM5"]
    joints = tuple(
        replace(joint, limits=replace(joint.limits, position=(-1.0, 1.0), speed=2.0, acceleration=9.0, torque=50.0))
        for joint in CROOKED.joints
    )
    robot = replace(CROOKED, joints=joints, parameters={name: draw.uniform(0.1, 1.0) for name in names})
    task = build_design(robot, FourierShape(4, 6.0), Goal("d"))
    x = task.family.random(draw)
    samples = task.family.sample(x)
    state = task.state(x, 0.0)
    limit = next(limit for limit in task.limits if limit.name == "torque")
    kernel = Kernel(inverse_dynamics(robot))
    expected = kernel(samples.q, samples.qd, samples.qdd, parameter_vector(robot, robot.parameters)).T
    assert np.allclose(limit.values(state) * 50.0, expected, rtol=1e-8, atol=1e-8)
