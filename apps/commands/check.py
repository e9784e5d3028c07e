"""``dynident check``: what a log holds, and what looks wrong with it."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, ClassVar

from cyclopts import Parameter

from ... import estimation, model
from ...common.errors import InputError
from .. import logs, report
from ..logs.log_check import check_log, longest, robot_fits
from . import ANSWERED, DO_NOT_USE
from .entry import command
from .options import PageOptions, ProcessingOptions, RobotOptions, Setup
from .values import DataFiles, RobotFile

_Logs = Annotated[DataFiles, Parameter(help="Recordings, with or without payload.")]


class _Robot(RobotOptions):
    """The robot, which may be left out."""

    needs: ClassVar = {"mount": ("robot",), "chain": ("robot",)}

    robot: RobotFile = ""
    """A shipped robot, TOML or URDF (default: told which shipped robots fit)."""


@command
def run(data: _Logs = (), *, robot: _Robot, processing: ProcessingOptions, files: PageOptions) -> int:
    """Run it."""
    if not data:
        raise InputError("give a log: dynident check LOG")
    setup = processing.setup(robot.load()) if robot.robot else None
    looks = [_looked(path, setup, processing, files) for path in logs.grouped(data)]
    files.write_json(lambda: report.documents.check_document(setup.robot if setup else None, looks))
    files.write_page(report.check_report(looks), setup.in_words() if setup else {})
    return ANSWERED if all(look.check and look.check.usable for look in looks) else DO_NOT_USE


def _looked(
    path: str | tuple[str, ...], setup: Setup | None, processing: ProcessingOptions, files: PageOptions
) -> report.documents.Look:
    """Look at one log, its longest piece between gaps, by the robot that fits it best where none is named."""
    fits = None
    if setup is None:
        fits = robot_fits(path, processing.how())
        files.show(report.fits_report(fits))
        if fits.fault:
            return report.documents.Look(fits.source, None, fits)
        setup = processing.setup(model.load_robot(fits.fitting[0].robot))
    robot = setup.robot
    # Without gains its torques stay currents.
    currents = setup.gains is None and logs.named(path, robot, setup.log_map).holds_currents_only
    gains = (1.0,) * robot.n if currents else setup.gains
    pieces = replace(setup, gains=gains, told=set()).read([path])
    check = check_log(robot, longest(pieces), setup.processing, currents)
    if len(pieces) > 1:
        text = f"Rows are missing: of {len(pieces)} pieces the longest is looked at; record without losing rows"
        check = check.completed([estimation.Finding("note", "recording", text)])
    files.show(report.log_report(check))
    return report.documents.Look(check.source, check, fits)
