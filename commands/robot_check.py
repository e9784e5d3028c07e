"""``dynident robot check``: does a recording agree with the robot's kinematics? By tool poses, and by torques."""

from __future__ import annotations

import argparse
from typing import Any

from rich.console import Console

from .. import estimation, model, report
from .arguments import (
    ANSWERED,
    DO_NOT_USE,
    log_map,
    processing_arguments,
    read_recordings,
    robot_argument,
    settings,
)
from .robot_poses import checked_poses, pose_lines

_SHOWN = 6
_DESCRIPTION = """
Where a log carries the pose of the tool (columns x, y, z and qx, qy, qz, qw, or [pose] of the log map), forward
kinematics must reproduce it: the residual is told with the constant base and tool that fit best. Where it carries
torques or currents, recorded without payload, other orders, senses and zeros of the joints are ranked by what the
robot's model leaves unexplained. The best one is suggested, never applied. Exit status 1 if the pose is not
reproduced within 5 mm and 1 degree, or if another reading does clearly better.
"""


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser(
        "check",
        help="check order, senses and zeros of the joints by a recording: its tool poses, its torques",
        description=_DESCRIPTION,
    )
    robot_argument(parser)
    parser.add_argument("--data", action="append", required=True, metavar="LOG", help="recording without payload")
    processing_arguments(parser, decimation=False)  # its samples are thin by themselves
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run it."""
    robot, processing = settings(arguments)
    with Console(stderr=True).status("reading") as status:
        poses = checked_poses(arguments, robot, status.update)
        recordings = _recordings(arguments, robot, bool(poses))
        check = (
            estimation.diagnosis.rank_readings(robot, recordings, processing, status.update) if recordings else None
        )
    text = [line for log in poses for line in (*pose_lines(log), *(lines(log.readings) if log.readings else ()))]
    text += lines(check) if check else ["No torques or currents: the pose alone is compared."]
    print(*text, sep="\n")
    if arguments.json:
        logs = [report.documents.pose_document(*log) for log in poses]
        report.documents.write_json(arguments.json, report.documents.robot_check_document(robot, logs, check))
    faithful = all(log.check.reproduced for log in poses) and not (check and check.suggested)
    return ANSWERED if faithful else DO_NOT_USE


def _recordings(arguments: argparse.Namespace, robot: model.Robot, poses: bool) -> list[model.Recording]:
    """The recordings; of logs with poses those that carry torques too."""
    how = log_map(arguments)
    paths = [path for path in arguments.data if not poses or estimation.recordings.holds_torques(path, robot, how)]
    return read_recordings(paths, robot, arguments.drive_gains, set(), arguments)


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
