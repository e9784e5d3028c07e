"""The report of a designed motion, and of one that was only judged."""

from pathlib import Path

import pytest
from dynident.cli import main
from dynident.tests.frozen.filed import filed

from .conftest import read

QUICK = ["design", "--robot", "rx90", "--torque-limits", "none", "--torque-noise", "1,1,1,1,1,1"]
QUICK += ["acceleration=3x", "--via-points", "5", "--starts", "1"]


@pytest.mark.long
def test_designed_and_judged(tmp_path: Path) -> None:
    design_page, judged, samples = (tmp_path / name for name in ("made.html", "judged.html", "motion.csv"))
    assert main(filed([*QUICK, "--samples", str(samples), "--report", str(design_page)])) == 0
    page = read(design_page.read_text(encoding="utf-8"))
    assert len(set(page.ids)) == len(page.ids)
    assert {"motion", "data", "figure-motion", "figure-predicted_sigma"} <= set(page.ids)
    assert page.count["svg"] == 2
    assert page.count["table"] >= 3
    assert "Motion of Stäubli RX90: keeps every limit that was checked. NOT checked: torque." in page.texts["p"]
    assert not [value for _, key, value in page.attributes if key in ("src", "href") and value.startswith("http")]

    assert main(filed(["score", str(samples), *QUICK[1:-4], "--report", str(judged)])) == 0
    page = read(judged.read_text(encoding="utf-8"))
    assert "motion.csv" in " ".join(page.texts["td"])
