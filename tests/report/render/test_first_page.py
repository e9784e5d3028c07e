"""What the first page says at every verdict, and what it gives for the controller."""

import html
import re
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from dynident.apps.export.controllers import FORMATS
from dynident.apps.export.load import load_of
from dynident.apps.logs.read import read_recording
from dynident.apps.report import Provenance, payload_report
from dynident.apps.report.page import blocks_html, page_html
from dynident.apps.report.sections.payload import controller_blocks
from dynident.estimation import PayloadAnswer, PayloadResult, Settings, Verdict, answer_payload, payload_problem
from dynident.estimation.diagnosis.finding import Finding
from dynident.model import load_robot
from msgspec import structs

from .conftest import read

PROVENANCE = Provenance("dynident payload", datetime(2001, 9, 9, tzinfo=UTC))


@pytest.fixture(scope="module")
def answer(short_logs: Path) -> PayloadAnswer:
    robot = load_robot("rx90")
    loaded, bare = (read_recording(short_logs / f"{name}0.csv", robot) for name in ("loaded", "bare"))
    return answer_payload(payload_problem(robot, [loaded], [bare], settings=Settings(robust=False)))


@pytest.fixture(scope="module")
def document(answer: PayloadAnswer) -> PayloadResult:
    """A document as if the payload were known in the flange."""
    return structs.replace(answer.result, frame="flange: plain")


@pytest.mark.parametrize(
    ("level", "sentence", "uses"),
    [
        ("use", "Verdict: use mass, centre of mass and inertia (", ["use", "use", "use"]),
        ("mass_and_com_only", "Verdict: use mass and centre of mass (", ["use", "use", "not measured well enough"]),
        ("do_not_use", "Verdict: do not use (", ["do not use"] * 3),
    ],
)
def test_verdict_quantity_by_quantity(level: Any, sentence: str, uses: list[str], answer: PayloadAnswer) -> None:
    judged = replace(answer, verdict=Verdict(level, (Finding("warning", "", "a <b>reason</b>"),)))
    text = page_html(payload_report(judged.result), PROVENANCE)
    page = read(text)
    assert any(words.startswith(sentence) for words in page.texts["p"])
    merged = re.findall(r'<td class="words merged" rowspan="(\d)">([^<]+)</td>', text)
    assert merged == list(zip("136", uses, strict=True)), "each word stands beside all rows that it is of"
    assert "a <b>reason</b>" in page.texts["li"]
    assert ("Nothing is given here" in text) == (level == "do_not_use")
    assert ("equivalent ellipsoid" in text) == (level == "use")
    assert "No recording was held out" in text


def shown(document: PayloadResult) -> str:
    return blocks_html(controller_blocks(document, "this report", "Stäubli RX90"))


def test_controllers_get_what_export_writes(document: PayloadResult) -> None:
    """The robot's own maker first and open; each text is that of ``dynident export``, but for the reasons."""
    block = shown(document)
    page = read(block)
    load = replace(load_of(document, "this report"), reasons=())
    codes = dict(re.findall(r'<code id="controller-([^"]+)">(.*?)</code>', block, re.DOTALL))
    assert next(iter(codes)) == "staubli"
    assert set(codes) == {"abb", "kuka", "ur", "fanuc", "yaskawa", "staubli", "franka", "urdf"}
    for name, code in codes.items():
        assert html.unescape(code) == FORMATS[name].text(load).rstrip("\n")
    assert [key for _, key, _ in page.attributes].count("open") == 1
