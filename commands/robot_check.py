"""``dynident robot check``: does a recording agree with the robot's kinematics? By tool poses, and by torques."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from .. import estimation, report
from . import ANSWERED, DO_NOT_USE
from .options import FilterOptions, ResultOptions, RobotOptions, Setup, add_command, option
from .progress import status
from .robot_poses import checked_poses, pose_lines

_SHOWN = 6
_DESCRIPTION = """
Where a log carries the pose of the tool (columns x, y, z and qx, qy, qz, qw, or [pose] of the log map), forward
kinematics must reproduce it: the residual is told with the constant base and tool that fit best. Where it carries
torques or currents, recorded without payload, other orders, senses and zeros of the joints are ranked by what the
robot's model leaves unexplained. The best one is suggested, never applied. Exit status 1 if the pose is not
reproduced within 5 mm and 1 degree, or if another reading does clearly better.
"""


@dataclass(frozen=True)
class _Data(ResultOptions):
    """The recordings, and the result as JSON; all of it is on the screen."""

    WITHOUT: ClassVar[frozenset[str]] = frozenset({"details"})

    data: tuple[str, ...] = option(
        reads="without payload", action="append", required=True, metavar="LOG", help="recording without payload"
    )


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    add_command(
        commands,
        "check",
        run,
        RobotOptions,
        FilterOptions,
        _Data,
        help="check order, senses and zeros of the joints by a recording: its tool poses, its torques",
        description=_DESCRIPTION,
    )


def run(arm: RobotOptions, processing: FilterOptions, files: _Data) -> int:
    """Run it."""
    setup = processing.setup(arm.load())
    robot = setup.robot
    with status("reading") as progress:
        poses = checked_poses(files.data, setup, progress)
        recordings = setup.read(_with_torques(files.data, setup) if poses else files.data)
        check = None
        if recordings:
            check = estimation.diagnosis.rank_readings(robot, recordings, setup.processing, progress)
    text = [line for log in poses for line in (*pose_lines(log), *(lines(log.readings) if log.readings else ()))]
    text += lines(check) if check else ["No torques or currents: the pose alone is compared."]
    files.show(report.Screen([report.Remarks(text)]))
    files.write_json(
        lambda: report.documents.robot_check_document(
            robot, [report.documents.pose_document(*log) for log in poses], check
        )
    )
    faithful = all(log.check.reproduced for log in poses) and not (check and check.suggested)
    return ANSWERED if faithful else DO_NOT_USE


def _with_torques(paths: tuple[str, ...], setup: Setup) -> list[str]:
    """Logs that carry torques beside their poses."""
    return [path for path in paths if estimation.recordings.holds_torques(path, setup.robot, setup.log_map)]


def lines(check: estimation.diagnosis.KinematicsCheck) -> list[str]:
    """The answer in words; a suggestion is never applied."""
    told = [f"As recorded: {check.as_recorded.residual:.4g} ({check.unit}); {len(check.ranked)} readings tried."]
    best = check.suggested
    if best is None:
        told.append("No other reading of order, senses and zeros does clearly better.")
    else:
        told.append(f"Suggested, not applied: {best.reading.told()}: {best.residual:.4g}.")
        told.append("Check it at the robot, then change the recording's columns or the robot's file.")
    others = [one for one in check.alike if one.reading.changes][:_SHOWN]
    if others:
        told.append("These do as well, so the recording cannot tell them apart:")
        told += [f"  {one.residual:.4g}  {one.reading.told()}" for one in others]
    return told
