"""``dynident check``: what a log holds, and what looks wrong with it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from ... import estimation, model
from ...common.errors import InputError
from .. import logs, report
from ..logs.log_check import check_log, robot_fits
from . import ANSWERED, DO_NOT_USE
from .options import PageOptions, ProcessingOptions, RobotOptions, Setup, add_command, option


@dataclass(frozen=True)
class _Logs(PageOptions):
    """The logs, and the result as JSON, as a report and as figures of their signals."""

    logs: tuple[str, ...] = option(
        "logs", reads="logs", nargs="*", metavar="LOG", help="recordings, with or without payload"
    )
    data: tuple[str, ...] = option(
        reads="logs", action="append", default=[], metavar="LOG", help="recording, as a word alone; repeatable"
    )

    @property
    def paths(self) -> tuple[str, ...]:
        """All logs.

        Raises:
            InputError: without any.
        """
        if not (self.logs or self.data):
            raise InputError("give a log: dynident check LOG")
        return (*self.logs, *self.data)


@dataclass(frozen=True)
class _Robot(RobotOptions):
    """The robot, which may be left out."""

    robot: str = option(
        reads="robot",
        default="",
        metavar="NAME|FILE",
        help="a shipped robot, TOML or URDF (default: told which shipped robots fit)",
    )


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    add_command(
        commands,
        "check",
        run,
        description="Look at logs: what was understood, what looks wrong, and how surely they show each base "
        "parameter. Whether order, senses and zeros of the joints are the robot's, and whether forward kinematics "
        "reproduces a logged tool pose, is for 'dynident robot check'.",
    )


def run(robot: _Robot, processing: ProcessingOptions, files: _Logs) -> int:
    """Run it."""
    if not robot.robot:
        for name in ("mount", "chain"):
            robot.refuse(name, "belongs to --robot: give it as well")
    setup = processing.setup(robot.load()) if robot.robot else None
    looks = [_looked(path, setup, processing, files) for path in files.paths]
    files.write_json(lambda: report.documents.check_document(setup.robot if setup else None, looks))
    words = setup.in_words() if setup else {}
    files.write_page(lambda: report.check_page(looks, files.provenance(words, files, robot, processing)))
    return ANSWERED if all(look.check and look.check.usable for look in looks) else DO_NOT_USE


def _looked(path: str, setup: Setup | None, processing: ProcessingOptions, files: _Logs) -> report.documents.Look:
    """Look at one log, its longest piece between gaps, by the robot that fits it best where none is named."""
    fits = None
    if setup is None:
        fits = robot_fits(path, processing.how())
        files.show(report.fits_screen(fits))
        if fits.fault:
            return report.documents.Look(path, None, fits)
        setup = processing.setup(model.load_robot(fits.fitting[0].robot))
    robot = setup.robot
    # Without gains its torques stay currents.
    currents = setup.gains is None and logs.holds_currents_only(path, robot, setup.log_map)
    gains = (1.0,) * robot.n if currents else setup.gains
    pieces = replace(setup, gains=gains, told=set()).read([path])
    longest = max(pieces, key=lambda piece: float(piece.t[-1] - piece.t[0]))
    check = check_log(robot, longest, setup.processing, currents)
    if len(pieces) > 1:
        text = f"Rows are missing: of {len(pieces)} pieces the longest is looked at; record without losing rows"
        check = check.with_findings(estimation.Finding("note", "recording", text))
    files.show(report.check_screen(check))
    return report.documents.Look(path, check, fits)
