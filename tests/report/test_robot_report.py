"""Essential and constrained parameters of the robot as figure, document and table."""

from pathlib import Path

import numpy as np
import pytest
from dynident.apps.report.blocks import Notes
from dynident.apps.report.figures.canvas import save_figure
from dynident.apps.report.sections.parameters import essential_figure, essential_section
from dynident.apps.report.sections.robot import constrained_notes, standard_table
from dynident.estimation import Estimate, RobotResult, SigmaBound, SigmaRatio
from dynident.estimation.fit.essential import Elimination, EliminationPath, StopRule
from dynident.estimation.fit.estimate import Fit
from dynident.estimation.possible.prior import robot_prior, solve_constrained_prior
from dynident.estimation.possible.robot import solve_constrained_base
from dynident.estimation.results.parts import EliminationDocument, PossibleRobotDocument
from dynident.model import base_parameters, load_robot
from dynident.tests.report import made
from dynident.tests.report.written import names_below_of, written

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


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_the_same_figure_gives_the_same_file(tmp_path: Path, ending: str) -> None:
    for k in (1, 2):
        save_figure(essential_figure(told(elimination()), "robot").figure, tmp_path / f"{k}.{ending}")
    first, second = ((tmp_path / f"{k}.{ending}").read_bytes() for k in (1, 2))
    assert len(first) > 1000
    assert first == second


def test_data_without_noise_have_a_figure(tmp_path: Path) -> None:
    path = EliminationPath(("a", "b"), np.array([1.0, 1e150, np.inf]), np.array([np.inf, 1e-9, 0.0]))
    estimate = Estimate(("b",), np.ones(1), np.eye(1), 100.0, NOTHING, np.ones(1))
    save_figure(
        essential_figure(told(Elimination(path, SigmaRatio(), estimate)), "robot").figure, tmp_path / "f.png"
    )


def test_documents_of_elimination() -> None:
    result = elimination()
    document = written(told(result, c="cR"))
    assert (document["rule"], document["essential"], document["warnings"]) == ("ratio", 4, ["warned"])
    assert document["sigma_ratio"] == result.path.sigma_ratio[2]
    assert [step["eliminated"] for step in document["path"]] == [None, "a", "b", "cR", "d", "e", "f"]
    assert [step["remaining"] for step in document["path"]] == [6, 5, 4, 3, 2, 1, 0]
    assert [entry["name"] for entry in document["parameters"]] == ["cR", "d", "e", "f"]
    assert document["parameters"][0]["relative_sigma_percent"] == pytest.approx(10.0)
    assert written(told(elimination(SigmaBound())))["rule"] == "sigma"
    notes = essential_section(told(result), "robot").blocks[0]
    assert isinstance(notes, Notes)
    assert "4 of 6 parameters essential" in notes.lines[0]
    assert notes.lines[2] == "  - warned"


def test_who_decides_is_told_in_table_and_document() -> None:
    robot = load_robot("rx90")
    base = base_parameters(robot)
    truth = base.value(robot.parameters)
    sigma = 0.05 * (np.abs(truth) + 0.1)
    values = truth + sigma * np.random.default_rng(0).standard_normal(len(truth))
    estimate = Estimate(base.columns, values, np.diag(sigma**2), 500.0, NOTHING, np.ones(1))
    result = solve_constrained_prior(robot, base, estimate, robot_prior(robot))
    nearest = PossibleRobotDocument.made(result, base)
    document = written(nearest)
    assert document["gauge"] == "prior"
    labelled = {entry["name"]: entry for entry in document["parameters"]}
    assert (labelled["M1"]["kind"], labelled["XY3"]["kind"]) == ("prior", "identified")
    assert labelled["MX2"]["base"] == ["MX2R"]
    assert set(document["min_eigenvalues"]) == set("123456")
    assert document["base_parameters"][0]["free"] == estimate.values[0]
    assert len(document["unidentifiable"]) == 26
    assert nearest.parameters
    table = standard_table(nearest.parameters, "RX90")
    origins = {row[0]: row[-1] for row in table.rows}
    assert (origins["M1"], origins["MX2"], origins["FV1"]) == ("prior", "prior within MX2R", "data")
    answered = made.made(RobotResult, constrained=nearest, columns=base.columns)
    notes = constrained_notes(answered)
    assert "What the prior decides is not identified." in notes[1]
    assert any(line.startswith("No motion shows XX1") for line in notes)

    plain = written(PossibleRobotDocument.made(solve_constrained_base(robot, base, estimate), base))
    assert (plain["gauge"], "parameters" in plain, "prior" in plain) == ("base", False, False)
