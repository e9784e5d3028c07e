"""The documentation builds without a warning, and the API pages hold every public name."""

import importlib
import subprocess
import sys
from pathlib import Path

import pytest
from dynident.tests.docs.pages import ROOT

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    for module in ("mkdocs", "mkdocstrings"):
        pytest.importorskip(module, reason=f"{module} is not installed: pip install dynident[docs]")
    folder = tmp_path_factory.mktemp("site")
    command = (sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder))
    answer = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert answer.returncode == 0, answer.stderr
    return folder


def test_every_page_is_built(site: Path) -> None:
    for page in (ROOT / "docs").rglob("*.md"):
        name = page.relative_to(ROOT / "docs").with_suffix("")
        built = site / "index.html" if name.name == "index" else site / name / "index.html"
        assert len(built.read_text(encoding="utf-8")) > 2000, name


@pytest.mark.parametrize("room", ["model", "estimation", "trajectories"])
def test_api_pages_hold_every_public_name(room: str) -> None:
    """Public is what a page names: each name of a room's contents has its entry."""
    page = (ROOT / "docs/api" / f"{room}.md").read_text(encoding="utf-8").split()
    entries = {text.rpartition(".")[2] for text in page if text.startswith("dynident.")}
    assert set(importlib.import_module(f"dynident.{room}").__all__) <= entries
