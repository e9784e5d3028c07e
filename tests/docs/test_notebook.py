"""The notebook of five cells runs from top to bottom, and its last expressions show themselves."""

import ast
import contextlib
import io
import json
from pathlib import Path
from typing import Any

import pytest
from dynident.tests.docs.pages import ROOT

NOTEBOOK = ROOT / "examples/first_payload.ipynb"


def cells() -> list[str]:
    return ["".join(cell["source"]) for cell in json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]]


def ran(source: str, names: dict[str, Any]) -> tuple[str, Any]:
    """Output of a cell, and the value of its last expression, as a notebook runs it."""
    tree, shown = ast.parse(source), None
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(compile(tree, "cell", "exec"), names)
        if isinstance(last, ast.Expr):
            shown = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
    return printed.getvalue(), shown


@pytest.mark.long
def test_every_cell_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    results = [ran(cell, names) for cell in cells()]
    log, answer, figure = (results[k][1] for k in (1, 2, 3))
    assert "<table" in log._repr_html_()
    assert "Verdict: use mass" in answer._repr_html_()
    assert figure.axes
    assert results[3][0].strip().endswith(")")
    assert answer.mass.low < 7.0 < answer.mass.high
    assert (tmp_path / "payload.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert "7.0" in results[4][0]
