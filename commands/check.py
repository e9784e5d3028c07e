"""``dynident check``: what a log holds, and what looks wrong with it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from .. import estimation, report
from ..common.errors import InputError
from ..common.files import made_folder
from . import ANSWERED, DO_NOT_USE
from .options import ProcessingOptions, ResultOptions, RobotOptions, Setup, add_command, option


@dataclass(frozen=True)
class _Logs(ResultOptions):
    """The logs, and where their signals are drawn."""

    logs: tuple[str, ...] = option(
        "logs", reads="logs", nargs="*", metavar="LOG", help="recordings, with or without payload"
    )
    data: tuple[str, ...] = option(
        reads="logs", action="append", default=[], metavar="LOG", help="recording, as a word alone; repeatable"
    )
    plots: str | None = option(
        writes="folder", metavar="DIR", help="draw the signals there, PNG and SVG; made if missing"
    )

    @property
    def paths(self) -> tuple[str, ...]:
        """All logs.

        Raises:
            InputError: without any.
        """
        if not (self.logs or self.data):
            raise InputError("give a log: dynident check LOG --robot NAME")
        return (*self.logs, *self.data)


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    add_command(
        commands,
        "check",
        run,
        RobotOptions,
        ProcessingOptions,
        _Logs,
        description="Look at logs: what was understood, what looks wrong, and how surely they show each base "
        "parameter. Whether order, senses and zeros of the joints are the robot's, and whether forward kinematics "
        "reproduces a logged tool pose, is for 'dynident robot check'.",
    )


def run(robot: RobotOptions, processing: ProcessingOptions, files: _Logs) -> int:
    """Run it."""
    setup = processing.setup(robot.load())
    checks = [_checked(path, setup) for path in files.paths]
    for number, check in enumerate(checks, 1):
        files.show(report.check_screen(setup.robot, check))
        if files.plots:
            _plot(Path(files.plots), number, check)
    files.write_json(lambda: report.documents.check_document(setup.robot, checks))
    return ANSWERED if all(check.usable for check in checks) else DO_NOT_USE


def _checked(path: str, setup: Setup) -> estimation.diagnosis.LogCheck:
    """One log; without gains its torques stay currents."""
    robot = setup.robot
    currents = setup.gains is None and estimation.recordings.holds_currents_only(path, robot, setup.log_map)
    gains = (1.0,) * robot.n if currents else setup.gains
    (recording,) = replace(setup, gains=gains, told=set()).read([path])
    return estimation.diagnosis.check_log(robot, recording, setup.processing, currents)


def _plot(folder: Path, number: int, check: estimation.diagnosis.LogCheck) -> None:
    made_folder(folder)
    stem = check.recording.source.replace("\\", "/").rstrip("/").rsplit("/", 1)[-1].split(".")[0]
    for ending in ("png", "svg"):
        report.save_signals(
            folder / f"{number:02d}_{stem}.{ending}", check.recording, "A" if check.currents else "N·m"
        )
