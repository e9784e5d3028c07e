"""Every option of every command changes something or is refused, and takes no word that nobody means."""

import contextlib
import re
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from cyclopts import Token
from dynident.apps.report.blocks import Drawing
from dynident.apps.report.figures.canvas import new_figure
from dynident.tests.commands.lines import LINES
from dynident.tests.commands.options import OPTIONS
from dynident.tests.commands.typed import NAMES, arguments, options, refused, typed

RUNS = ("simulate", "demo")
"""Commands of thousands of steps; others evaluate many models a few times: to compile each would take longer."""
TEXTS_ASKED_FOR = ("export", "robot show")
"""Commands whose printed text is the answer itself, which ``--quiet`` leaves as it is."""
VARYING = re.compile(rb'"cpu_s": [0-9.e-]+')
"""What differs from one run to the next."""


def outcome(inputs: Path, line: str) -> dict[str, bytes]:
    """What a line prints and writes, in a folder of its own that holds all inputs."""
    with tempfile.TemporaryDirectory() as name, contextlib.chdir(name):
        shutil.copytree(inputs, name, dirs_exist_ok=True)
        ended = typed(line)
        files = {str(path.relative_to(name)): path.read_bytes() for path in Path(name).rglob("*") if path.is_file()}
    return {name: VARYING.sub(b"", content) for name, content in (files | {"": repr(ended).encode()}).items()}


def test_no_option_is_without_an_entry() -> None:
    assert {name: sorted(options(name)) for name in NAMES} == {
        name: sorted(entries) for name, entries in OPTIONS.items()
    }
    assert all({"--quiet", "verbose", "--config"} <= entries.keys() for entries in OPTIONS.values() if entries)


def test_a_setting_is_refused_where_it_is_typed() -> None:
    for command in NAMES:
        for key in (name for name in options(command) if not name.startswith("--")):
            assert f"{key} is a setting, not an option" in refused(command, f"--{key}=1")


def test_payload_shows_no_more_than_thirty() -> None:
    shown = [argument.name for argument in arguments("payload") if argument.show]
    assert len(shown) <= 30, shown


def differing(folder: Path, name: str, entry: str, bases: dict[str, dict[str, bytes]]) -> bool:
    """Whether a line with an option gives anything else than the line without it."""
    needs, _, more = entry.rpartition("|")
    line = needs.strip().removeprefix("=") if needs.startswith("=") else f"{LINES[name]} {needs}"
    if line not in bases:
        bases[line] = outcome(folder, f"{name} {line}")
    return outcome(folder, f"{name} {line} {more}") != bases[line]


@pytest.mark.long
@pytest.mark.usefixtures("hasty")
@pytest.mark.parametrize("name", OPTIONS)
def test_every_option_changes_something_or_is_refused(
    name: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Figures are empty: each shows what stands in numbers beside it, and half of the time went into them."""
    monkeypatch.setattr(Drawing, "figure", property(lambda _: new_figure(1.0, 1.0)))
    if name not in RUNS:
        monkeypatch.setenv("DYNIDENT_NO_COMPILER", "1")
    line = f"{name} {LINES[name]}"
    bases = {LINES[name]: outcome(folder, line)}
    assert outcome(folder, line) == bases[LINES[name]], "a line gives the same twice"
    ignored = [option for option, entry in OPTIONS[name].items() if not differing(folder, name, entry, bases)]
    assert ignored == (["--quiet"] if name in TEXTS_ASKED_FOR else [])


ODD_NUMBERS = ("nan", "inf", "-inf", "1e308", "-1e308", "1e300", "5e-324", "1e-300", "9" * 5000)
SPEAKS_TO_TERMINALS = "\x1b[31m\x9b2J\u202e\udcff"
"""Colours, clears the screen, turns the direction of writing, and a byte that is no letter."""


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


@pytest.mark.parametrize("command", NAMES)
def test_a_wrong_word_is_shown_in_one_line(command: str) -> None:
    for odd in (SPEAKS_TO_TERMINALS, "x\ny", "9" * 5000):
        for option in ("--config", "--quiet"):
            line = refused(command, f"{option}={odd}")
            assert line.isprintable()
            assert len(line) < 1200
