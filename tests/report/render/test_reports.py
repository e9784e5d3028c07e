"""Reports as text and in a browser: whole, self-contained, harmless, the same twice."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from dynident.cli import main

from .conftest import Made, payload_command, read

SECTIONS = ["methods", "joints", "torques", "excitation", "essential", "data"]
FIGURES = [
    "flange",
    "worst_joint",
    "methods",
    "by_joints",
    "torques_1",
    "torques_2",
    "excitation",
    "essential_path",
]


@pytest.mark.parametrize(
    ("name", "sections", "figures"),
    [
        pytest.param("payload_report", SECTIONS, FIGURES, marks=pytest.mark.long),
        (
            "robot_report",
            ["parameters", "torques", "excitation", "essential", "data"],
            ["worst_joint", "torques_1", "excitation", "essential_path"],
        ),
    ],
)
def test_every_section_figure_and_table(
    name: str, sections: list[str], figures: list[str], request: pytest.FixtureRequest
) -> None:
    output: Made = request.getfixturevalue(name)
    page = read(output.text)
    assert len(set(page.ids)) == len(page.ids)
    assert [entry for entry in page.ids if entry in SECTIONS or entry == "parameters"] == sections
    assert [entry.removeprefix("figure-") for entry in page.ids if entry.startswith("figure-")] == figures
    assert page.count["svg"] == page.count["figcaption"] == len(figures)
    assert all(caption.strip() for caption in page.texts["figcaption"] + page.texts["caption"])
    assert page.count["table"] == page.count["caption"] == page.count["thead"] >= 6
    described = [value for tag, key, value in page.attributes if (tag, key) == ("svg", "aria-labelledby")]
    assert len(described) == len(figures)
    assert set(described) <= set(page.ids)
    files = {f"{figure}.{ending}" for figure in figures for ending in ("png", "svg", "pdf")}
    assert {path.name for path in output.plots.iterdir()} == files
    assert len(output.text.encode()) < 3_000_000


@pytest.mark.parametrize("name", [pytest.param("payload_report", marks=pytest.mark.long), "robot_report"])
def test_nothing_is_loaded_from_elsewhere(name: str, request: pytest.FixtureRequest) -> None:
    output: Made = request.getfixturevalue(name)
    page = read(output.text)
    loading = [(tag, key, value) for tag, key, value in page.attributes if key in ("src", "href", "action", "data")]
    assert loading
    assert all(value.startswith(("#", "data:")) for _, _, value in loading)
    inside = {value[1:] for _, key, value in loading if key == "href" and value.startswith("#")}
    assert inside <= set(page.ids)
    for style in [*page.texts["style"], *(value for _, key, value in page.attributes if key == "style")]:
        assert "@import" not in style
        assert not re.search(r"url\((?!#)", style)
    assert "http" not in " ".join(page.texts["script"])


@pytest.mark.long
def test_the_same_input_gives_the_same_bytes(payload_report: Made, short_logs: Path, tmp_path: Path) -> None:
    """But for the command, which names another target."""
    second = tmp_path / "other.html"
    assert main(payload_command(short_logs, second, payload_report.plots)[:-2]) == 0
    command_line = re.compile(r'<code id="command">.*?</code>', re.DOTALL)
    assert command_line.sub("", second.read_text(encoding="utf-8")) == command_line.sub("", payload_report.text)


def test_no_report_without_being_asked(short_logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> None:
        raise AssertionError("the page was made")

    monkeypatch.setattr("dynident.apps.report.page.page_html", refused)
    monkeypatch.setattr("dynident.estimation.PayloadAnswer.predictions", property(refused))
    command = payload_command(short_logs, tmp_path / "x.html", tmp_path / "x")
    assert main(command[:-4]) == 0
    assert not list(tmp_path.iterdir())


def test_a_time_that_is_none_is_refused(
    short_logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "yesterday")
    assert main(payload_command(short_logs, tmp_path / "x.html", tmp_path / "x")) == 2
    assert "SOURCE_DATE_EPOCH 'yesterday'" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


QUICK = ["design", "--robot", "rx90", "--torque-limits", "none", "--torque-noise", "1,1,1,1,1,1"]
QUICK += ["acceleration=3x", "--via-points", "5", "--starts", "1"]


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


def read_title(dom: str) -> str:
    return dom.split("<title>", 1)[1].split("</title>", 1)[0]
