"""Reports in a browser: they open without a complaint, with every figure and table, wide, narrow and on paper."""

import shutil
import subprocess
from pathlib import Path

import pytest

from .conftest import Made, read

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


@pytest.fixture(scope="module")
def browser() -> str:
    binary = next((path for path in map(shutil.which, BROWSERS) if path), None)
    if binary is None:
        pytest.skip(f"none of {', '.join(BROWSERS)} is installed")
    return binary


def start(browser: str, folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--enable-logging=stderr"]
    options += [f"--user-data-dir={folder / 'profile'}", "--virtual-time-budget=3000"]
    return subprocess.run(
        [browser, *options, *arguments], capture_output=True, text=True, timeout=120, check=True, cwd=folder
    )


# Reads what only a browser knows: what is drawn, and whether the page is wider than its window.
PROBE = """<script>
addEventListener("load", () => {
  const drawn = [...document.querySelectorAll("svg")].filter(one => one.getBoundingClientRect().height > 40);
  const tables = [...document.querySelectorAll("table")].filter(one => one.getBoundingClientRect().width > 40);
  const root = document.documentElement;
  document.title = [drawn.length, tables.length, root.scrollWidth - root.clientWidth,
    document.querySelectorAll("button:not([hidden])").length].join(" ");
});
</script>"""


@pytest.mark.long
@pytest.mark.parametrize("name", ["payload_report", "robot_report"])
@pytest.mark.parametrize("width", [1200, 500])
def test_opens(name: str, width: int, browser: str, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    output: Made = request.getfixturevalue(name)
    page = read(output.text)
    (tmp_path / "page.html").write_text(
        output.text.replace("<details>", "<details open>") + PROBE, encoding="utf-8"
    )
    done = start(browser, tmp_path, f"--window-size={width},900", "--dump-dom", (tmp_path / "page.html").as_uri())
    assert ":CONSOLE" not in done.stderr
    figures, tables, over, buttons = map(int, read_title(done.stdout).split())
    assert (figures, tables) == (page.count["svg"], page.count["table"])
    assert over <= 0, "the page itself must not scroll sideways"
    assert buttons == page.count["button"]


def test_console_errors_would_be_seen(browser: str, tmp_path: Path) -> None:
    """The test above would pass without a word if they were not."""
    (tmp_path / "bad.html").write_text("<script>nothing.there()</script>", encoding="utf-8")
    done = start(browser, tmp_path, "--dump-dom", (tmp_path / "bad.html").as_uri())
    assert ":CONSOLE" in done.stderr


@pytest.mark.long
def test_prints(payload_report: Made, browser: str, tmp_path: Path) -> None:
    target = tmp_path / "page.pdf"
    start(browser, tmp_path, f"--print-to-pdf={target}", payload_report.path.as_uri())
    assert target.read_bytes().startswith(b"%PDF")
    assert target.stat().st_size > 50_000


def read_title(dom: str) -> str:
    return dom.split("<title>", 1)[1].split("</title>", 1)[0]
