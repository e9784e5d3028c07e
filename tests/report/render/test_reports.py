"""Pages of any content are whole, self-contained and harmless, as text and in a browser."""

import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from dynident.apps.logs.read import read_recording
from dynident.apps.numbers import with_interval
from dynident.apps.report.blocks import Notes, Report, Section, Table, Text, blocks_html, page_html
from dynident.apps.report.sections.evidence import explained
from dynident.apps.report.sections.payload import controller_line, payload_report
from dynident.apps.report.sections.robot import robot_report as robot_page
from dynident.cli import main
from dynident.estimation import PayloadAnswer, Settings, Verdict, answer_payload, identify, payload_problem
from dynident.estimation.results.payload import FlangeDocument, TorquePrediction
from dynident.model import load_robot
from dynident.model.inertia import Pose
from hypothesis import given
from hypothesis import strategies as st
from msgspec import structs

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
ROBOT_SECTIONS = ["parameters", "torques", "excitation", "essential", "data"]


@pytest.mark.parametrize(
    ("name", "sections", "figures"),
    [
        pytest.param("payload_report", SECTIONS, FIGURES, marks=pytest.mark.long),
        ("robot_report", ROBOT_SECTIONS, ["worst_joint", "torques_1", "excitation", "essential_path"]),
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


def test_a_time_that_is_none_is_refused(
    short_logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "yesterday")
    assert main(payload_command(short_logs, tmp_path / "x.html", tmp_path / "x")) == 2
    assert "SOURCE_DATE_EPOCH 'yesterday'" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


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
    title = done.stdout.split("<title>", 1)[1].split("</title>", 1)[0]
    figures, tables, over, buttons = map(int, title.split())
    assert (figures, tables) == (page.count["svg"], page.count["table"])
    assert over <= 0, "the page itself must not scroll sideways"
    assert buttons == page.count["button"]


def test_console_errors_would_be_seen(browser: str, tmp_path: Path) -> None:
    """The test above would pass without a word if they were not."""
    (tmp_path / "bad.html").write_text("<script>nothing.there()</script>", encoding="utf-8")
    done = start(browser, tmp_path, "--dump-dom", (tmp_path / "bad.html").as_uri())
    assert ":CONSOLE" in done.stderr


EVIL = "<script>alert(1)</script>\"'&lt;</code></pre>"


@given(st.text(st.characters(exclude_categories=["Cs", "Cc"])))
def test_text_comes_back(text: str) -> None:
    """Whatever it holds, it is escaped once, in content and in attributes."""
    page = read(blocks_html([Text(text), Text(text, copied=text)]))
    assert page.texts["p"] == page.texts["code"] == [text]
    assert ("code", "id", text) in page.attributes
    assert blocks_html([Notes([])]).strip() == ""


def evil_prediction() -> TorquePrediction:
    t = np.append(np.arange(0.0, 1.0, 0.1), np.arange(3.0, 4.0, 0.1))
    measured = np.sin(t)
    return TorquePrediction(EVIL, True, False, (t,), (measured,), {"predicted": (0.9 * measured,)})


def test_files_named_like_scripts_are_harmless() -> None:
    """In tables, captions, descriptions of figures, the command and the title."""
    files = (("with payload", EVIL, "0" * 64),)
    shown = Table("plain", ("", EVIL), [(EVIL, EVIL)])
    worst, torques, _ = explained(SimpleNamespace(predictions=[evil_prediction()]))
    section = Section("one", EVIL, [shown, Notes([EVIL]), worst, *torques.blocks])
    report = Report(EVIL, [Text(EVIL)], [section])
    text = page_html(report, f"dynident payload --loaded {EVIL}", files, {EVIL: EVIL})
    page = read(text)
    assert page.count["script"] == 1
    assert "alert" not in page.texts["script"][0]
    assert page.texts["h1"] == page.texts["title"][:1] == [EVIL]
    assert sum(EVIL in entry for entry in page.texts["code"]) == 1
    assert sum(EVIL in entry for entry in page.texts["figcaption"]) == 2


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


@pytest.fixture(scope="module")
def answer(short_logs: Path) -> PayloadAnswer:
    robot = load_robot("rx90")
    loaded, bare = (read_recording(short_logs / f"{name}0.csv", robot) for name in ("loaded", "bare"))
    return answer_payload(payload_problem(robot, [loaded], [bare], settings=Settings(robust=False)))


@pytest.mark.parametrize(
    ("level", "sentence", "uses"),
    [
        ("use", "Verdict: use mass, centre of mass and inertia (", ["yes", "yes, all three", "yes, all six"]),
        (
            "mass_and_com_only",
            "Verdict: use mass and centre of mass, not",
            ["yes", "yes, all three", "no: too uncertain"],
        ),
        ("do_not_use", "Verdict: do not use these numbers (", ["no"] * 3),
    ],
)
def test_verdict_quantity_by_quantity(level: Any, sentence: str, uses: list[str], answer: PayloadAnswer) -> None:
    judged = replace(answer, verdict=Verdict(level, ("a <b>reason</b>",)))
    text = page_html(payload_report(judged.result), "dynident payload")
    page = read(text)
    assert any(words.startswith(sentence) for words in page.texts["p"])
    merged = re.findall(r'<td class="words merged" rowspan="(\d)">([^<]+)</td>', text)
    assert merged == list(zip("136", uses, strict=True)), "each word stands beside all rows that it is of"
    assert "a <b>reason</b>" in page.texts["li"]
    assert ("There is nothing to enter" in text) == (level == "do_not_use")
    assert ("equivalent ellipsoid" in text) == (level == "use")
    assert "No recording was held out" in text


def test_friction_is_in_the_units_of_its_joint(short_logs: Path) -> None:
    robot = load_robot("rx90")
    result = identify(robot, [read_recording(short_logs / "bare0.csv", robot)], Settings(robust=False)).result
    sliding = structs.replace(result, joints=("prismatic", *("revolute",) * 5))
    for one, unit in ((result, "N·m"), (sliding, "N")):
        table = next(block for block in robot_page(one).first if isinstance(block, Table))
        assert [row[-1] for row in table.rows] == [f"{unit}·s", *["N·m·s"] * 5]


def test_the_line_for_a_controller_is_the_body_at_the_flange(answer: PayloadAnswer) -> None:
    """To the digits shown, where the flange stands turned in the payload's frame."""
    result = replace(answer, verdict=Verdict("use", ())).result
    place = FlangeDocument((0.01, -0.02, 0.03), (30.0, -20.0, 70.0), "told")
    line = controller_line(structs.replace(result, frame="tool", flange_in_payload_frame=place))
    pose = Pose.from_rpy(place.xyz, np.radians(place.rpy_deg).tolist())
    assert answer.possible is not None
    body = answer.possible.body.moved(pose.R.T, -pose.R.T @ pose.p)
    inertia = body.inertia_com[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    for text, values in zip(re.findall(r"\(([^)]+)\)", line), (1e3 * body.com, inertia), strict=True):
        numbers = text.split(", ")
        digits = len(numbers[0].partition(".")[2])
        assert [float(number) for number in numbers] == pytest.approx(values, abs=0.51 * 10.0**-digits)
