"""The gallery shows a screen and a figure of every level that a verdict has."""

import re

from dynident.apps.report.sections.evidence import VERDICTS
from dynident.tests.docs.pages import ROOT

PAGE = ROOT / "docs/gallery.md"


def test_every_level_is_shown_with_its_screen_and_its_figure() -> None:
    parts = re.split(r"^## ", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    levels = [part.partition("`\n")[0].strip("`") for part in parts]
    assert levels == list(VERDICTS)
    for level, part in zip(levels, parts, strict=True):
        assert f"Verdict: {VERDICTS[level]}" in part
        (picture,) = re.findall(r"\]\((gallery/\w+\.png)\)", part)
        assert (ROOT / "docs" / picture).stat().st_size < 150_000
