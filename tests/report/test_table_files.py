"""Tables as CSV, as LaTeX and on a terminal agree cell by cell."""

import csv
import io
import re

import numpy as np
import pytest
from dynident.apps.report.blocks import Notes, Table, columns
from dynident.apps.report.render.csv import csv_tables
from dynident.apps.report.render.latex import escaped, latex_tables
from dynident.apps.report.render.terminal import print_blocks
from dynident.apps.report.sections.payload import payload_table
from dynident.estimation import PAYLOAD, Estimate
from dynident.estimation.fit import Fit
from dynident.estimation.payload import PayloadEstimate


@pytest.fixture
def payload() -> Table:
    values = np.array([0.2, -0.01, 0.0, 0.2, 0.0, 0.1, 0.0, 0.0, 0.3, 3.0])
    norms = Fit(np.ones(6), np.full(6, 10.0), (50,) * 6)
    estimate = Estimate(PAYLOAD, values, 1e-4 * np.eye(10), 300.0, norms, np.ones(6))
    return payload_table([PayloadEstimate(m, estimate, "tool0: 100 % of the flange_1") for m in (3, 4)])


@pytest.fixture
def odd_table() -> Table:
    rows = [("MY3R", "-1.5e-05", "<5", "2"), ("\\_^&", "2", "", 'k, "m"')]
    return Table("Other [things], 95 %", columns(("",), ("value", "%", "%")), rows, ends=("MY3R",))


def rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def test_csv_has_every_cell(payload: Table) -> None:
    read = rows(csv_tables([payload]))
    assert len(read) == len(payload.rows)
    for record, row in zip(read, payload.rows, strict=True):
        assert record["name"] == row[0]
        assert record["unit"] == row[1]
        for (heading, *_), cell in zip(payload.columns[2:], row[2:], strict=True):
            assert "±".join(filter(None, (record[heading], record[f"{heading} sigma"]))) == str(cell)
    mass = next(record for record in read if record["name"] == "M")
    assert (float(mass["method 4"]), float(mass["method 4 sigma"])) == (3.0, 0.01)
    assert float(next(record for record in read if record["name"] == "XY")["method 3"]) == -0.01


def test_csv_of_several_tables(payload: Table, odd_table: Table) -> None:
    read = rows(csv_tables([payload, odd_table]))
    assert len(read) == len(payload.rows) + 2
    first, last = read[0], read[-1]
    assert first["table"].startswith("Payload in tool0") or "tool0" in first["table"]
    assert (first["value"], first["%"]) == ("", "")
    assert last["table"] == "Other [things], 95 %"
    assert (last["name"], last["value"], last["% (2)"]) == ("\\_^&", "2", 'k, "m"')
    assert list(first)[:5] == ["table", "name", "unit", "method 3", "method 3 sigma"]


def parsed(text: str) -> list[list[str]]:
    """Cells of the tabulars; every row has as many as the column specification."""
    cells = []
    for spec, body in re.findall(r"\\begin\{tabular\}\{(\w+)\}(.*?)\\end\{tabular\}", text, flags=re.DOTALL):
        for line in body.strip().splitlines():
            if not line.strip().startswith("\\"):
                assert line.endswith(r" \\")
                cells.append([cell.strip() for cell in re.split(r"(?<!\\)&", line.strip().removesuffix(r"\\"))])
                assert len(cells[-1]) == len(spec)
    return cells


def test_latex_has_every_cell(payload: Table) -> None:
    text = latex_tables([payload])
    cells = parsed("\n".join(line.replace("    \\", "\\") for line in text.splitlines()))
    assert len(cells) == len(payload.rows) + 1
    for shown, row in zip(cells[1:], payload.rows, strict=True):
        for left, right in zip(shown, row, strict=True):
            plain = left.replace("$^2$", "²").replace(r" \pm ", "±").replace("$", "")
            assert plain == str(right)
    assert text.count(r"\midrule") == 4  # below the headings, the ten, the centre of mass, the inertia
    assert r"100 \% of the flange\_1" in text
    assert r"$3.000 \pm 0.010$" in text


def test_latex_of_what_is_special(odd_table: Table) -> None:
    text = latex_tables([odd_table])
    assert r"$-1.5\cdot 10^{-5}$ & $<$5 & $2$" in text
    assert r"\textbackslash{}\_\textasciicircum{}\&" in text
    assert text.count("{") == text.count("}")
    assert text.isascii()
    assert escaped("Größe 5 µ") == "Größe 5 µ"


def test_terminal_prints_text_as_it_is(odd_table: Table, capsys: pytest.CaptureFixture[str]) -> None:
    """Brackets are no markup, neither in titles nor in cells nor in notes; a section ends with a line."""
    print_blocks([odd_table, Notes(["[red]x[/red]"])])
    out = capsys.readouterr().out
    assert "Other [things], 95 %" in out
    assert "[red]x[/red]" in out
    assert [line.split()[0] for line in out.splitlines() if line.strip()[:2] in ("MY", "\\_")] == ["MY3R", "\\_^&"]
