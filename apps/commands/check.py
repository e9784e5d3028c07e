"""``dynident check`` and ``verify``: what a log holds and what looks wrong, and two around a payload's entry."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, ClassVar

from cyclopts import Parameter

from ... import estimation, model
from ...common.errors import InputError
from .. import logs
from ..logs.log_check import check_log, following_change, longest, read_following, robot_fits
from ..report.documents import Look, check_document
from ..report.sections.check import check_report, fits_report, following_report, log_report
from .entry import command
from .options import ArmOptions, LogOptions, PageOptions, ProcessingOptions, RobotOptions, Setup
from .values import LOG, SEVERAL, DataFiles, Reads, RobotFile

_Logs = Annotated[DataFiles, Parameter(help="Recordings, with or without payload.")]


class _Robot(RobotOptions):
    """The robot, which may be left out."""

    needs: ClassVar = {"mount": ("robot",), "chain": ("robot",)}

    robot: RobotFile = ""
    """An included robot, TOML or URDF (default: lists the included robots that fit)."""


@command
def run(data: _Logs = (), *, robot: _Robot, processing: ProcessingOptions, files: PageOptions) -> bool:
    """Run ``check``."""
    if not data:
        raise InputError("give a log: dynident check LOG")
    setup = processing.setup(robot.load()) if robot.robot else None
    looks = [_looked(path, setup, processing, files) for path in logs.grouped(data)]
    files.write_json(lambda: check_document(setup.robot if setup else None, looks))
    files.write_page(check_report(looks), setup.in_words() if setup else {})
    return all(check and check.usable for check, _ in looks)


def _looked(
    path: str | tuple[str, ...], setup: Setup | None, processing: ProcessingOptions, files: PageOptions
) -> Look:
    """Look at one log, its longest piece between gaps, by the robot that fits it best where none is named."""
    fits = None
    if setup is None:
        fits = robot_fits(path, processing.how())
        files.show(fits_report(fits))
        if fits.fault:
            return None, fits
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
    files.show(log_report(check))
    return check, fits


@command
def run_verify(
    *,
    arm: ArmOptions,
    before: Annotated[tuple[Annotated[str, Reads("before"), LOG], ...], SEVERAL],
    after: Annotated[tuple[Annotated[str, Reads("after"), LOG], ...], SEVERAL],
    reading: LogOptions,
    files: PageOptions,
) -> bool:
    """Run ``verify``.

    Args:
        before: Before the new number: one motion (or its files of one signal each), with columns qref1..
            (commanded positions) or tauref1.. (torque predicted, N·m), or what --log-map names.
        after: That motion again, with the new number.
    """
    robot, how = arm.load(), reading.how()
    gains, _ = reading.gains(robot)
    given = [logs.grouped(paths) for paths in (before, after)]
    for several in given:
        if several[1:]:
            raise InputError(f"{', '.join(map(str, several))}: give one recording, or its files, one a signal")
    old, new = (read_following(own[0], robot, gains, how) for own in given)
    change = following_change(old, new, robot.processing.still_speed)
    files.give(following_report(change, robot), lambda: change, {})
    return not (change.tells and change.total.clear == "rose")
