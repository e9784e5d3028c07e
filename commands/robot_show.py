"""``dynident robot show``: the modified DH table, limits and frames of a robot, and a drawing."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

from .. import report
from ..common.errors import InputError
from .arguments import ANSWERED, chosen_robot, payload_frame_argument, rehearsed, robot_argument
from .values import numbers


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser("show", help="table, limits and frames of a robot, and a drawing")
    robot_argument(parser)
    payload_frame_argument(parser)
    parser.add_argument("--at", type=numbers, metavar="Q1,Q2,..", help="positions to draw [deg or m] (default: 0)")
    parser.add_argument("--drawing", metavar="F", help="write a stick figure: .png, .svg or .pdf")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run it."""
    robot = chosen_robot(arguments)
    at = arguments.at or (0.0,) * robot.n
    if len(at) != robot.n:
        raise InputError(f"--at has {len(at)} numbers, {robot.name} has {robot.n} joints: give one per joint")
    report.print_blocks(report.robot_description(rehearsed(robot)))
    if arguments.drawing:
        draw(robot, arguments.drawing, at)
    return ANSWERED


def draw(robot: Any, path: str, at: tuple[float, ...]) -> None:
    """Write the drawing of a robot at positions in degrees and metres, and say so.

    Raises:
        InputError: for a format that is not known.
    """
    if Path(path).suffix.lower() not in (".png", ".svg", ".pdf"):
        raise InputError(f"{path}: a drawing ends in .png, .svg or .pdf")
    q = [math.radians(x) if joint.revolute else x for x, joint in zip(at, robot.joints, strict=True)]
    shown = ", ".join(f"{x:g}" for x in at)
    report.save_drawing(path, robot, q, f"{robot.title or robot.name} at {shown} (degrees, m)")
    print(f"Drawn at {shown}: {path}")
