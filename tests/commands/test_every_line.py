"""Laws over every command: faults, files, names, help, options from files, progress and interruptions."""

import contextlib
import json
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import pytest
from cyclopts import CycloptsError
from dynident.apps.commands import BROKEN_PIPE, COMMANDS, entry
from dynident.apps.commands.entry import application
from dynident.apps.report.blocks import COLUMNS, Notes, Report, print_report
from dynident.apps.report.blocks import LINES as LINES_OF_SCREEN
from dynident.common.errors import InputError
from dynident.model import load_robot
from dynident.tests.commands.lines import LINES, log
from dynident.tests.commands.test_options import SPEAKS_TO_TERMINALS
from dynident.tests.commands.typed import parsed, refused, typed, unread, written
from dynident.tests.common.test_hostile_files import FILES as HOSTILE
from dynident.tests.frozen.inputs import NAMES, arguments
from dynident.tests.selection import cases, every
from dynident.trajectories import Simulator, random_via_points
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
@pytest.mark.usefixtures("drawn_empty")
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
    assert status in (0, 1)
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
            assert f"{option} {path!r}: no file can be written there" in refused(line, f"{option}={path}")
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
        why = "is a file, not a folder" if wrong == str(blocker) else "a folder cannot be made there"
        assert f"{line.split()[-1]} {wrong!r}: {why}" in error
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
def test_names_are_never_markup(name: str, folder: Path, request: pytest.FixtureRequest) -> None:
    """All files of a line in a folder whose name looks like markup, and all outputs too; the answer is a screen."""
    if name == "demo":  # its figures are those of payload and identify
        request.getfixturevalue("drawn_empty")
    with tempfile.TemporaryDirectory() as there, contextlib.chdir(there):
        ODD.mkdir(parents=True)
        shutil.copytree(folder, ODD, dirs_exist_ok=True)
        ending = "csv" if name == "record" else "svg"
        own = [option for command, option, _ in OUTPUTS if command == name]
        own = [option for option in own if (name, option) != ("near", "--val3")]  # for poses at rest alone
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
    for source in logs_of(name):
        lines = (folder / source).read_text().splitlines(keepends=True)
        head = next(k for k, line in enumerate(lines) if not line.startswith("#")) + 1
        for rows in (0, 1, 2, 3, 10):
            short = tmp_path / f"{rows}.csv"
            short.write_text("".join(lines[: head + rows]))
            line = [str(short) if word == source else word for word in words(name)]
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


@pytest.fixture(scope="module")
def check(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """A look at a short recording, in a folder whose name looks like markup."""
    folder = tmp_path_factory.mktemp("logs") / "[/x]"
    folder.mkdir(parents=True)
    robot = load_robot("rx90")
    motion = random_via_points(robot, 6, seed=1).motion(100.0)
    log(folder / "a.csv", Simulator(robot).record(motion, None, [0.3] * 6, 0))
    return ["check", "--robot", "rx90", str(folder / "a.csv")]


def test_no_command_prints_the_help() -> None:
    ended = typed("")
    assert ended.status == 2
    assert all(name in ended.out for name in COMMANDS if " " not in name)


def test_json_on_standard_output_stands_alone(check: list[str]) -> None:
    ended = typed(check, "--json", "-")
    assert json.loads(ended.out)["robot"] == "rx90"
    assert "[/x]" in ended.err.replace("\n", "")


def test_quiet_says_nothing_and_verbose_the_time(check: list[str]) -> None:
    loud = typed(check)
    assert "[/x]" in loud.out.replace("\n", "")
    assert typed(check, "--quiet") == (loud.status, "", "")
    assert "s  check: done" in typed(check, "verbose=true").err


@pytest.mark.parametrize("words", [("--at", "-1,2,3,4,5,6"), ("--at=-1,2,3,4,5,6",)])
def test_lists_may_begin_with_a_minus(words: tuple[str, ...]) -> None:
    assert parsed(["robot", "show", "--robot", "rx90", *words])[0]["at"] == (-1, 2, 3, 4, 5, 6)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_is_eighty_columns_wide_and_names_every_option_but_the_rare_ones(name: str) -> None:
    ended = typed(f"{name} --help")
    lines = ended.out.splitlines()
    assert ended.status == 0
    assert lines[0].startswith(f"Usage: dynident {name}")
    assert max(map(len, lines)) <= 80
    own = arguments(name) if name in NAMES else []
    shown = {argument.name for argument in own if argument.show and argument.name.startswith("--")}
    assert shown <= set(re.findall(r"--[a-z0-9-]+", ended.out))


CONFIG = {"robot": "rx90", "signs": [-1, 1, 1, 1, 1, 1], "loaded": ["a.csv", "b.csv"], "offsets": False}
CONFIG |= {"details": True}


def test_a_file_of_options_stands_for_a_command_line(tmp_path: Path) -> None:
    path = tmp_path / "run.toml"
    path.write_text("\n".join(f"{key} = {json.dumps(value)}" for key, value in CONFIG.items()))
    read, _ = parsed(["payload", "--config", str(path)])
    assert (read["robot"], read["loaded"]) == ("rx90", ("a.csv", "b.csv"))
    assert read["signs"] == (-1, 1, 1, 1, 1, 1)
    assert read["offsets"] is False
    assert read["details"]
    read, _ = parsed(["payload", "--config", str(path), "--robot", "tx40", "--loaded", "c.csv"])
    assert (read["robot"], read["loaded"]) == ("tx40", ("c.csv",)), "what is typed goes first"


@pytest.mark.parametrize(
    "line",
    [
        'payload --robot rx90 --loaded a.csv --loaded b"c".csv offsets=false signs=-1,1',
        "check --robot rx90 a.csv b.csv --cutoff 5",
        "identify --data=a.csv --robot=rx90 --total-mass 20 60 --details",
        "robot show --robot ur10e --at -10,20,30,40,50,60",
    ],
)
def test_the_file_of_a_run_repeats_it(line: str, tmp_path: Path) -> None:
    words = line.split()
    typed_options, call = parsed(words)
    (_, text), command = call.settings("b.html") or ("", ""), words[: 2 if words[0] == "robot" else 1]
    assert tomllib.loads(text)["command"] == " ".join(command)
    (tmp_path / "run.toml").write_text(text, encoding="utf-8")
    read, _ = parsed([*command, "--config", str(tmp_path / "run.toml")])
    assert read.pop("config")
    typed_options.pop("config")
    assert repr(read) == repr(typed_options)  # some values are arrays


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('robot = "rx90"\nloaded = ["a"]\ndetails = 3', 'unable to convert "3" into bool'),
        ("robot = {a = 1}", 'Unknown option: "[robot][a]"'),
    ],
)
def test_a_wrong_file_of_options_is_one_line(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "run.toml").write_text(text)
    with pytest.raises((InputError, CycloptsError), match=r"run\.toml") as error:
        parsed(["payload", "--config", str(tmp_path / "run.toml")])
    assert message in str(error.value)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_a_full_disk_is_one_line(check: list[str]) -> None:
    assert "/dev/full" in refused(check, "--quiet", "--json", "/dev/full")


def test_what_is_printed_moves_no_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    print_report(Report("", [Notes([SPEAKS_TO_TERMINALS])]), details=True)
    assert capsys.readouterr().out == "\\x1b[31m\\x9b2J\\u202e\\udcff\n"


INTERRUPTED_AT = """
import os, signal, sys
from importlib.abc import MetaPathFinder

class Interrupting(MetaPathFinder):
    left = None

    def find_spec(self, name, path, target=None):
        if name == "dynident.apps.commands.entry":  # the first module of a command
            self.left = abs(int(place))
        if self.left is not None:
            self.left -= 1
            if self.left == -1:
                try:
                    os.kill(os.getpid(), signal.SIGINT)
                except KeyboardInterrupt as interruption:
                    raise AttributeError if place.startswith("-") else interruption

sys.meta_path.insert(0, Interrupting())
place, sys.argv = sys.argv[-1], ["dynident", "robot", "list"]
from dynident.cli import main
raise SystemExit(main())
"""
"""A run that is interrupted at one of its imports, counted from the first one of its command.

At a negative place as compiled code does it: what arrives is another exception.
"""


@pytest.mark.parametrize("place", [0, 1, 5, 25, 80, 160, -5])
def test_an_interruption_at_an_import_is_one_line(place: int) -> None:
    line = [sys.executable, "-c", INTERRUPTED_AT, str(place)]
    ended = subprocess.run(line, check=False, capture_output=True, text=True)
    assert ended.returncode in (130, -signal.SIGINT), "a shell tells 130 of both"
    assert ended.stderr == "dynident: interrupted\n"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_shell_can_complete(shell: Literal["bash", "zsh", "fish"]) -> None:
    script = application().generate_completion(shell=shell)
    assert "robot-parameters" in script
    assert "mjcf" in script, "the choices of an option of a command below another one"


def test_a_log_of_no_robot_says_what_is_in_it(here: Path) -> None:
    (here / "log.csv").write_text("t,x,y\n" + "".join(f"{0.01 * k},1,2\n" for k in range(100)))
    ended = typed("check log.csv --details")
    assert ended.status == 1
    assert "columns t, x, y Fix first:" in ended.text
    assert "missing" in ended.out
