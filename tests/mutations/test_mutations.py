"""Inputs with one mistake each: an answer or one line, no half file, no mass wrong in silence."""

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
from dynident.common.errors import InputError
from dynident.model import load_robot, read_payload
from dynident.tests.commands.typed import options
from dynident.tests.frozen.filed import filed
from dynident.tests.frozen.inputs import folder_of_inputs
from dynident.tests.mutations.mutants import BYTES, MASSES, TEXTS, Mutant, mutant
from dynident.tests.trajectories.test_scene_file import WHOLE
from dynident.trajectories import plan_point_to_point, read_scene
from dynident.trajectories.motions.via_points import random_points

COUNT, SEED = 150, 0
UNKNOWABLE = {
    "^all recordings: all gains off": "torques that are all larger by one share are those of a heavier arm with "
    "a heavier payload; 8 % are within what the arm's own weight tells",
}
"""Mistakes by which a mass may be wrong in silence, and why nothing in the data can tell."""
ROOT = Path(__file__).parents[2]
FILES: dict[str, tuple[bytes, Callable[[Path], object]]] = {
    "six_axis.toml": ((ROOT / "examples/robots/six_axis.toml").read_bytes(), load_robot),
    "tx40.toml": ((ROOT / "model/robots/tx40.toml").read_bytes(), load_robot),
    "six_axis.urdf": ((ROOT / "examples/robots/six_axis.urdf").read_bytes(), load_robot),
    "gripper.toml": ((ROOT / "examples/gripper.toml").read_bytes(), read_payload),
    "scene.toml": (WHOLE.encode(), read_scene),
}


LONGEST = 30.0, 300.0
"""s of the processor and of the clock: a command on a recording of 5 s that has not answered then hangs."""
SLOW = {"--bound", "--report", "plots"}
"""Options that start a search or draw figures."""


class Trial(NamedTuple):
    """What a command did: the mistake, exit status, what is wrong with that (empty if nothing)."""

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
        return Trial(mistake, status, problem or _mass(status, mistake))


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


def _mass(status: int, mistake: Mutant) -> str:
    """A mass that is far off, beyond its interval by half (an interval of 95 % may miss), and said to be of use."""
    if status != 0 or mistake.words[0] not in ("payload", "weigh") or not Path("out.json").exists():
        return ""
    document = json.loads(Path("out.json").read_bytes())
    best = document["recommended"]
    estimate = next(
        x for x in document["estimates"] if (x["method"], x["estimator"]) == (best["method"], best["estimator"])
    )
    mass, (low, high) = estimate["parameters"]["M"], estimate["interval95"]["M"]
    true = next((MASSES[word] for word in mistake.words if word in MASSES), None)
    if (
        true is None
        or mass is None
        or abs(mass - true) <= max(0.03 * true, 1.5 * (mass - low), 1.5 * (high - mass))
    ):
        return ""
    return f"silent: {mass:.3f} kg ({low:.3f} to {high:.3f}), in truth {true:g}"


@pytest.mark.long
def test_what_is_mistaken_is_told() -> None:
    wrong, statuses = [], set[int]()
    for trial in trials(COUNT, SEED):
        statuses.add(trial.status)
        if trial.problem and not known(trial):
            wrong.append(f"{trial.mutant.kind}: {trial.problem}: {' '.join(trial.mutant.words)[:200]}")
    assert not wrong, "\n".join(wrong)
    assert statuses == {0, 1, 2}


def known(trial: Trial) -> bool:
    """Whether it is a wrong mass of a kind that cannot be known."""
    return trial.problem.startswith("silent") and any(re.search(kind, trial.mutant.kind) for kind in UNKNOWABLE)


def numbers(content: bytes, draw: np.random.Generator) -> bytes:
    """One number of a file becomes another."""
    places = list(re.finditer(rb"-?\d+\.?\d*", content))
    place = places[int(draw.integers(len(places)))]
    odd = (b"0", b"-1", b"1e9", b"1e300", b"nan", b"inf", b"x", b"", b"1e-300", b"1e400", b"-5")
    return content[: place.start()] + odd[int(draw.integers(len(odd)))] + content[place.end() :]


@pytest.mark.parametrize("name", FILES)
def test_a_file_with_a_mistake_is_read_or_refused_in_a_line(name: str, tmp_path: Path) -> None:
    good, read = FILES[name]
    changes = [*BYTES.values(), *(() if name.endswith(".urdf") else TEXTS.values()), numbers, numbers]
    lines = []
    for k in range(80):
        draw = np.random.default_rng([SEED, k])
        (tmp_path / name).write_bytes(changes[k % len(changes)](good, draw))
        try:
            read(tmp_path / name)
        except InputError as error:
            lines.append(str(error))
    assert len(lines) > 40
    assert all("\n" not in line and len(line) < 1000 for line in lines)
