"""What several commands share: arguments of one kind, processing settings, reading recordings."""

from __future__ import annotations

import argparse
import math
import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from .. import estimation, model
from ..common.errors import InputError
from .values import fraction, gains_list, gains_or_file, mount, positive, texts, three, tool_frame

ANSWERED, DO_NOT_USE, BAD_INPUT, INTERRUPTED, BROKEN_PIPE = 0, 1, 2, 130, 141
"""Exit statuses of every command."""


def robot_argument(parser: argparse.ArgumentParser, weight: bool = True) -> None:
    """``--robot`` and how it is installed; ``weight``: whether gravity counts in what the command works out."""
    parser.add_argument(
        "--robot", required=True, metavar="NAME|FILE", help="a shipped robot ('dynident robot list'), TOML or URDF"
    )
    group = parser.add_argument_group("installation", "how the robot is mounted; which links of a URDF it has")
    group.add_argument("--base", metavar="LINK", help="URDF: first link of the chain (default: the root)")
    group.add_argument("--tip", metavar="LINK", help="URDF: the flange's link, where there are several ends")
    parser.set_defaults(mount=None, gravity=None)
    if not weight:
        return
    group.add_argument(
        "--mount",
        type=mount,
        metavar="HOW",
        help="floor, wall (x of the base points down), ceiling, or roll,pitch,yaw of the base in degrees",
    )
    group.add_argument(
        "--gravity", type=three, metavar="X,Y,Z", help="gravity in the base's frame [m/s^2], instead of --mount"
    )


def payload_frame_argument(parser: argparse.ArgumentParser) -> None:
    """``--tool-frame``, for commands that take or give a payload."""
    parser.add_argument(
        "--tool-frame",
        type=tool_frame,
        metavar="X,Y,Z,R,P,Y",
        help="frame of the payload in the flange: metres, then roll, pitch, yaw in degrees (default: the flange)",
    )


def chosen_robot(arguments: argparse.Namespace) -> model.Robot:
    """The robot of ``--robot`` as it is mounted, with the payload's frame that is asked for."""
    robot = model.load_robot(arguments.robot, arguments.base, arguments.tip)
    for note in robot.snapped:
        print(f"dynident: note: {arguments.robot}: {note}", file=sys.stderr)
    if arguments.mount is not None and arguments.gravity is not None:
        raise InputError("--mount and --gravity say the same: give one of them")
    if arguments.mount is not None:
        robot = model.mounted(robot, arguments.mount)
    if arguments.gravity is not None:
        robot = model.with_gravity(robot, arguments.gravity)
    tool = getattr(arguments, "tool_frame", None)
    if tool is not None:
        robot = model.with_tool(robot, tool, f"tool frame {_shown(tool)} in: {robot.payload_frame}")
    return robot


def rehearsed(robot: model.Robot) -> model.Robot:
    """The robot with a stand-in for what is not known of its links, where its description allows one."""
    return model.with_stand_in(robot) if model.stand_in.can_stand_in(robot) else robot


def _shown(pose: model.Pose) -> str:
    lengths = ", ".join(f"{value:g}" for value in pose.origin)
    return f"({lengths} m; rpy {', '.join(f'{math.degrees(angle) + 0.0:g}' for angle in pose.rpy)} deg)"


def log_arguments(parser: argparse.ArgumentParser) -> None:
    """How logs are to be read."""
    group = parser.add_argument_group("logs", "CSV, TSV, NPZ, MAT, Parquet, ROS 2 bags; see docs/logs.md")
    group.add_argument("--log-map", metavar="TOML", help="columns, units, side and signs of the logs")
    group.add_argument("--joints", type=texts, default=(), metavar="A,B,..", help="joints by name, base to tip")
    group.add_argument("--units", type=texts, default=(), metavar="q=deg,..", help="units of q, qd, tau, i, t")
    group.add_argument("--signs", type=gains_list, default=(), metavar="1,-1,..", help="turn the sense of joints")
    group.add_argument("--topic", default="", metavar="NAME", help="ROS 2 bag: which joint states")


def processing_arguments(parser: argparse.ArgumentParser, gains: bool = True, decimation: bool = True) -> None:
    """How logs are read, settings of filtering and of the model's structure, and ``--json``."""
    parser.set_defaults(decimate=None)
    log_arguments(parser)
    group = parser.add_argument_group("processing", "defaults stand in the robot's file")
    if gains:
        told = "torque per current [N·m/A], or the --json of 'dynident gains'"
        group.add_argument("--drive-gains", type=gains_or_file, metavar="K1,K2,..|JSON", help=told)
    group.add_argument("--rate", type=float, metavar="HZ", help="resample to this even rate")
    group.add_argument("--cutoff", type=float, metavar="HZ", help="low-pass on positions and speeds")
    if decimation:
        group.add_argument("--decimate", type=positive, metavar="N", help="parallel decimation of Y and W")
    group.add_argument("--offsets", action=argparse.BooleanOptionalAction, help="a constant torque per joint")
    group.add_argument("--coulomb", choices=("sum", "paper"), help="Coulomb friction of coupled drives")
    group.add_argument("--json", metavar="F", help="write the result as JSON")


def essential_arguments(parser: argparse.ArgumentParser) -> None:
    """When the elimination of parameters ends: one rule or the other."""
    either = parser.add_mutually_exclusive_group()
    either.add_argument(
        "--essential-ratio",
        type=float,
        metavar="RATIO",
        help="eliminate parameters until the error's standard deviation has grown by this (default: 1.02)",
    )
    either.add_argument(
        "--essential-sigma",
        type=fraction,
        metavar="PERCENT",
        help="or until all relative standard deviations are within this, such as 10%%",
    )


def essential_rule(arguments: argparse.Namespace) -> estimation.fit.StopRule | None:
    """The rule asked for; None for the default."""
    if arguments.essential_sigma is not None:
        return estimation.SigmaBound(arguments.essential_sigma)
    return estimation.SigmaRatio(arguments.essential_ratio) if arguments.essential_ratio is not None else None


def settings(
    arguments: argparse.Namespace, stored: estimation.files.StoredRobot | None = None
) -> tuple[model.Robot, model.Processing]:
    """The robot with the model structure and processing that the command line asks for."""
    robot = chosen_robot(arguments)
    read_gains(arguments, robot)
    if stored:
        robot = stored.applied_to(robot)
        stored.check_gains(arguments.drive_gains)
    given = {"rate": arguments.rate, "cutoff": arguments.cutoff, "decimate": arguments.decimate}
    given["max_mismatch"] = getattr(arguments, "max_mismatch", None)
    try:
        if arguments.offsets is not None:
            robot = robot.with_offsets(arguments.offsets)
        if arguments.coulomb is not None:
            robot = robot.with_coulomb(arguments.coulomb)
        if stored and robot.fingerprint != stored.fingerprint:
            raise InputError("--offsets and --coulomb must be those the stored parameters were identified with")
        changes: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
        return robot, replace(robot.processing, **changes)
    except ValueError as error:
        raise InputError(str(error)) from None


def read_gains(arguments: argparse.Namespace, robot: model.Robot) -> None:
    """Put the numbers of a file of gains in the place of its path; ``stored_gains`` holds how sure they are."""
    given = getattr(arguments, "drive_gains", None)
    arguments.stored_gains = None
    if isinstance(given, str):
        arguments.gains_file = given
        stored = estimation.files.read_stored_gains(given)
        stored.check(robot, given)
        arguments.drive_gains = tuple(float(value) for value in stored.values)
        arguments.stored_gains = stored


def log_map(arguments: argparse.Namespace) -> estimation.LogMap:
    """How the command line wants logs to be read."""
    given = (
        estimation.read_log_map(arguments.log_map)
        if arguments.log_map
        else estimation.LogMap(source="command line")
    )
    return estimation.recordings.with_flags(
        given, arguments.joints, arguments.units, arguments.signs, arguments.topic
    )


def check_target(option: str, path: str | None) -> None:
    """Refuse a file that cannot be written before any work is done."""
    if path is not None and (not path or Path(path).is_dir() or not Path(path).resolve().parent.is_dir()):
        raise InputError(f"--{option} {path!r}: not a file in a folder that exists")


def check_folder(option: str, path: str | None) -> None:
    """Refuse a folder that is none, or cannot be made, before any work is done."""
    if path is None:
        return
    nearest = Path(path).absolute()
    while not os.path.lexists(nearest):
        nearest = nearest.parent
    if not path or not nearest.is_dir():
        raise InputError(f"--{option} {path!r}: is not a folder")


def read_recordings(
    paths: Sequence[str],
    robot: model.Robot,
    gains: tuple[float, ...] | None,
    told: set[str],
    arguments: argparse.Namespace,
) -> list[model.Recording]:
    """Read recordings; what a file says about unused columns is told once."""
    how = log_map(arguments)
    recordings = [estimation.read_recording(path, robot, gains, how) for path in paths]
    for recording in recordings:
        for note in recording.notes:
            about = note.split(": ", 1)[1]
            if about not in told:
                told.add(about)
                print(f"dynident: note: {note}", file=sys.stderr)
    return recordings
