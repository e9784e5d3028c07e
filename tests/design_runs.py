"""``dynident design`` run by the tests: a problem of a second, and what was printed and written."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from dynident.cli import main

Run = Callable[..., tuple[int, str, str]]
"""Arguments -> exit status, output and errors."""
QUICK = ("--payload-only", "--via-points", "4", "--starts", "1", "--seed", "2")
"""A problem of a second."""


def runner(capsys: pytest.CaptureFixture[str]) -> Run:
    """Runs the command on the RX90."""

    def run(*arguments: str) -> tuple[int, str, str]:
        try:
            status = main(["design", "--robot", "rx90", *arguments])
        except SystemExit as stop:
            status = int(stop.code or 0)
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return run


def document(path: Path) -> dict[str, Any]:
    """What ``--json`` wrote."""
    found: dict[str, Any] = json.loads(path.read_text())
    return found
