"""Inputs with one mistake each, drawn by a seed: an answer or one line, and no half file."""

import contextlib
import json
import os
import re
import signal
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from dynident.tests.commands.lines import LINES, inputs_of_all_lines
from dynident.tests.commands.typed import Ended, options, typed

Draw = np.random.Generator
COUNT, LONGEST = 120, 300
"""Mistakes that are drawn; s that a command on a recording of 5 s may take."""


SEARCHES = ("design", "near", "demo", "record", "apply", "robot list", "fleet report")
"""Commands that take longer, need a controller, or read no file of a recording."""
COMMANDS = tuple(f"{name} {line}" for name, line in LINES.items() if name not in SEARCHES)


class Mutant(NamedTuple):
    """One command with one mistake: its kind, what to type, and the files that differ from the good ones."""

    kind: str
    words: list[str]
    files: dict[str, bytes]


PIECES: tuple[bytes, ...] = (
    b"", b"text", b"0", b"-1", b"nan", b"-inf", b"1e308", b"1,2", b'"1', b";", b"\n", b"[/x]", b"true", b"[]",
    b"{}", b"[[1, 2], [3]]", b"9" * 5000, b"[" * 3000 + b"]" * 3000, b"1979-05-27", b'"\\u0000"', b"q2",
    b"\xff\xfe", bytes(10),
)  # fmt: skip
"""Put in the place of a word, a number, a comma or the end of a line."""


def _piece(content: bytes, draw: Draw) -> bytes:
    """One piece of a file becomes another one, is missing, or stands there twice."""
    places = list(re.finditer(rb"[^\s,=:]+|[,=:\n]", content))
    place = places[int(draw.integers(len(places)))]
    odd = (*PIECES, place[0] * 2)[int(draw.integers(len(PIECES) + 1))]
    return content[: place.start()] + odd + content[place.end() :]


def _line(content: bytes, draw: Draw) -> bytes:
    """One line is missing, or stands there twice: a header, a key, a row."""
    lines = content.split(b"\n")
    k = int(draw.integers(len(lines))) * int(draw.integers(2))
    return b"\n".join([*lines[:k], *lines[k : k + 1] * (2 * int(draw.integers(2))), *lines[k + 1 :]])


def _byte(content: bytes, draw: Draw) -> bytes:
    damaged = bytearray(content)
    damaged[int(draw.integers(len(damaged)))] ^= 1 << int(draw.integers(8))
    return bytes(damaged)


CHANGES: dict[str, Callable[[bytes, Draw], bytes]] = {
    "a piece": _piece,
    "a line": _line,
    "a byte flipped": _byte,
    "cut": lambda content, draw: content[: int(draw.integers(len(content)))],
    "empty": lambda content, draw: b"",
    "UTF-16": lambda content, draw: content.decode().encode("utf-16"),
    "semicolons": lambda content, draw: content.replace(b",", b";"),
    "twice": lambda content, draw: content + content,
}
LIKELY = ("a piece", "a piece", "a piece", "a line", *CHANGES)
VALUES = (
    "", "0", "-1", "1", "2", "7", "0.5", "nan", "inf", "-inf", "1e300", "-1e300", "1e-300", "999999999", "9" * 400,
    "x", "[/x]",
    "1,2,3", "1,2,3,4,5,6", "0,0,0,0,0,0", "nowhere.toml", "nowhere.csv", "out.json", ".", "none", "%s",
    "ä" * 50, "10%", "2,2", "[bold", "six_axis.toml", "tx_robot.json",
)  # fmt: skip
"""Words typed behind an option."""


SLOW = {"bound=true", "--report", "plots"}
"""Options that start a search or draw figures."""


def mutant(draw: Draw, inputs: Path) -> Mutant:
    """A command with a mistake in one of its files, one more option or another word."""
    words = COMMANDS[int(draw.integers(len(COMMANDS)))].split()
    files = [word for word in words if (inputs / word).is_file()]
    if files and draw.random() > 0.3:
        file, kind = (some[int(draw.integers(len(some)))] for some in (files, LIKELY))
        return Mutant(f"{file}: {kind}", words, {file: CHANGES[kind]((inputs / file).read_bytes(), draw)})
    value = VALUES[int(draw.integers(len(VALUES)))]
    if draw.random() < 0.2:
        k = int(draw.integers(1, len(words)))
        return Mutant("another word", [*words[:k], value, *words[k + 1 :]], {})
    command = " ".join(words[:2]) if words[0] in ("robot", "fleet") else words[0]
    known = [option for option in options(command) if option not in SLOW]
    option = known[int(draw.integers(len(known)))]
    more = option if draw.random() < 0.15 else f"{option}={value}"
    return Mutant(f"typed: {more[:60]}", [*words, more], {})


def tried(mistake: Mutant, inputs: Path) -> tuple[int, str]:
    """Status of one command in a folder of its own, and what is wrong with how it ends; empty if nothing is."""
    with tempfile.TemporaryDirectory() as name, contextlib.chdir(name):
        for path in inputs.iterdir():
            if path.is_file() and path.name not in mistake.files:
                os.link(path, path.name)
        for file, content in mistake.files.items():
            Path(file).write_bytes(content)
        before = {path.name: path.read_bytes() for path in Path().iterdir()}
        signal.alarm(LONGEST)
        ended = typed(mistake.words)
        signal.alarm(0)
        return ended.status, problem(ended, before, mistake.words)


def problem(ended: Ended, before: dict[str, bytes], words: list[str]) -> str:
    """One line where the input cannot be used and none else; inputs stay, and what is written is whole."""
    if ended.status not in (0, 1, 2) or len(ended.errors) != (ended.status == 2):
        return f"status {ended.status}: {ended.err[-300:]!r}"
    # What is named once may be the file to be written; what is named twice is read as well.
    named = {name: sum(word == name or word.endswith(f"={name}") for word in words) for name in before}
    for name, content in before.items():
        if named[name] != 1 and (not Path(name).exists() or Path(name).read_bytes() != content):
            return f"input {name} was changed"
    for path in (path for path in Path().rglob("*") if path.is_file() and path.name not in before):
        if ended.status == 2 or path.name.startswith(".") or path.suffix == ".part":
            return f"status {ended.status}, but {path} was written"
        if path.suffix == ".json" and f"--out={path.name}" not in words:
            json.loads(path.read_bytes())
    return ""


def hangs(*_: object) -> None:
    raise TimeoutError("the command has not answered")


@pytest.mark.long
def test_what_is_mistaken_is_told() -> None:
    before, wrong, statuses = signal.signal(signal.SIGALRM, hangs), [], set[int]()
    with inputs_of_all_lines() as folder:
        for path in folder.glob("*.json"):
            path.write_text(json.dumps(json.loads(path.read_bytes()), indent=1))
        for k in range(COUNT):
            mistake = mutant(np.random.default_rng([0, k]), folder)
            status, fault = tried(mistake, folder)
            statuses.add(status)
            if fault:
                wrong.append(f"{mistake.kind}: {fault}: {' '.join(mistake.words)[:200]}")
    signal.signal(signal.SIGALRM, before)
    assert not wrong, "\n".join(wrong)
    assert statuses == {0, 1, 2}
