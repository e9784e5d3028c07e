"""Text stays text, whatever it holds; pages of any content are whole."""

from collections.abc import Sequence
from datetime import UTC, datetime

import numpy as np
import pytest
from dynident.apps.numbers import with_interval
from dynident.apps.report.blocks import Block, Code, Drawing, Notes, Report, Section, Table, Text
from dynident.apps.report.figures.canvas import new_figure
from dynident.apps.report.figures.signals import prediction_figure, worst_joint_figure
from dynident.apps.report.page import blocks_html, page_html
from dynident.apps.report.provenance import Provenance, SourceFile
from dynident.estimation.answers.system import TorquePrediction
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from .conftest import read

EVIL = "<script>alert(1)</script>\"'&lt;</code></pre>"
DATE = datetime(2001, 9, 9, 1, 46, tzinfo=UTC)


@given(st.text(st.characters(exclude_categories=["Cs", "Cc"])))
def test_text_comes_back(text: str) -> None:
    """Whatever it holds, it is escaped once, in content and in attributes."""
    page = read(blocks_html([Text(text), Code(text, text)]))
    assert page.texts["p"] == page.texts["code"] == [text]
    assert ("code", "id", text) in page.attributes
    assert blocks_html([Notes([])]).strip() == ""


def evil_prediction() -> TorquePrediction:
    t = np.append(np.arange(0.0, 1.0, 0.1), np.arange(3.0, 4.0, 0.1))
    measured = np.sin(t)
    return TorquePrediction(EVIL, True, False, (t,), (measured,), {"predicted": (0.9 * measured,)})


SOURCE = Provenance("c", DATE)


def report_of(blocks: Sequence[Block]) -> Report:
    return Report(EVIL, [Text(EVIL)], [Section("one", EVIL, blocks)])


def test_files_named_like_scripts_are_harmless() -> None:
    """In tables, captions, descriptions of figures, the command and the title."""
    files = (SourceFile("with payload", EVIL, "0" * 64),)
    provenance = Provenance(f"dynident payload --loaded {EVIL}", DATE, files, {EVIL: EVIL}, {EVIL: EVIL})
    shown = Table("plain", ("", EVIL), [(EVIL, EVIL)])
    drawings = [worst_joint_figure(evil_prediction()), prediction_figure(evil_prediction(), "torques_1")]
    text = page_html(report_of([shown, Notes([EVIL]), *drawings]), provenance)
    page = read(text)
    assert page.count["script"] == 1
    assert "alert" not in page.texts["script"][0]
    assert page.texts["h1"] == page.texts["title"][:1] == [EVIL]
    assert sum(EVIL in entry for entry in page.texts["code"]) == 1
    assert sum(EVIL in entry for entry in page.texts["figcaption"]) == 2


def test_two_figures_share_no_identifier() -> None:
    def draw() -> Figure:
        figure = new_figure(3.0, 2.0)
        figure.subplots().plot([0.0, 1.0], [1.0, 0.0], "o", label="x")
        return figure

    text = page_html(report_of([Drawing(name, "caption", draw) for name in ("a", "b")]), SOURCE)
    ids = read(text).ids
    assert len(set(ids)) == len(ids)
    assert {"a-text", "b-text"} <= set(ids)


def test_figures_wait_until_they_are_looked_at() -> None:
    drawn = []

    def draw() -> Figure:
        drawn.append(1)
        return new_figure(1.0, 1.0)

    page = report_of([Drawing("a", "caption", draw)])
    assert len(page.drawings()) == 1
    assert not drawn
    text = page_html(page, SOURCE)
    assert text.count("<svg") == text.count("caption</figcaption>") == len(drawn) == 1


@pytest.mark.parametrize(
    ("numbers", "texts"),
    [
        ((2.80551, 2.7812, 2.8298), ("2.806", "2.781 to 2.830")),
        ((-0.00001, -0.004, 0.004), ("0.0000", "-0.0040 to 0.0040")),
        ((123.4, 80.0, 170.0), ("123", "80 to 170")),
        ((-980.1377, np.nan, np.nan), ("-980.1", "-")),
    ],
)
def test_numbers_have_the_digits_of_their_interval(
    numbers: tuple[float, float, float], texts: tuple[str, str]
) -> None:
    assert with_interval(*numbers) == texts
