"""Figures show a motion's limits, what it teaches, and paths of elimination; names in them are text."""

from typing import Any

import numpy as np
import pytest
from dynident.apps.report.figures.canvas import log_scale, new_figure, svg_text
from dynident.apps.report.figures.motion import motion_figure, sigma_figure
from dynident.apps.report.sections.evidence import essential_figure
from dynident.estimation import Estimate, SigmaBound, SigmaRatio
from dynident.estimation.fit.essential import Elimination, EliminationPath, StopRule
from dynident.estimation.fit.estimate import Fit
from dynident.estimation.results.parts import EliminationDocument
from dynident.model import load_robot
from dynident.tests.report.written import names_below_of
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


NOTHING = Fit(np.ones(1), np.full(1, 4.0), (1,))


def elimination(rule: StopRule | None = None) -> Elimination:
    path = EliminationPath(
        tuple("abcdef"),
        np.array([1.0, 1.0, 1.01, 1.03, 1.08, 2.0, 9.0]),
        np.array([9, 2, 0.5, 0.08, 0.04, 0.01, 0]),
    )
    left = tuple("def") if isinstance(rule, SigmaBound) else tuple("cdef")
    n = len(left)
    estimate = Estimate(left, np.ones(n), 0.01 * np.eye(n), 100.0, NOTHING, np.ones(1))
    return Elimination(path, rule or SigmaRatio(), estimate)


def told(result: Elimination, **labels: str) -> EliminationDocument:
    return EliminationDocument.made(result, ["warned"], labels)


@pytest.mark.parametrize("rule", [SigmaRatio(), SigmaBound(0.1)])
def test_the_figure_shows_the_path(rule: StopRule) -> None:
    result = elimination(rule)
    gone = len(result.eliminated)
    figure = essential_figure(told(result, b="bR"), "robot").figure
    above, below = figure.axes
    assert names_below_of(below)[:3] == ["none", "a", "bR"]
    for axis, values in ((above, result.path.sigma_ratio), (below, 100.0 * result.path.largest_relative_sigma)):
        _, in_path, beyond = axis.get_lines()[:3]
        assert np.asarray(in_path.get_ydata()) == pytest.approx(values[: gone + 1])
        assert np.asarray(beyond.get_xdata())[0] == gone + 1
        # No colour is needed to tell them apart.
        assert (in_path.get_markerfacecolor(), beyond.get_markerfacecolor()) == ("black", "white")
    limited, limit = (above, 1.02) if isinstance(rule, SigmaRatio) else (below, 10.0)
    dashed = [line for line in limited.get_lines() if line.get_linestyle() == "--"]
    assert [float(np.asarray(line.get_ydata())[0]) for line in dashed] == [limit]
