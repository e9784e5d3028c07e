"""Every command has help, quiet and verbose, a file of options, progress, interruptions, no traceback."""

import json
import re
import signal
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Literal

import pytest
from cyclopts import CycloptsError
from dynident.apps.commands import COMMANDS
from dynident.apps.commands.entry import application
from dynident.apps.commands.settings import settings_text
from dynident.apps.report import Notes, print_blocks
from dynident.common.errors import InputError
from dynident.model import load_robot
from dynident.tests.commands.lines import log
from dynident.tests.commands.test_options import SPEAKS_TO_TERMINALS
from dynident.tests.commands.typed import NAMES, arguments, parsed, refused, typed
from dynident.trajectories import Simulator, random_via_points

STOPPED = (130, -signal.SIGINT)
"""An interrupted command ends with one of these; a shell tells 130 of both."""


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


CONFIG = {
    "robot": "rx90",
    "signs": [-1, 1, 1, 1, 1, 1],
    "loaded": ["a.csv", "b.csv"],
    "offsets": False,
    "details": True,
}


def test_a_file_of_options_stands_for_a_command_line(tmp_path: Path) -> None:
    path = tmp_path / "run.toml"
    path.write_text("\n".join(f"{key} = {json.dumps(value)}" for key, value in CONFIG.items()))
    read, _ = parsed(["payload", "--config", str(path)])
    assert (read["arm"].robot, read["request"].loaded) == ("rx90", ("a.csv", "b.csv"))
    assert read["processing"].signs == (-1, 1, 1, 1, 1, 1)
    assert read["processing"].offsets is False
    assert read["files"].details
    read, _ = parsed(["payload", "--config", str(path), "--robot", "tx40", "--loaded", "c.csv"])
    assert (read["arm"].robot, read["request"].loaded) == ("tx40", ("c.csv",)), "what is typed goes first"


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
    text, command = settings_text(call), words[: 2 if words[0] == "robot" else 1]
    assert tomllib.loads(text)["command"] == " ".join(command)
    (tmp_path / "run.toml").write_text(text, encoding="utf-8")
    read, _ = parsed([*command, "--config", str(tmp_path / "run.toml")])
    assert read.pop("terminal").config
    typed_options.pop("terminal")
    assert repr(read) == repr(typed_options)  # some values are arrays


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('robott = "rx90"', "Did you mean --robot?"),
        ('command = "weigh"', "is for 'dynident weigh'"),
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
    print_blocks([Notes([SPEAKS_TO_TERMINALS])])
    assert capsys.readouterr().out == "\\x1b[31m\\x9b2J\\u202e\\udcff\n"


INTERRUPTED_AT = """
import os, signal, sys
from importlib.abc import MetaPathFinder

class Interrupting(MetaPathFinder):
    left = None

    def find_spec(self, name, path, target=None):
        if name == "dynident.apps.commands.entry":  # the first module of a command
            self.left = int(place)
        if self.left is not None:
            self.left -= 1
            if self.left == -1:
                os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupting())
place, sys.argv = sys.argv[-1], ["dynident", "robot", "list"]
from dynident.cli import main
raise SystemExit(main())
"""
"""A run that is interrupted at one of its imports, counted from the first one of its command."""


@pytest.mark.parametrize("place", [0, 1, 5, 25, 80, 160])
def test_an_interruption_at_an_import_is_one_line(place: int) -> None:
    line = [sys.executable, "-c", INTERRUPTED_AT, str(place)]
    ended = subprocess.run(line, check=False, capture_output=True, text=True)
    assert ended.returncode in STOPPED
    assert ended.stderr == "dynident: interrupted\n"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_shell_can_complete(shell: Literal["bash", "zsh", "fish"]) -> None:
    script = application([], ()).generate_completion(shell=shell)
    assert "robot-parameters" in script
    assert "mjcf" in script, "the choices of an option of a command below another one"


def test_a_log_of_no_robot_says_what_is_in_it(here: Path) -> None:
    (here / "log.csv").write_text("t,x,y\n" + "".join(f"{0.01 * k},1,2\n" for k in range(100)))
    ended = typed("check log.csv --details")
    assert ended.status == 1
    assert "columns t, x, y Mend first:" in ended.text
    assert "missing" in ended.out
