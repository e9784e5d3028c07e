"""``dynident check``: what a log holds, and what looks wrong with it."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from .. import estimation, model, report
from ..common.errors import InputError
from . import COMMANDS
from .arguments import (
    ANSWERED,
    DO_NOT_USE,
    log_map,
    processing_arguments,
    read_recordings,
    robot_argument,
    settings,
)


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser(
        "check",
        help=COMMANDS["check"],
        description="Look at logs: what was understood, what looks wrong, and how surely they show each base "
        "parameter. Whether order, senses and zeros of the joints are the robot's, and whether forward kinematics "
        "reproduces a logged tool pose, is for 'dynident robot check'.",
    )
    parser.add_argument("logs", nargs="+", metavar="LOG", help="recordings, with or without payload")
    robot_argument(parser)
    parser.add_argument("--plots", metavar="DIR", help="draw the signals there, PNG and SVG")
    processing_arguments(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run it."""
    folder = Path(arguments.plots) if arguments.plots else None
    if folder and not folder.is_dir():
        raise InputError(f"--plots {arguments.plots!r}: no such folder; make it first")
    robot, processing = settings(arguments)
    checks: list[estimation.diagnosis.LogCheck] = []
    for path in arguments.logs:
        gains, currents = _gains(path, arguments, robot)
        (recording,) = read_recordings([path], robot, gains, set(), arguments)
        checks.append(estimation.diagnosis.check_log(robot, recording, processing, currents))
    for number, check in enumerate(checks, 1):
        report.print_blocks(report.check_screen(robot, check))
        if folder:
            _plot(folder, number, check)
    if arguments.json:
        report.documents.write_json(
            arguments.json,
            report.documents.check_document(robot, checks),
        )
    return ANSWERED if all(check.usable for check in checks) else DO_NOT_USE


def _gains(path: str, arguments: argparse.Namespace, robot: model.Robot) -> tuple[tuple[float, ...] | None, bool]:
    """Gains to read with, and whether the log's torques stay currents."""
    if arguments.drive_gains is None and estimation.recordings.holds_currents_only(path, robot, log_map(arguments)):
        return (1.0,) * robot.n, True
    return arguments.drive_gains, False


def _plot(folder: Any, number: int, check: estimation.diagnosis.LogCheck) -> None:
    stem = check.recording.source.replace("\\", "/").rstrip("/").rsplit("/", 1)[-1].split(".")[0]
    for ending in ("png", "svg"):
        report.save_signals(
            folder / f"{number:02d}_{stem}.{ending}", check.recording, "A" if check.currents else "N·m"
        )
