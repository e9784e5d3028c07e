"""Runs commands on inputs with a mistake: ``python -m dynident.tests.mutations.trial 3000`` tries thousands."""

import contextlib
import io
import json
import os
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import FrameType
from typing import NamedTuple

import numpy as np
from dynident.cli import main
from dynident.model import load_robot
from dynident.tests.commands.typed import options
from dynident.tests.frozen.inputs import folder_of_inputs
from dynident.tests.mutations.mutants import MASSES, Mutant, mutant
from dynident.trajectories import plan_point_to_point
from dynident.trajectories.motions.via_points import random_points

LONGEST = 30.0
"""s of the processor: a command on a recording of 5 s that has not answered then hangs."""
_SLEEPS = 10.0
"""So many times as long by the clock: it waits for something."""
SLOW = {"--bound", "--report", "--plots"}
"""Options that start a search or draw figures."""


class Trial(NamedTuple):
    """What a command did: the mistake, exit status, what is wrong with that (empty if nothing), processor time."""

    mutant: Mutant
    status: int
    problem: str
    seconds: float


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
        begun = time.process_time()
        timers = (
            (signal.ITIMER_PROF, signal.SIGPROF, LONGEST),
            (signal.ITIMER_REAL, signal.SIGALRM, _SLEEPS * LONGEST),
        )
        for timer, event, most in timers:
            signal.signal(event, _time_up)
            signal.setitimer(timer, most)
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(errors), warnings.catch_warnings():
            try:
                status = main(mistake.words)
            except SystemExit as stop:
                status = int(stop.code or 0)
            except _TimeUpError:
                problem = f"hangs: {traceback.format_exc().splitlines()[-3].strip()}"
            except Exception:
                problem = (
                    f"traceback: {' | '.join(line.strip() for line in traceback.format_exc().splitlines()[-3:])}"
                )
            finally:
                for timer, event, _ in timers:
                    signal.setitimer(timer, 0.0)
                    signal.signal(event, signal.SIG_DFL)
        seconds = time.process_time() - begun
        laws: tuple[Callable[[], str], ...] = (
            lambda: _told(status, errors.getvalue()),
            lambda: _files(status, before, mistake.words),
            lambda: _mass(status, mistake),
        )
        for law in laws:
            problem = problem or law()
    return Trial(mistake, status, problem, seconds)


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


if __name__ == "__main__":
    findings, slow = 0, dict[str, float]()
    for number, trial in enumerate(trials(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0)):
        command = f"{trial.mutant.words[0]} {trial.status}"
        slow[command] = slow.get(command, 0.0) + trial.seconds
        if trial.problem or trial.seconds > 0.5 * LONGEST:
            findings += 1
            print(f"{number}: {trial.mutant.kind} ({trial.seconds:.1f} s): {trial.problem}", flush=True)
            print(f"    {' '.join(trial.mutant.words)[:300]}", flush=True)
    print(f"{findings} of {sys.argv[1]};", ", ".join(f"{name} {seconds:.0f} s" for name, seconds in slow.items()))
