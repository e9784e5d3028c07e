"""Two reports, made by the commands from simulated recordings, and a reader of pages."""

from collections import Counter
from collections.abc import Callable, Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import NamedTuple

import pytest
from dynident.apps.commands.simulate import PAYLOAD
from dynident.apps.recordings import write_recording
from dynident.cli import main
from dynident.model import load_robot
from dynident.tests.frozen.inputs import filed
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points

VOID = {"meta", "link", "br", "img", "hr", "input"}


class Reader(HTMLParser):
    """Counts elements, collects identifiers, texts and attributes, and checks that elements close in order."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.count: Counter[str] = Counter()
        self.ids: list[str] = []
        self.attributes: list[tuple[str, str, str]] = []
        self.texts: dict[str, list[str]] = {}

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.count[tag] += 1
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        self.ids += [value or "" for name, value in attrs if name == "id"]
        if tag not in VOID:
            self.open.append(tag)
            self.texts.setdefault(tag, []).append("")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.handle_endtag(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        for tag in set(self.open):
            self.texts[tag][-1] += data


def read(text: str) -> Reader:
    reader = Reader()
    reader.feed(text)
    reader.close()
    assert not reader.open, "elements stay open"
    return reader


class Made(NamedTuple):
    """A report on disk, with the folder of its figures."""

    path: Path
    plots: Path

    @property
    def text(self) -> str:
        return self.path.read_text(encoding="utf-8")


Shared = Callable[[str, Callable[[Path], object]], Path]


@pytest.fixture(scope="session")
def short_logs(shared: Shared) -> Path:
    """RX90 logs: two trajectories, without and with the paper's payload."""

    def fill(folder: Path) -> None:
        robot = load_robot("rx90")
        simulator, load = Simulator(robot), PAYLOAD
        noise = tuple(0.2 * sigma for sigma in RX90_NOISE)
        for k in range(2):
            motion = random_via_points(robot, 10, seed=k).motion(250.0)
            for name, body in (("bare", None), ("loaded", load)):
                recording = simulator.record(motion, body, noise, [k, body is not None])
                write_recording(folder / f"{name}{k}.csv", recording)

    return shared("short_logs", fill)


@pytest.fixture(scope="session")
def fixed_date() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SOURCE_DATE_EPOCH", "1000000000")
        yield


@pytest.fixture(scope="session")
def payload_report(shared: Shared, short_logs: Path, fixed_date: None) -> Made:
    return written(shared, "payload_report", lambda *files: payload_command(short_logs, *files))


@pytest.fixture(scope="session")
def robot_report(shared: Shared, short_logs: Path, fixed_date: None) -> Made:
    line = ["identify", "--robot", "rx90", "--data", str(short_logs / "bare0.csv")]
    return written(shared, "robot_report", lambda page, plots: [*line, "--report", str(page), f"plots={plots}"])


def written(shared: Shared, name: str, line: Callable[[Path, Path], list[str]]) -> Made:
    def fill(folder: Path) -> None:
        assert main(filed(line(folder / "page.html", folder / "plots"))) == 0

    folder = shared(name, fill)
    return Made(folder / "page.html", folder / "plots")


def payload_command(folder: Path, report: Path, plots: Path) -> list[str]:
    files = ["--unloaded", str(folder / "bare0.csv"), "--loaded", str(folder / "loaded0.csv")]
    files += ["--validate", str(folder / "bare1.csv")]
    weighed = ["--mass", "7.03+-0.05"]
    return filed(["payload", "--robot", "rx90", *files, *weighed, "--report", str(report), f"plots={plots}"])
