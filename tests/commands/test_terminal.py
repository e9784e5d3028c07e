"""What every command has: quiet and verbose, a file of options, lists that begin with a minus, no traceback."""

import json
import os
import re
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from cyclopts import CycloptsError
from dynident.apps.commands import COMMANDS
from dynident.apps.commands.entry import application
from dynident.apps.commands.settings import settings_text
from dynident.cli import main
from dynident.common.errors import InputError
from dynident.model import load_robot
from dynident.tests.commands.declared import NAMES, arguments, options, parsed
from dynident.trajectories import Simulator, random_via_points

PROGRAM = [sys.executable, "-m", "dynident"]
STOPPED = (130, -signal.SIGINT)
"""What an interrupted command ends with; a shell tells 130 of both."""


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A short recording, in a folder whose name looks like markup."""
    folder = tmp_path_factory.mktemp("logs") / "[/x]"
    folder.mkdir(parents=True)
    robot = load_robot("rx90")
    recording = Simulator(robot).record(random_via_points(robot, 6, seed=1).motion(100.0), None, [0.3] * 6, 0)
    header = ",".join(["t"] + [f"{kind}{j}" for kind in ("q", "tau") for j in range(1, 7)])
    values = np.column_stack([recording.t, recording.q, recording.torque])
    np.savetxt(
        folder / "a.csv", values, delimiter=",", header="# gain_sigma = 0\n" + header, comments="", fmt="%.9g"
    )
    return str(folder / "a.csv")


def test_no_command_prints_the_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 2
    printed = capsys.readouterr().out
    assert all(name in printed for name in COMMANDS if " " not in name)


def test_json_on_standard_output_stands_alone(log: str, capsys: pytest.CaptureFixture[str]) -> None:
    main(["check", "--robot", "rx90", log, "--json", "-"])
    printed = capsys.readouterr()
    assert json.loads(printed.out)["robot"] == "rx90"
    assert "[/x]" in printed.err.replace("\n", "")


def test_quiet_says_nothing(log: str, capsys: pytest.CaptureFixture[str]) -> None:
    loud = main(["check", "--robot", "rx90", log])
    assert "[/x]" in capsys.readouterr().out.replace("\n", "")
    assert main(["check", "--robot", "rx90", log, "--quiet"]) == loud
    assert capsys.readouterr() == ("", "")


def test_verbose_tells_the_time(log: str, capsys: pytest.CaptureFixture[str]) -> None:
    main(["check", "--robot", "rx90", log, "--verbose"])
    assert "s  check: done" in capsys.readouterr().err


def test_lists_may_begin_with_a_minus(log: str, capsys: pytest.CaptureFixture[str]) -> None:
    main(["check", "--robot", "rx90", log, "--signs", "-1,1,1,1,1,1", "--json", "-"])
    turned = json.loads(capsys.readouterr().out)
    main(["check", "--robot", "rx90", log, "--signs=-1,1,1,1,1,1", "--json", "-"])
    assert json.loads(capsys.readouterr().out) == turned


@pytest.mark.parametrize("name", NAMES)
def test_every_command_has_them(name: str) -> None:
    assert {"--quiet", "--verbose", "--config"} <= set(options(name))


@pytest.mark.parametrize("name", COMMANDS)
def test_every_help_is_eighty_columns_wide(
    name: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    assert main([*name.split(), "--help"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith(f"Usage: dynident {name}")
    assert max(map(len, lines)) <= 80


@pytest.mark.parametrize("name", NAMES)
def test_help_names_every_option_but_the_rare_ones(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*name.split(), "--help"]) == 0
    printed = set(re.findall(r"--[a-z0-9-]+", capsys.readouterr().out))
    shown = {argument.name for argument in arguments(name) if argument.show and argument.name.startswith("--")}
    assert shown <= printed, sorted(shown - printed)


CONFIG = {
    "robot": "rx90",
    "signs": [-1, 1, 1, 1, 1, 1],
    "loaded": ["a.csv", "b.csv"],
    "offsets": False,
    "details": True,
}


def written(path: Path, table: dict[str, object]) -> str:
    path.write_text("\n".join(f"{key} = {json.dumps(value)}" for key, value in table.items()))
    return str(path)


def test_a_file_of_options_stands_for_a_command_line(tmp_path: Path) -> None:
    path = written(tmp_path / "run.toml", CONFIG)
    read, _ = parsed(["payload", "--config", path])
    assert (read["arm"].robot, read["request"].loaded) == ("rx90", ("a.csv", "b.csv"))
    assert read["processing"].signs == (-1, 1, 1, 1, 1, 1)
    assert read["processing"].offsets is False
    assert read["files"].details
    read, _ = parsed(["payload", "--config", path, "--robot", "tx40", "--loaded", "c.csv"])
    assert (read["arm"].robot, read["request"].loaded) == ("tx40", ("c.csv",)), "what is typed goes first"


@pytest.mark.parametrize(
    "words",
    [
        [
            "payload",
            "--robot",
            "rx90",
            "--loaded",
            "a.csv",
            "--loaded",
            'b "c".csv',
            "--offsets",
            "false",
            "--signs",
            "-1,1",
        ],
        ["check", "--robot", "rx90", "a.csv", "b.csv", "--cutoff", "5"],
        ["identify", "--data=a.csv", "--robot=rx90", "--total-mass", "20", "60", "--details"],
        ["robot", "show", "--robot", "ur10e", "--at", "-10,20,30,40,50,60"],
    ],
)
def test_the_file_of_a_run_repeats_it(words: list[str], tmp_path: Path) -> None:
    typed, call = parsed(words)
    text, command = settings_text(call), words[: 2 if words[0] == "robot" else 1]
    assert tomllib.loads(text)["command"] == " ".join(command)
    (tmp_path / "run.toml").write_text(text, encoding="utf-8")
    read, _ = parsed([*command, "--config", str(tmp_path / "run.toml")])
    assert read.pop("terminal").config
    typed.pop("terminal")
    assert repr(read) == repr(typed)  # some values are arrays


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"robott": "rx90"}, "Did you mean --robot?"),
        ({"command": "weigh"}, "is for 'dynident weigh'"),
        ({"robot": "rx90", "loaded": ["a"], "details": 3}, 'unable to convert "3" into bool'),
        ({"robot": {"a": 1}}, 'Unknown option: "[robot][a]"'),
    ],
)
def test_a_wrong_file_of_options_is_one_line(table: dict[str, object], message: str, tmp_path: Path) -> None:
    path = tmp_path / "run.toml"
    path.write_text(
        "\n".join(f"{k} = {'{a = 1}' if isinstance(v, dict) else json.dumps(v)}" for k, v in table.items())
    )
    with pytest.raises((InputError, CycloptsError), match=r"run\.toml") as error:
        parsed(["payload", "--config", str(path)])
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("name", "number"), [("known-robot", "1"), ("change", "2"), ("difference", "3"), ("global", "4")]
)
def test_methods_have_names(name: str, number: str) -> None:
    line = ["payload", "--robot", "rx90", "--loaded", "a.csv", "--method"]
    assert [parsed([*line, word])[0]["request"].method for word in (name, number)] == [number, number]


def test_a_full_disk_is_one_line(log: str, capsys: pytest.CaptureFixture[str]) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    assert main(["check", "--robot", "rx90", log, "--quiet", "--json", "/dev/full"]) == 2
    err = capsys.readouterr().err
    assert "/dev/full" in err
    assert err.count("\n") == 1


@pytest.mark.long
@pytest.mark.parametrize("after", [0.2, 0.3, 0.4, 0.6, 0.8, 1.2, 1.6, 3.0])
def test_an_interruption_is_one_line(after: float, log: str) -> None:
    line = [*PROGRAM, "check", "--robot", "rx90", log]
    with subprocess.Popen(line, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        started = time.monotonic()
        while process.poll() is None and time.monotonic() < started + after:
            time.sleep(0.005)
        if process.poll() is None:
            os.kill(process.pid, signal.SIGINT)
        out, err = process.communicate()
    assert process.returncode in (0, 1, *STOPPED)
    answered = process.returncode == -signal.SIGINT and out.endswith("\n")  # while the interpreter ended
    if process.returncode in STOPPED and not answered:
        assert err.strip().splitlines()[-1:] == ["dynident: interrupted"]
    assert "Traceback" not in err


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
