"""Essential and constrained parameters of the robot as figure, document and table."""

from pathlib import Path

import numpy as np
import pytest
from dynident.apps.report.figures.canvas import save_figure
from dynident.apps.report.figures.parameters import essential_figure
from dynident.estimation import Estimate, SigmaBound, SigmaRatio
from dynident.estimation.fit.essential import Elimination, EliminationPath, StopRule
from dynident.estimation.fit.estimate import Fit
from dynident.estimation.results.parts import EliminationDocument
from dynident.tests.report.written import names_below_of

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


def test_data_without_noise_have_a_figure(tmp_path: Path) -> None:
    path = EliminationPath(("a", "b"), np.array([1.0, 1e150, np.inf]), np.array([np.inf, 1e-9, 0.0]))
    estimate = Estimate(("b",), np.ones(1), np.eye(1), 100.0, NOTHING, np.ones(1))
    save_figure(
        essential_figure(told(Elimination(path, SigmaRatio(), estimate)), "robot").figure, tmp_path / "f.png"
    )
