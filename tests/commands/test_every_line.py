"""Laws over every command, and every option that names a file or a folder.

A fault of ours is one line and a file; outputs overwrite nothing; names are never markup; too few rows are told;
whoever reads may leave.
"""

import contextlib
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from dynident.apps.commands import BROKEN_PIPE, entry
from dynident.apps.report.terminal import COLUMNS
from dynident.apps.report.terminal import LINES as LINES_OF_SCREEN
from dynident.tests.commands.lines import LINES
from dynident.tests.commands.typed import NAMES, refused, typed, unread, written
from dynident.tests.common.test_hostile_files import FILES as HOSTILE
from dynident.tests.selection import cases, every
from rich.cells import cell_len

pytestmark = pytest.mark.usefixtures("hasty")
ODD = Path("odd[") / "bold][red]"
"""A folder whose name looks like markup, with an end that has no beginning: "odd[/bold][red]"."""
OUTPUTS = [(name, option, kind) for name in NAMES for option, kind in written(name)]
FILES = [(name, option) for name, option, kind in OUTPUTS if kind == "file"]
WRITERS = list(dict.fromkeys(name for name, _ in FILES))


def words(name: str, *without: str) -> list[str]:
    """A command line that answers, without some options and their values."""
    line = [*name.split(), *LINES[name].split()]
    for option in without:
        if option in line:
            del line[line.index(option) : line.index(option) + 2]
    return line


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def raising(fault: BaseException) -> Any:
    """Whatever is asked for, it is raised."""

    def fail(*_: Any, **__: Any) -> None:
        raise fault

    return fail


@pytest.mark.parametrize("name", sorted(set(LINES) - {"robot list"}))
def test_a_fault_of_ours_is_one_line_and_a_file_of_details(
    name: str, folder: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Whatever is raised, with a message that looks like markup and runs over lines."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    faults = ValueError("one [/x]\ntwo"), RecursionError("deep"), MemoryError(), KeyError("k"), AssertionError()
    for fault in faults:
        monkeypatch.setattr(entry, "check_paths", raising(fault))
        status, out, err = typed(words(name))
        assert (status, out, len(err.splitlines())) == (3, "", 1)
        assert err.startswith("dynident: internal error, please report with ")
        (details,) = tmp_path.iterdir()
        assert str(details) in err
        told = (f"dynident {name}", type(fault).__name__, "Traceback", "numpy")
        assert all(part in details.read_text() for part in told)
        details.unlink()


def test_interruption_is_no_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(entry, "check_paths", raising(KeyboardInterrupt()))
    assert typed("robot show --robot rx90").status == 130


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

    status = typed(words(name)).status
    files, ending = made(), unread(words(name))
    assert ending in (status, BROKEN_PIPE)
    assert made() == files


def test_a_text_nobody_reads_ends_the_command() -> None:
    assert unread(["robot", "list"]) == BROKEN_PIPE


@pytest.mark.parametrize(
    ("line", "status"),
    [
        ("check gone.csv 2> /dev/full", 2),
        ("check --gone 2> /dev/full", 2),
        ("robot list >&-", 0),
        ("check gone.csv 2>&-", 2),
    ],
)
def test_streams_that_are_full_or_closed_keep_the_status(line: str, status: int) -> None:
    program = f"{sys.executable} -c 'import sys; from dynident.cli import main; sys.exit(main())'"
    ended = subprocess.run(["sh", "-c", f"{program} {line}"], capture_output=True, text=True, check=False)
    assert ended.returncode == status
    assert "dynident" not in ended.stdout


def test_every_command_that_writes_is_seen() -> None:
    assert {name for name, _, _ in OUTPUTS} == set(LINES) - {"robot list", "apply"}


@pytest.mark.parametrize(("name", "option"), FILES, ids=lambda value: value)
def test_an_output_overwrites_no_input(name: str, option: str, folder: Path) -> None:
    """By its name, by another way to the same place, and by a link."""
    line, before = words(name, option), contents(folder)
    inputs = [word for word in line if (folder / word).is_file()]
    without_files = {"near", "design", "robot show", "robot new", "demo", "record", "fleet report"}
    assert bool(inputs) or name in without_files, "its line reads no file"
    for path in inputs:
        Path("link").symlink_to(path)
        for way in (path, str(Path(path).absolute()), f"./{path}", "link"):
            error = refused(line, option, way)
            assert "this file too: give another one" in error
            assert f"{option} {way!r}" in error
        Path("link").unlink()
    assert contents(folder) == before


@pytest.mark.parametrize("name", WRITERS)
def test_no_two_outputs_are_one_file(name: str, folder: Path) -> None:
    """Nor a file and a folder; nor is a folder a file."""
    own = [option for command, option in FILES if command == name]
    folders = [option for command, option, kind in OUTPUTS if (command, kind) == (name, "folder")]
    before, line = contents(folder), words(name, *own, *folders)
    for first, second in [*pairwise(own), *((option, other) for option in own for other in folders)]:
        error = refused(line, first, "new.out", second, "./new.out")
        assert f"{first} names this file too" in error or f"{second} names this file too" in error
    for option in own:
        for path in (".", "..", "/", ""):
            assert f"{option} {path!r}: not a file" in refused(line, f"{option}={path}")
    assert contents(folder) == before


@pytest.mark.parametrize(
    "line",
    ["weigh --loaded x.csv --unloaded y.csv plots", "payload --loaded x.csv --unloaded y.csv plots",
     "identify --data x.csv plots", "check x.csv plots", "design plots", "design --val3"],
)  # fmt: skip
def test_a_folder_that_is_a_file_is_told_before_anything_is_read(here: Path, line: str) -> None:
    blocker = here / "taken"
    blocker.write_text("mine", encoding="utf-8")
    for wrong in (str(blocker), str(blocker / "inside"), ""):
        error = refused(f"{line.split()[0]} --robot rx90 {' '.join(line.split()[1:])}={wrong}")
        assert f"{line.split()[-1]} {wrong!r}: is not a folder" in error
    assert contents(here) == {"taken": b"mine"}


@pytest.mark.parametrize("name", [name for name, option in FILES if option == "--report"])
def test_the_options_beside_a_report_overwrite_nothing(name: str, folder: Path) -> None:
    """An input or another output of that name, or a file that no run has written, is refused before any work."""
    before, line, beside = contents(folder), words(name), folder / "page.run.toml"
    for source in [word for word in line if (folder / word).is_file()]:
        beside.symlink_to(folder / source)
        assert "page.run.toml" in refused(line, "--report", "page.html")
        beside.unlink()
    if (name, "--npz") in FILES:
        error = refused(line, "--report", "page.html", "--npz", "page.run.toml")
        assert "--report's options 'page.run.toml': --npz names this file too" in error
    beside.write_text("mine = true\n")
    assert "page.run.toml beside it would be overwritten" in refused(line, "--report", "page.html")
    assert beside.read_text() == "mine = true\n"
    beside.unlink()
    assert contents(folder) == before


LISTINGS = ("apply", "robot list", "robot show", "codegen")
"""These print a list or a table as long as the robot, not an answer."""
LIGHT = ("verify", "export", "robot show", "robot new", "robot export", "check", "robot check")


@pytest.mark.parametrize("name", cases(LINES, lambda name: name in LIGHT))
def test_names_are_never_markup(name: str, folder: Path) -> None:
    """All files of a line in a folder whose name looks like markup, and all outputs too; the answer is a screen."""
    with tempfile.TemporaryDirectory() as there, contextlib.chdir(there):
        ODD.mkdir(parents=True)
        shutil.copytree(folder, ODD, dirs_exist_ok=True)
        ending = "csv" if name == "record" else "svg"
        own = [option for command, option, _ in OUTPUTS if command == name]
        outputs = {option: ODD / f"[b]{option[2:]}.{ending}" for option in own}
        outputs |= {option: ODD / "odd_val3" for option in own if option == "--val3"}
        line = [str(ODD / word) if (ODD / word).exists() else word for word in words(name, *own)]
        status, out, err = typed(line, *(str(part) for output in outputs.items() for part in output))
        assert status in (0, 1), err
        if name not in LISTINGS:
            assert len(out.splitlines()) <= LINES_OF_SCREEN
            assert max(map(cell_len, out.splitlines()), default=0) <= COLUMNS
        assert "internal error" not in err
        assert all(path.exists() for path in outputs.values())


def logs_of(name: str) -> Iterator[str]:
    """The recordings that a command's line names."""
    return (word for word in words(name) if word.endswith(".csv") and "--out" not in word)


READERS = [name for name in LINES if any(logs_of(name)) and name != "record"]


@pytest.mark.parametrize("name", cases(READERS, lambda name: name not in ("score", "rollout")))
def test_a_recording_of_a_few_rows_is_one_line(name: str, folder: Path, tmp_path: Path) -> None:
    """Each recording of the line in turn, cut short; of a look at logs, and of a motion, a few rows may do."""
    statuses = set[int]()
    for log in logs_of(name):
        lines = (folder / log).read_text().splitlines(keepends=True)
        head = next(k for k, line in enumerate(lines) if not line.startswith("#")) + 1
        for rows in (0, 1, 2, 3, 10):
            short = tmp_path / f"{rows}.csv"
            short.write_text("".join(lines[: head + rows]))
            line = [str(short) if word == log else word for word in words(name)]
            ended = typed([str(tmp_path / word) if word in ("b.json", "out", "store") else word for word in line])
            statuses.add(ended.status)
            assert ended.status in (0, 1, 2), (rows, ended.err)
            assert len(ended.errors) == (ended.status == 2), (rows, ended.err)
    assert statuses & {1, 2}


@pytest.mark.parametrize("name", HOSTILE)
def test_no_file_of_options_breaks_or_stalls_a_command(name: str, here: Path) -> None:
    text, reason = HOSTILE[name]
    (here / "run.toml").write_text(text)
    assert reason in refused("check --config run.toml")


@pytest.mark.parametrize("path", ["/dev/full", "/dev/zero"])
def test_a_file_of_options_without_end_is_none(path: str) -> None:
    if not Path(path).exists():
        pytest.skip(f"no {path} here")
    assert "larger than" in refused(f"check --config {path}")


def test_links_in_a_circle_lead_nowhere(here: Path) -> None:
    (here / "circle").symlink_to(here / "circle")
    data = "identify --robot rx90 --data x.csv"
    for line in ("check --robot rx90 circle", f"{data} --json circle/a.json", f"{data} plots=circle",
                 "fleet report circle"):  # fmt: skip
        assert "circle" in refused(line)
