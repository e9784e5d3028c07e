"""Figures show a motion's limits and what it teaches; names in them are text."""

from typing import Any

import numpy as np
import pytest
from dynident.apps.report.figures.canvas import log_scale, new_figure, svg_text
from dynident.apps.report.figures.motion import motion_figure, sigma_figure
from dynident.model import load_robot
from dynident.trajectories import (
    DesignProblem,
    FourierShape,
    Goal,
    JointBounds,
    Loads,
    Score,
    Simulator,
    ViaPoints,
    build_design,
    random_via_points,
    score_motion,
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


@pytest.fixture(scope="module")
def score(problem: DesignProblem, plan: ViaPoints) -> Score:
    return score_motion(problem, plan.motion(100.0))


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


def test_predicted_sigma(score: Score) -> None:
    reference = {"ZZ1": 2.0, "FV1": 10.0}
    figure = sigma_figure(score, "title", reference, {"ZZ1": "ZZ1R"}).figure
    above, below = figure.axes
    shown = {name: bar.get_height() for name, bar in zip(names_below_of(above), bars(above), strict=True)}
    sigma = score.learnt.sigma
    assert shown == pytest.approx({"ZZ1R": 50.0 * sigma["ZZ1"], "FV1": 10.0 * sigma["FV1"]})
    assert len(bars(below)) == len(sigma) - 2
    assert [bar.get_height() for bar in bars(below)] == pytest.approx(
        [value for name, value in sigma.items() if name not in reference]
    )
    assert len(sigma_figure(score, "title", {}, {}).figure.axes) == 1


def names_below_of(axis: Any) -> list[str]:
    """Names that stand below a panel, from the left."""
    return [
        text.get_text() for text in axis.texts if text.get_rotation() == 90.0 and not isinstance(text.xycoords, str)
    ]


def bars(axis: Any) -> list[Any]:
    return list(axis.containers[0])


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
