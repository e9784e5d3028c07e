"""Faults: a fault of ours is one line and a file; outputs overwrite nothing; names are never markup.

Each law goes over every command and every option that names a file or a folder.
"""

import contextlib
import io
import re
import shutil
import tempfile
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from dynident.apps.commands import BROKEN_PIPE, entry
from dynident.apps.report.terminal import COLUMNS
from dynident.apps.report.terminal import LINES as LINES_OF_SCREEN
from dynident.cli import main
from dynident.tests.commands.declared import NAMES, written
from dynident.tests.commands.lines import LINES, PORTS, make_recordings, put_payloads
from dynident.tests.commands.runs import unread
from dynident.tests.frozen.freeze import settings
from dynident.tests.frozen.inputs import folder_of_inputs
from dynident.tests.live.played import playing
from dynident.tests.selection import every
from rich.cells import cell_len

pytestmark = pytest.mark.usefixtures("hasty")
ODD = Path("odd[") / "bold][red]"
"""A folder whose name looks like markup, with an end that has no beginning: "odd[/bold][red]"."""


OUTPUTS = [(name, option, kind) for name in NAMES for option, kind in written(name)]
FILES = [(name, option) for name, option, kind in OUTPUTS if kind == "file"]


@pytest.fixture(scope="module")
def folder() -> Iterator[Path]:
    """All inputs, in the working folder."""
    with folder_of_inputs() as here, playing(**PORTS):
        put_payloads(here)
        for name in ("before", "after"):
            shutil.copy(here / "rx_near_loaded.csv", here / f"{name}.csv")
        run([*words("identify"), "--json", "earlier.json"])
        make_recordings(here)
        yield here


def run(line: list[str]) -> tuple[int, str, str]:
    """Status, output, errors."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), settings():
        try:
            status = main(line)
        except SystemExit as stop:
            status = int(stop.code or 0)
    return status, out.getvalue(), err.getvalue()


def words(name: str) -> list[str]:
    """A command line that answers."""
    return [*name.split(), *LINES[name].split()]


def without(line: list[str], option: str) -> list[str]:
    """A line without an option and its value."""
    if option not in line:
        return line
    at = line.index(option)
    return line[:at] + line[at + 2 :]


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("name", LINES)
def test_a_fault_of_ours_is_one_line_and_a_file_of_details(
    name: str, folder: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Whatever is raised, with a message that looks like markup and runs over lines."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    for fault in (
        ValueError("one [/x]\ntwo"),
        RecursionError("deep"),
        MemoryError(),
        KeyError("k"),
        AssertionError(),
    ):

        def fail(*_: Any, fault: Exception = fault) -> None:
            raise fault

        with monkeypatch.context() as patch:
            patch.setattr(entry, "check_paths", fail)
            status, out, err = run(words(name))
        assert (status, out) == (3, "")
        assert len(err.splitlines()) == 1
        assert err.startswith("dynident: internal error, please report with ")
        (details,) = tmp_path.iterdir()
        assert str(details) in err
        text = details.read_text()
        assert f"dynident {name}" in text
        assert type(fault).__name__ in text
        assert "Traceback" in text
        assert "numpy" in text
        details.unlink()


@pytest.mark.parametrize("name", every(9, sorted(set(LINES) - {"apply", "record", "export", "robot list"})))
def test_whoever_reads_the_screen_may_leave(name: str, folder: Path) -> None:
    """`dynident .. | head`: all files are written; the status is the answer's, or says that the text was cut."""
    before = set(folder.rglob("*"))

    def made() -> set[str]:
        new = [path for path in folder.rglob("*") if path not in before]
        files = {str(path.relative_to(folder)) for path in new if path.is_file()}
        for path in sorted(new, reverse=True):
            path.rmdir() if path.is_dir() else path.unlink()
        return files

    status = run(words(name))[0]
    files, ending = made(), unread(words(name))
    assert ending in (status, BROKEN_PIPE)
    assert made() == files


def test_a_text_nobody_reads_ends_the_command(folder: Path) -> None:
    assert unread(["robot", "list"]) == BROKEN_PIPE


def test_a_fault_on_a_full_disk_is_one_line_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: Any, **__: Any) -> None:
        raise RuntimeError("boom")

    def full(*_: Any, **__: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(entry, "check_paths", fail)
    monkeypatch.setattr(tempfile, "NamedTemporaryFile", full)
    status, _, err = run(["robot", "list"])
    assert status == 3
    assert err == "dynident: internal error, please report (its details could not be written: No space left on " \
        "device): RuntimeError: boom\n"  # fmt: skip


def test_interruption_is_no_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(entry, "check_paths", interrupt)
    assert run(["robot", "list"])[0] == 130


def test_every_command_that_writes_is_seen() -> None:
    assert {name for name, _, _ in OUTPUTS} == set(LINES) - {"robot list", "apply"}


@pytest.mark.parametrize(("name", "option"), FILES, ids=lambda value: value)
def test_an_output_overwrites_no_input(name: str, option: str, folder: Path) -> None:
    """By its name, by another way to the same place, and by a link."""
    line, before = without(words(name), option), contents(folder)
    inputs = [word for word in line if (folder / word).is_file()]
    if not inputs:
        without_files = {"near", "design", "robot show", "robot new", "demo", "record", "fleet report"}
        assert name in without_files, "its line reads no file"
        return
    for path in inputs:
        Path("link").unlink(missing_ok=True)
        Path("link").symlink_to(path)
        for way in (path, str(Path(path).absolute()), f"./{path}", "link"):
            status, out, err = run([*line, option, way])
            assert (status, out) == (2, "")
            assert "this file too: give another one" in err
            assert f"{option} {way!r}" in err
        Path("link").unlink()
    assert contents(folder) == before


@pytest.mark.parametrize("name", dict.fromkeys(name for name, _ in FILES))
def test_no_two_outputs_are_one_file(name: str, folder: Path) -> None:
    options = [option for command, option in FILES if command == name]
    before, line = contents(folder), words(name)
    for option in options:
        line = without(line, option)
    for first, second in pairwise(options):
        status, out, err = run([*line, first, "new.out", second, "./new.out"])
        assert (status, out) == (2, "")
        assert f"{first} names this file too" in err or f"{second} names this file too" in err
    assert contents(folder) == before


@pytest.mark.parametrize("name", [name for name, option in FILES if option == "--report"])
def test_the_options_beside_a_report_overwrite_nothing(name: str, folder: Path) -> None:
    """An input or another output of that name, or a file that no run has written, is refused before any work."""
    before, line, beside = contents(folder), words(name), folder / "page.run.toml"
    inputs = [word for word in line if (folder / word).is_file()]
    second = next((option for command, option in FILES if (command, option) == (name, "--npz")), "--plots")
    for source in inputs:
        beside.symlink_to(folder / source)
        status, out, err = run([*line, "--report", "page.html"])
        beside.unlink()
        assert (status, out) == (2, "")
        assert "page.run.toml" in err
    if second == "--npz":
        status, out, err = run([*line, "--report", "page.html", second, "page.run.toml"])
        assert (status, out) == (2, "")
        assert f"--report's options 'page.run.toml': {second} names this file too" in err
    beside.write_text("mine = true\n")
    status, out, err = run([*line, "--report", "page.html"])
    assert (status, out) == (2, "")
    assert "page.run.toml beside it would be overwritten" in err
    assert beside.read_text() == "mine = true\n"
    beside.unlink()
    assert contents(folder) == before


def test_a_run_overwrites_the_options_of_an_earlier_one(folder: Path) -> None:
    (folder / "page.run.toml").write_text("# Options of a run, repeated by: dynident verify --config THIS_FILE\n")
    assert run([*words("verify"), "--report", "page.html", "--details"])[0] < 2
    assert "details = true" in (folder / "page.run.toml").read_text()
    for output in ("page.html", "page.run.toml"):
        (folder / output).unlink()


def test_a_drawing_beside_a_file_does_not_overwrite_it(folder: Path) -> None:
    """``robot new`` draws beside its file: named alike, the second is refused."""
    status, _, err = run([*words("robot new"), "--out", "arm.svg"])
    assert status == 2
    assert "arm.svg: this run has read or written it already" in err
    Path("arm.svg").unlink()


def test_titles_and_frames_are_never_markup(folder: Path) -> None:
    sheet = Path("markup.toml")
    line = [*words("robot new"), "--name", "[/n]", "--out", str(sheet)]
    status, _, err = run(line)
    assert status == 0
    assert err.startswith("dynident: note: to rehearse on it")
    text = re.sub(r"(?m)^title = .*$", 'title = "[/t] [red]"\nsource = "[/s]"', sheet.read_text())
    sheet.write_text(text.replace("the bare flange", "[/f] \\\\[b]"))
    status, out, err = run(["robot", "show", "--robot", str(sheet), "--drawing", "d.png"])
    assert (status, err) == (0, "")
    assert "[/t] [red]: modified DH" in out
    assert "[/f] \\[b]" in out
    for path in (sheet, Path("markup.svg"), Path("d.png")):
        path.unlink()


LISTINGS = ("apply", "robot list", "robot show", "codegen")
"""What prints a list or a table as long as the robot, not an answer."""
LIGHT = (
    "verify",
    "export",
    "robot show",
    "robot new",
    "robot export",
    "check",
    "robot check",
)


@pytest.mark.parametrize(
    "name", [name if name in LIGHT else pytest.param(name, marks=pytest.mark.long) for name in LINES]
)
def test_names_are_never_markup(name: str, folder: Path) -> None:
    """All files of a line in a folder whose name looks like markup, and all outputs too; the answer is a screen."""
    with tempfile.TemporaryDirectory() as there, contextlib.chdir(there):
        ODD.mkdir(parents=True)
        shutil.copytree(folder, ODD, dirs_exist_ok=True)
        line = [str(ODD / word) if (ODD / word).exists() else word for word in words(name)]
        outputs = {}
        for command, option, _ in OUTPUTS:
            if command == name:
                ending = "csv" if name == "record" else "svg"
                outputs[option] = ODD / ("odd_val3" if option == "--val3" else f"[b]{option[2:]}.{ending}")
                line = [*without(line, option), option, str(outputs[option])]
        status, out, err = run(line)
        assert status in (0, 1), err
        if name not in LISTINGS:
            assert len(out.splitlines()) <= LINES_OF_SCREEN
            assert max(map(cell_len, out.splitlines()), default=0) <= COLUMNS
        assert "internal error" not in err
        assert all(path.exists() for path in outputs.values())
