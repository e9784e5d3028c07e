"""Words that nobody means: numbers of no use, letters that move a terminal, paths that lead nowhere.

Each law goes over every option of every command.
"""

import contextlib
import io
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from cyclopts import Token
from dynident.apps.report import Notes, print_blocks
from dynident.cli import main
from dynident.tests.commands.declared import NAMES, arguments, parsed
from dynident.tests.commands.test_faults import FILES as OUTPUT_FILES
from dynident.tests.commands.test_faults import OUTPUTS, without, words
from dynident.tests.common.test_hostile_files import FILES

ODD_NUMBERS = ("nan", "inf", "-inf", "1e308", "-1e308", "1e300", "5e-324", "1e-300", "9" * 5000)
SPEAKS_TO_TERMINALS = "\x1b[31m\x9b2J\u202e\udcff"
"""Colours, clears the screen, turns the direction of writing, and a byte that is no letter."""
LONGEST = 1200


def numbers(value: Any) -> Iterator[float]:
    """All numbers in what an option's words became."""
    if isinstance(value, tuple | list):
        for part in value:
            yield from numbers(part)
    elif isinstance(value, int | float):
        yield value


@pytest.mark.parametrize("command", NAMES)
def test_no_option_takes_a_number_that_no_arm_has(command: str) -> None:
    """Refused, or read as a text; squares of what is taken are finite, and not lost beside others."""
    texts = [text for odd in ODD_NUMBERS for text in (odd, f"{odd}%", f"1,{odd}", ",".join(6 * [odd]))]
    for argument in arguments(command):
        read: Any = argument.parameter.converter
        for text in texts if read else ():
            with contextlib.suppress(ValueError):
                values = list(numbers(read(None, (Token(value=text),))))
                assert all(x == 0.0 or 1e-14 <= abs(x) <= 1e9 for x in values), (argument.name, text)


def one_line(words: list[str]) -> str:
    """What a line that cannot be used is answered with."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            status = main(words)
        except SystemExit as stop:
            status = int(stop.code or 0)
    assert (status, out.getvalue()) == (2, "")
    (line,) = err.getvalue().splitlines()
    assert line.isprintable()
    assert len(line) < LONGEST
    return line


@pytest.mark.parametrize("command", NAMES)
def test_a_wrong_word_is_shown_in_one_line(command: str) -> None:
    for odd in (SPEAKS_TO_TERMINALS, "x\ny", "9" * 5000):
        assert one_line([*command.split(), f"--config={odd}"])
        assert one_line([*command.split(), f"--quiet={odd}"])


def test_what_is_printed_moves_no_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    print_blocks([Notes([SPEAKS_TO_TERMINALS])])
    assert capsys.readouterr().out == "\\x1b[31m\\x9b2J\\u202e\\udcff\n"


@pytest.mark.parametrize("name", FILES)
def test_no_file_of_options_breaks_or_stalls_a_command(name: str, tmp_path: Path) -> None:
    text, reason = FILES[name]
    (tmp_path / "run.toml").write_text(text)
    assert reason in one_line(["check", "--config", str(tmp_path / "run.toml")])


@pytest.mark.parametrize("path", ["/dev/full", "/dev/zero"])
def test_a_file_of_options_without_end_is_none(path: str) -> None:
    if not Path(path).exists():
        pytest.skip(f"no {path} here")
    assert "larger than" in one_line(["check", "--config", path])


def test_links_in_a_circle_lead_nowhere(tmp_path: Path) -> None:
    circle = tmp_path / "circle"
    circle.symlink_to(circle)
    for line in (
        ["check", "--robot", "rx90", str(circle)],
        ["identify", "--robot", "rx90", "--data", "x.csv", "--json", str(circle / "a.json")],
        ["identify", "--robot", "rx90", "--data", "x.csv", "--plots", str(circle)],
        ["fleet", "report", str(circle)],
    ):
        assert "circle" in one_line(line)


def test_a_folder_may_be_called_as_a_shipped_robot(tmp_path: Path) -> None:
    with contextlib.chdir(tmp_path):
        line = ["simulate", "--robot", "rx90", "--trajectory", "gone.csv", "--out", "rx90"]
        assert "gone.csv: no such file" in one_line(line)


@pytest.mark.parametrize("name", dict.fromkeys(name for name, _ in OUTPUT_FILES))
def test_a_folder_is_no_file_to_write(name: str, tmp_path: Path) -> None:
    with contextlib.chdir(tmp_path):
        for command, option in OUTPUT_FILES:
            if command == name:
                for path in (".", "..", "/", ""):
                    line = one_line([*without(words(name), option), f"{option}={path}"])
                    assert f"{option} {path!r}: not a file" in line


@pytest.mark.parametrize("name", dict.fromkeys(name for name, _ in OUTPUT_FILES))
def test_a_file_and_a_folder_to_write_are_two(name: str, tmp_path: Path) -> None:
    with contextlib.chdir(tmp_path):
        folders = [option for command, option, kind in OUTPUTS if (command, kind) == (name, "folder")]
        for folder in folders:
            for command, option in OUTPUT_FILES:
                if command == name:
                    line = without(without(words(name), option), folder)
                    assert "names this file too" in one_line([*line, f"{option}=new", f"{folder}=./new"])


def test_beside_a_device_no_options_are_written(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    _, call = parsed(["check", "a.csv"])
    assert call.settings_file(str(tmp_path / "a.html")) == tmp_path / "a.run.toml"
    assert call.settings_file(str(pipe)) is None


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
