"""``dynident`` run by the tests: exit status, what was printed, and what was written."""

import contextlib
import io
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.cli import main
from dynident.model import Recording
from dynident.tests.frozen.freeze import settings

Run = Callable[..., tuple[int, str, str]]
"""Arguments -> exit status, output and errors."""
QUICK = ("--columns", "payload", "--via-points", "4", "--starts", "1", "--seed", "2")
"""A design problem of a second."""


_WITH_DETAILS = {"payload", "weigh", "identify", "gains", "check", "design", "near", "score", "demo"}
"""Commands whose screen has a second part."""


def runner(capsys: pytest.CaptureFixture[str], *before: str) -> Run:
    """Runs the command and has it print everything; ``before`` stand before its arguments."""

    def run(*arguments: str, details: bool = True) -> tuple[int, str, str]:
        words = [*before, *arguments]
        more = ["--details"] if details and words[0] in _WITH_DETAILS else []
        try:
            status = main([*words, *more])
        except SystemExit as stop:
            status = int(stop.code or 0)
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return run


def document(path: Path) -> dict[str, Any]:
    """What ``--json`` wrote."""
    content: dict[str, Any] = json.loads(path.read_text())
    return content


def by_estimator(data: dict[str, Any]) -> tuple[list[Any], list[Any]]:
    """Free and constrained estimates."""
    free, constrained = (
        [estimate for estimate in data["estimates"] if estimate["estimator"] == name]
        for name in ("wls", "constrained")
    )
    return free, constrained


def write_csv(path: Path, recording: Recording, torque: str = "tau", q_scale: float = 1.0) -> Path:
    n = recording.q.shape[1]
    header = ["t"] + [f"{kind}{j}" for kind in ("q", torque) for j in range(1, n + 1)]
    values = np.column_stack([recording.t, q_scale * recording.q, recording.torque])
    np.savetxt(path, values, delimiter=",", header="# gain_sigma = 0\n" + ",".join(header), comments="", fmt="%.9g")
    return path


def payload_arguments(logs: dict[str, str], *more: str) -> list[str]:
    arguments = ["payload", "--robot", "rx90"]
    for k in (0, 1):
        arguments += ["--unloaded", logs[f"bare{k}"], "--loaded", logs[f"loaded{k}"]]
    return [*arguments, *more]


def identify_arguments(logs: dict[str, str], *more: str) -> list[str]:
    return ["identify", "--robot", "rx90", "--data", logs["bare0"], "--data", logs["bare1"], *more]


def unread(line: list[str]) -> int:
    """Status of a command whose output goes to a pipe that nobody reads any more."""
    read, write = os.pipe()
    os.close(read)
    with (
        os.fdopen(write, "w") as gone,
        contextlib.redirect_stdout(gone),
        contextlib.redirect_stderr(io.StringIO()),
        settings(),
    ):
        return main(line)
