"""Screens of 25 lines of 80 columns, documents that are whole, figures; names in them are text."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from dynident import trajectories
from dynident.apps.numbers import with_sigma
from dynident.apps.report.blocks import COLUMNS, LINES, Block, Drawing, Notes, Report, Section, Table, screen_lines
from dynident.apps.report.documents import DOCUMENTS, schema_text
from dynident.apps.report.figures import figure_bytes, log_scale
from dynident.apps.report.sections.motion import motion_figure
from dynident.common.schema import write_json
from dynident.model import load_robot
from matplotlib.figure import Figure
from rich.cells import cell_len

LONG = "a reason that goes on and on, " * 40
WIDE = Table("wide", ("", "unit", *(f"method {k}" for k in range(20))), [("M", "kg", *["-1234.567"] * 20)])
FOLDING = Table("words", ("", "value", "rests on"), [("joint 1", "1.25", "gravity " * 40)])
SEVEN = Table("seven", ("", "value"), [(f"row {k}", "1.0") for k in range(7)])


def within(text: str) -> bool:
    return max(map(cell_len, text.split("\n"))) <= COLUMNS


@pytest.mark.parametrize("count", [0, 1, 5, 40])
@pytest.mark.parametrize("line", ["short", LONG, "/a/path/" + "x" * 200])
def test_a_screen_never_grows_beyond_its_lines(count: int, line: str) -> None:
    remarks = Notes([line] * count, optional=True)
    first: list[Block] = [Notes(["Verdict: use."]), remarks, SEVEN, Notes(["Next: go."])]
    screen = Report("", first, [Section("wide", "Wide", [WIDE])], "more")
    lines = screen_lines(screen)
    assert len(lines) <= LINES
    assert within("\n".join(lines))
    assert any(line.startswith("Next") for line in lines), "what must be seen is not pushed out by remarks"
    assert lines[-1].startswith("--details: ")


def test_details_hold_every_word() -> None:
    first = [Notes([f"{LONG} {k}" for k in range(40)], optional=True)]
    screen = Report("", first, [Section("wide", "Wide", [WIDE])])
    words = "\n".join(screen_lines(screen, details=True)).split()
    assert words.count("goes") == 40 * 40
    assert words.count("-1234.567") == 20
    assert "--details:" not in words


@pytest.mark.parametrize("table", [WIDE, FOLDING, SEVEN], ids=["wide", "folding", "narrow"])
def test_a_table_is_as_wide_as_the_terminal_at_most(table: Table) -> None:
    shown = "\n".join(screen_lines(Report("", [table])))
    assert within(shown)
    for row in table.rows:
        for cell in row:
            assert str(cell).split()[0] in shown
    assert "…" not in shown


@pytest.mark.parametrize("name", ["[/x]", "[bold]x", ":warning:", "[red", "a\\[b", "{x}"])
def test_names_are_text(name: str) -> None:
    """Brackets and colons of names of robots and files are no markup."""
    table = Table(f"Robot {name}", (name, f"[{name}]"), [(name, "1")])
    notes = Notes([f"{name}: read"]), Notes([f"note of {name}"], optional=True)
    shown = "\n".join(screen_lines(Report("", [*notes, table], [], name)))
    assert shown.count(name) == 7


def test_json_is_plain_and_whole(tmp_path: Path) -> None:
    path = tmp_path / "out.json"
    document = {"a": np.arange(3.0), "b": np.float64(1.5), "c": (1, None, float("nan")), "d": {"e": np.inf}}
    write_json(path, document)
    assert json.loads(path.read_text()) == {"a": [0.0, 1.0, 2.0], "b": 1.5, "c": [1, None, None], "d": {"e": None}}
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("value", "sigma", "text"),
    [(1.23456, 0.0123, "1.235±0.012"), (-0.00012345, 1e-5, "-0.000123±0.000010"), (1234.5, 12.0, "1234±12"),
     (2.5, 0.0, "2.5"), (2.5, np.inf, "2.5")],
)  # fmt: skip
def test_values_have_two_digits_of_sigma(value: float, sigma: float, text: str) -> None:
    assert str(with_sigma(value, sigma)) == text


FOLDER = Path(__file__).parents[2] / "docs" / "schemas"


def test_each_document_has_one_and_the_page_links_it() -> None:
    assert {path.name for path in FOLDER.iterdir()} == {f"{name}.schema.json" for name in DOCUMENTS}
    page = (FOLDER.parent / "documents.md").read_text(encoding="utf-8")
    assert all(f"(schemas/{name}.schema.json)" in page for name in DOCUMENTS)


@pytest.mark.parametrize("name", DOCUMENTS)
def test_it_is_current(name: str) -> None:
    """If not: python -m dynident.apps.report.documents; Python 3.13 takes the margin of docstrings off."""
    stored, made = (FOLDER / f"{name}.schema.json").read_text(encoding="utf-8"), schema_text(name).decode()
    stored, made = (json.loads(re.sub(r"(?<=\\n) +", "", text)) for text in (stored, made))
    assert stored == made


TORQUE = (300.0, 300.0, 120.0, 50.0, 40.0, 20.0)


@pytest.fixture(scope="module")
def problem() -> trajectories.DesignProblem:
    robot = load_robot("rx90")
    bounds = trajectories.JointBounds.of(robot, torque=TORQUE)
    return trajectories.build_design(
        robot,
        trajectories.FourierShape(5),
        trajectories.Goal(),
        bounds=bounds,
        loads=trajectories.Loads(robot.parameters),
    )


@pytest.fixture(scope="module")
def plan() -> trajectories.ViaPoints:
    return trajectories.random_via_points(load_robot("rx90"), 8, seed=0)


def test_motion_between_its_limits(problem: trajectories.DesignProblem, plan: trajectories.ViaPoints) -> None:
    motion = plan.motion(50.0)
    (drawing,) = motion_figure(problem, motion, "title")
    assert isinstance(drawing, Drawing)
    figure = drawing.figure
    assert len(figure.axes) == 18
    torque = trajectories.Simulator(problem.robot).measure(motion).torque
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
    figure = Figure(figsize=(4.0, 3.0))
    axis = figure.add_subplot()
    axis.plot([1, 2], [1e-3, 1e3], label=name)
    axis.set_title(name)
    axis.set_xticks([1, 2], [name, "other"])
    axis.legend()
    log_scale(axis)
    drawn = figure_bytes(figure, name="names").decode()
    escaped = name.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    assert drawn.count(f">{escaped}</text>") == 3, "title, legend and tick"
    assert "<tspan" not in drawn
    assert ">0.001</text>" in drawn, "powers of ten are plain numbers"
