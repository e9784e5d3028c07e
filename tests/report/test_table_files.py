"""Tables as CSV and LaTeX are the terminal's tables, cell by cell."""

import csv
import io
import re

import numpy as np
import pytest
from dynident.estimation import PAYLOAD, Estimate
from dynident.estimation.fit import Fit
from dynident.estimation.payload import PayloadEstimate
from dynident.report.csv_tables import csv_tables
from dynident.report.latex import escaped, latex_tables
from dynident.report.sheet import sheet_of
from dynident.report.tables import payload_table
from rich.table import Table


@pytest.fixture
def payload() -> Table:
    values = np.array([0.2, -0.01, 0.0, 0.2, 0.0, 0.1, 0.0, 0.0, 0.3, 3.0])
    norms = Fit(np.ones(6), np.full(6, 10.0), (50,) * 6)
    estimate = Estimate(PAYLOAD, values, 1e-4 * np.eye(10), 300.0, norms, np.ones(6))
    return payload_table([PayloadEstimate(m, estimate, "tool0: 100 % of the flange_1") for m in (3, 4)])


@pytest.fixture
def other() -> Table:
    table = Table(title="Other [bold]things[/bold], 95 %")
    for heading in ("", "value", "%", "%"):
        table.add_column(heading, justify="right" if heading else "left")
    table.add_row("MY3R", "-1.5e-05", "<5", "2", end_section=True)
    table.add_row("\\_^&", "2", "", 'k, "m"')
    return table


def rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def test_csv_has_every_cell(payload: Table) -> None:
    read = rows(csv_tables([payload]))
    sheet = sheet_of(payload)
    assert len(read) == len(sheet.rows) == payload.row_count
    for record, row in zip(read, sheet.rows, strict=True):
        assert record["name"] == row[0]
        assert record["unit"] == row[1]
        for heading, cell in zip(sheet.headings[2:], row[2:], strict=True):
            assert "±".join(filter(None, (record[heading], record[f"{heading} sigma"]))) == cell
    mass = next(record for record in read if record["name"] == "M")
    assert (float(mass["method 4"]), float(mass["method 4 sigma"])) == (3.0, 0.01)
    assert float(next(record for record in read if record["name"] == "XY")["method 3"]) == -0.01


def test_csv_of_several_tables(payload: Table, other: Table) -> None:
    read = rows(csv_tables([payload, other]))
    assert len(read) == payload.row_count + 2
    first, last = read[0], read[-1]
    assert first["table"].startswith("Payload in tool0") or "tool0" in first["table"]
    assert (first["value"], first["%"]) == ("", "")
    assert last["table"] == "Other things, 95 %"
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
    sheet = sheet_of(payload)
    assert len(cells) == payload.row_count + 1
    for shown, row in zip(cells[1:], sheet.rows, strict=True):
        for left, right in zip(shown, row, strict=True):
            plain = left.replace("$^2$", "²").replace(r" \pm ", "±").replace("$", "")
            assert plain == right
    assert text.count(r"\midrule") == 4  # below the headings, the ten, the centre of mass, the inertia
    assert r"100 \% of the flange\_1" in text
    assert r"$3.000 \pm 0.010$" in text


def test_latex_of_what_is_special(other: Table) -> None:
    text = latex_tables([other])
    assert r"$-1.5\cdot 10^{-5}$ & $<$5 & $2$" in text
    assert r"\textbackslash{}\_\textasciicircum{}\&" in text
    assert text.count("{") == text.count("}")
    assert text.isascii()
    assert escaped("Größe 5 µ") == "Größe 5 µ"
