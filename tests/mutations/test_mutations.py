"""Inputs with one mistake each, drawn by a seed: an answer or one line, and no half file."""

import contextlib
import io
import json
import os
import re
import signal
import tempfile
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import FrameType
from typing import NamedTuple

import numpy as np
import pytest
from dynident.cli import main
from dynident.model import load_robot
from dynident.tests.commands.typed import options
from dynident.tests.frozen.filed import filed
from dynident.tests.frozen.inputs import folder_of_inputs
from dynident.trajectories import plan_point_to_point
from dynident.trajectories.motions.via_points import random_points

Draw = np.random.Generator


COMMANDS = (
    "payload --robot tx40.toml --unloaded tx_arm_unloaded.csv --loaded tx_arm_loaded.csv --json out.json",
    "payload --robot six_axis.toml --unloaded six_arm_unloaded.csv --loaded six_arm_loaded.csv --json out.json",
    "payload --robot tx40 --robot-parameters tx_robot.json --loaded tx_arm_loaded.csv equation-rate=25 "
    "--json out.json",
    "weigh --robot ur10e.toml --unloaded ur_near_unloaded.csv --loaded ur_near_loaded.csv --json out.json",
    "identify --robot six_axis.toml --data six_arm_unloaded.csv --json out.json",
    "check --robot six_axis.toml six_arm_unloaded.csv --json out.json",
    "gains --robot ur10e.toml --unloaded ur_currents_unloaded.csv --loaded ur_currents_loaded.csv --mass 6.2 "
    "--json out.json",
    "export rx_payload.json --to ur --flange-frame 0 0 0.1 0 0 30 --out out.script",
    "robot show --robot six_axis.toml",
    "robot export --to urdf --robot six_axis.toml --out out.urdf",
    "codegen --robot six_axis.toml --function gravity --out code",
    "simulate --robot six_axis.toml --payload box.toml --trajectory six_short.csv --rate 50 --out sim",
    "score --robot tx40.toml tx_arm_loaded.csv --torque-limits none --json out.json",
    "verify --robot tx40.toml --before tx_arm_unloaded.csv --after tx_arm_loaded.csv --json out.json",
    "fleet reduce six_arm_unloaded.csv --robot six_axis.toml equation-rate=31.25 --store store --json out.json",
    "compare six_arm_unloaded.csv six_arm_loaded.csv --robot six_axis.toml --json out.json",
)


class Mutant(NamedTuple):
    """One command with one mistake: its kind, what to type, and the files that differ from the good ones."""

    kind: str
    words: tuple[str, ...]
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


def mutant(draw: Draw, content_of: Callable[[str], bytes], options: Callable[[str], list[str]]) -> Mutant:
    """A command with one mistake.

    Args:
        content_of: content of a good input by its name.
        options: names of the options of a command.
    """
    words = COMMANDS[int(draw.integers(len(COMMANDS)))].split()
    files = [word for word in words if re.fullmatch(r"\w+\.(csv|toml|json)", word) and not word.startswith("out")]
    if not files or draw.random() < 0.3:
        return _with_option(words, draw, options)
    file = files[int(draw.integers(len(files)))]
    kind = LIKELY[int(draw.integers(len(LIKELY)))]
    return Mutant(f"{file}: {kind}", tuple(words), {file: CHANGES[kind](content_of(file), draw)})


def _with_option(words: list[str], draw: Draw, options: Callable[[str], list[str]]) -> Mutant:
    """One more option, an option without its value, or another value."""
    known = options(" ".join(words[:2]) if words[0] in ("robot", "fleet") else words[0])
    option = known[int(draw.integers(len(known)))]
    value = VALUES[int(draw.integers(len(VALUES)))]
    more = [option] if draw.random() < 0.15 else [f"{option}={value}"]
    if draw.random() < 0.2:
        k = int(draw.integers(1, len(words)))
        words, more = [*words[:k], value, *words[k + 1 :]], []
    return Mutant(f"typed: {' '.join(more)[:60] or 'another word'}", (*words, *more), {})


COUNT, SEED = 150, 0


LONGEST = 30.0, 300.0
"""s of the processor and of the clock: a command on a recording of 5 s that has not answered then hangs."""
SLOW = {"bound=true", "--report", "plots"}
"""Options that start a search or draw figures."""


class Trial(NamedTuple):
    """Outcome of a command: the mistake, exit status, what is wrong with that (empty if nothing)."""

    mutant: Mutant
    status: int
    problem: str


class _TimeUpError(BaseException):
    """A command has not answered."""


def _time_up(number: int, frame: FrameType | None) -> None:
    raise _TimeUpError


def trials(count: int, seed: int) -> Iterator[Trial]:
    """Mistakes of all kinds, each drawn by its own seed."""
    with folder_of_inputs() as folder:
        robot = load_robot("six_axis.toml")
        motion = plan_point_to_point(robot, random_points(robot, 3, 0), 0.4).motion(50.0)
        header = ",".join(["t", *(f"q{j}" for j in range(1, 7))])
        table = np.column_stack([motion.t, motion.q])
        np.savetxt("six_short.csv", table, delimiter=",", header=header, comments="", fmt="%.9g")
        for path in folder.glob("*.json"):
            path.write_text(json.dumps(json.loads(path.read_bytes()), indent=1))
        inputs = {path.name: path.read_bytes() for path in folder.iterdir()}
        for k in range(count):
            yield tried(mutant(np.random.default_rng([seed, k]), inputs.__getitem__, _options), folder)


def _options(command: str) -> list[str]:
    return [option for option in options(command) if option not in SLOW]


def tried(mistake: Mutant, inputs: Path) -> Trial:
    """One command, in a folder of its own."""
    printed, errors, problem, status = io.StringIO(), io.StringIO(), "", -1
    with tempfile.TemporaryDirectory() as name, contextlib.chdir(name):
        for path in inputs.iterdir():
            if path.name not in mistake.files:
                os.link(path, path.name)
        for file, content in mistake.files.items():
            Path(file).write_bytes(content)
        before = {path.name: path.read_bytes() for path in Path().iterdir()}
        timers = (signal.ITIMER_PROF, signal.SIGPROF), (signal.ITIMER_REAL, signal.SIGALRM)
        for (timer, event), most in zip(timers, LONGEST, strict=True):
            signal.signal(event, _time_up)
            signal.setitimer(timer, most)
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(errors), warnings.catch_warnings():
            try:
                status = main(filed(mistake.words))
            except SystemExit as stop:
                status = int(stop.code or 0)
            except _TimeUpError:
                problem = f"hangs: {traceback.format_exc().splitlines()[-3].strip()}"
            except Exception:
                problem = f"traceback: {traceback.format_exc()[-300:]}"
            finally:
                for timer, event in timers:
                    signal.setitimer(timer, 0.0)
                    signal.signal(event, signal.SIG_DFL)
        problem = problem or _told(status, errors.getvalue()) or _files(status, before, mistake.words)
        return Trial(mistake, status, problem)


def _told(status: int, errors: str) -> str:
    """An input that cannot be used is one line; nothing else ends a command."""
    if status not in (0, 1, 2):
        return f"exit status {status}: {errors.strip()[-200:]}"
    lines = [line for line in errors.splitlines() if not line.startswith("dynident: note:")]
    if "Traceback" in errors or len(lines) != (status == 2):
        return f"status {status} with {len(lines)} lines of errors: {errors.strip()[-300:]!r}"
    return ""


def _files(status: int, before: dict[str, bytes], words: Sequence[str]) -> str:
    """Inputs stay as they are; what is written is whole, and nothing is where the input could not be used."""
    now = {name: Path(name).read_bytes() if Path(name).exists() else b"" for name in before}
    # What is named once may be the file to be written; what is named twice is read as well.
    named = {name: sum(word == name or word.endswith(f"={name}") for word in words) for name in before}
    changed = [name for name, content in before.items() if now[name] != content and named[name] != 1]
    if changed:
        return f"an input was changed: {', '.join(changed)}"
    new = [path for path in Path().rglob("*") if path.is_file() and path.name not in before]
    if status == 2 and new:
        return f"status 2, but {new[0]} was written"
    for path in new:
        if path.name.startswith(".") or path.suffix == ".part":
            return f"half a file: {path}"
        if path.suffix == ".json" and f"--out={path.name}" not in words:
            try:
                json.loads(path.read_bytes())
            except ValueError as error:
                return f"{path} is no JSON: {error}"
    return ""


@pytest.mark.long
def test_what_is_mistaken_is_told() -> None:
    wrong, statuses = [], set[int]()
    for trial in trials(COUNT, SEED):
        statuses.add(trial.status)
        if trial.problem:
            wrong.append(f"{trial.mutant.kind}: {trial.problem}: {' '.join(trial.mutant.words)[:200]}")
    assert not wrong, "\n".join(wrong)
    assert statuses == {0, 1, 2}
