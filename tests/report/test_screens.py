"""Screens of 25 lines of 80 columns, documents that are whole, and the schemas of the docs."""

import json
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.report.blocks import Block, Notes, Report, Section, Table, with_sigma
from dynident.apps.report.documents import DOCUMENTS, schema_text
from dynident.apps.report.terminal import COLUMNS, LINES, screen_text
from dynident.common.schema import write_json
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
    first: list[Block] = [
        Notes(["Verdict: use."]),
        Notes([line] * count, optional=True),
        SEVEN,
        Notes(["Next: go."]),
    ]
    screen = Report("", first, [Section("wide", "Wide", [WIDE])], "more")
    lines = screen_text(screen).split("\n")
    assert len(lines) <= LINES
    assert within("\n".join(lines))
    assert any(line.startswith("Next") for line in lines), "what must be seen is not pushed out by remarks"
    assert lines[-1].startswith("--details: ")


def test_details_hold_every_word() -> None:
    first = [Notes([f"{LONG} {k}" for k in range(40)], optional=True)]
    screen = Report("", first, [Section("wide", "Wide", [WIDE])])
    words = screen_text(screen, details=True).split()
    assert words.count("goes") == 40 * 40
    assert words.count("-1234.567") == 20
    assert "--details:" not in words


@pytest.mark.parametrize("table", [WIDE, FOLDING, SEVEN], ids=["wide", "folding", "narrow"])
def test_a_table_is_as_wide_as_the_terminal_at_most(table: Table) -> None:
    shown = screen_text(Report("", [table]))
    assert within(shown)
    for row in table.rows:
        for cell in row:
            assert str(cell).split()[0] in shown
    assert "…" not in shown


@pytest.mark.parametrize("name", ["[/x]", "[bold]x", ":warning:", "[red", "a\\[b", "{x}"])
def test_names_are_text(name: str) -> None:
    """Brackets and colons of names of robots and files are no markup."""
    table = Table(f"Robot {name}", (name, f"[{name}]"), [(name, "1")])
    shown = screen_text(
        Report("", [Notes([f"{name}: read"]), Notes([f"note of {name}"], optional=True), table], [], name)
    )
    assert shown.count(name) == 7


def test_json_is_plain_and_whole(tmp_path: Path) -> None:
    path = tmp_path / "out.json"
    document = {"a": np.arange(3.0), "b": np.float64(1.5), "c": (1, None, float("nan")), "d": {"e": np.inf}}
    write_json(path, document)
    assert json.loads(path.read_text()) == {"a": [0.0, 1.0, 2.0], "b": 1.5, "c": [1, None, None], "d": {"e": None}}
    assert list(tmp_path.iterdir()) == [path]


def test_a_failed_write_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "out.json"
    write_json(path, {"good": 1})
    with pytest.raises(TypeError):
        write_json(path, {"bad": object()})
    assert json.loads(path.read_text()) == {"good": 1}
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
    """If not: python -m dynident.apps.report.documents."""
    assert json.loads((FOLDER / f"{name}.schema.json").read_bytes()) == json.loads(schema_text(name))
