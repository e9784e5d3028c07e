"""Figures show a motion's limits and what it teaches; names in them are text."""

import numpy as np
import pytest
from dynident.apps.report.figures.canvas import log_scale, new_figure, svg_text
from dynident.apps.report.figures.motion import motion_figure
from dynident.model import load_robot
from dynident.trajectories import (
    DesignProblem,
    FourierShape,
    Goal,
    JointBounds,
    Loads,
    Simulator,
    ViaPoints,
    build_design,
    random_via_points,
)

TORQUE = (300.0, 300.0, 120.0, 50.0, 40.0, 20.0)


@pytest.fixture(scope="module")
def problem() -> DesignProblem:
    robot = load_robot("rx90")
    bounds = JointBounds.of(robot, torque=TORQUE)
    return build_design(robot, FourierShape(5), Goal(), bounds=bounds, loads=Loads(robot.parameters))


@pytest.fixture(scope="module")
def plan() -> ViaPoints:
    return random_via_points(load_robot("rx90"), 8, seed=0)


def test_motion_between_its_limits(problem: DesignProblem, plan: ViaPoints) -> None:
    motion = plan.motion(50.0)
    figure = motion_figure(problem, motion, "title").figure
    assert len(figure.axes) == 18
    torque = Simulator(problem.robot).measure(motion).torque
    for j in range(6):
        columns = figure.axes[3 * j : 3 * j + 3]
        for axis, values, limit in zip(
            columns, (motion.q, motion.qd, torque), (None, problem.bounds.speed, TORQUE), strict=True
        ):
            curve, *lines = axis.get_lines()
            assert np.allclose(np.asarray(curve.get_ydata()), values[:, j], atol=1e-8)
            edges = sorted(float(np.asarray(line.get_ydata())[0]) for line in lines)
            low, high = problem.bounds.low[j], problem.bounds.high[j]
            assert np.allclose(edges, [low, high] if limit is None else [-limit[j], limit[j]])
            assert {line.get_linestyle() for line in lines} != {curve.get_linestyle()}, "told apart without colour"


@pytest.mark.parametrize("name", ["a $x_$ b", "$\\frac$", "[/x]", "50 % _of_ ^it^", "<b>&amp;"])
def test_a_name_is_no_formula(name: str) -> None:
    figure = new_figure(4.0, 3.0)
    axis = figure.add_subplot()
    axis.plot([1, 2], [1e-3, 1e3], label=name)
    axis.set_title(name)
    axis.set_xticks([1, 2], [name, "other"])
    axis.legend()
    log_scale(axis)
    drawn = svg_text(figure, "names")
    escaped = name.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    assert drawn.count(f">{escaped}</text>") == 3, "title, legend and tick"
    assert "<tspan" not in drawn
    assert ">0.001</text>" in drawn, "powers of ten are plain numbers"
