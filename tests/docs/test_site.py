"""The documentation builds without a warning, works without a network, and the API pages hold every public name."""

import importlib
import re
import subprocess
import sys
from html import unescape
from pathlib import Path
from urllib.parse import unquote

import pytest
from dynident.tests.docs.pages import ROOT, pages

pytestmark = pytest.mark.long
API = sorted((ROOT / "docs/api").glob("*.md"))


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    for module in ("mkdocs", "material", "mkdocstrings"):
        pytest.importorskip(module, reason=f"{module} is not installed: pip install dynident[docs]")
    folder = tmp_path_factory.mktemp("site")
    command = (sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder))
    answer = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert answer.returncode == 0, answer.stderr
    return folder


def test_every_page_is_built(site: Path) -> None:
    for page in pages()[1:]:
        name = page.relative_to(ROOT / "docs").with_suffix(".html")
        assert len((site / name).read_text(encoding="utf-8")) > 2000, name


def test_every_link_leads_somewhere_and_nothing_comes_from_a_network(site: Path) -> None:
    """The links of the built pages, as a browser reads them from files: each file and each anchor is there."""
    texts = {page.resolve(): page.read_text(encoding="utf-8") for page in site.rglob("*.html")}
    anchors = {
        page: {unescape(name) for name in re.findall(r'\b(?:id|name)="?([^"\s>]+)', text)}
        for page, text in texts.items()
    }
    followed = 0
    for page, text in texts.items():
        if page.name == "404.html":
            continue
        for tag, target in re.findall(r'<(\w+)\b[^>]*?\s(?:href|src)="?([^"\s>]+)', text):
            if re.match(r"[a-z]+:", target):
                assert tag == "a" or target.startswith("data:"), f"{page.name}: {target} is loaded"
                continue
            path, _, anchor = unescape(unquote(target)).partition("#")
            file = (page.parent / path.partition("?")[0]).resolve() if path else page
            assert file.is_file(), f"{page.name}: {target}"
            assert not anchor or file not in anchors or anchor in anchors[file], f"{page.name}: {target}"
            followed += 1
    assert followed > 3000
    for sheet in site.rglob("*.css"):
        assert not re.search(r"(url\(|@import)\s*['\"]?https?:", sheet.read_text(encoding="utf-8")), sheet.name


def test_api_pages_hold_every_public_name_once() -> None:
    """Public is what a room's contents name; each name has its entry, under one of the headings."""
    entries = re.findall(r"^::: dynident\.(\S+)$", "\n".join(page.read_text() for page in API), flags=re.MULTILINE)
    names = [entry.rpartition(".")[2] for entry in entries]
    assert len(set(names)) == len(names)
    for room in ("", ".model", ".estimation", ".trajectories", ".apps.logs", ".apps.view"):
        assert set(importlib.import_module(f"dynident{room}").__all__) <= set(names), room
