"""``dynident verify``: whether the controller does better with the payload that was entered."""

from __future__ import annotations

import argparse
from typing import Any

from .. import estimation, report
from . import COMMANDS
from .arguments import ANSWERED, DO_NOT_USE, chosen_robot, log_arguments, log_map, read_gains, robot_argument
from .values import gains_or_file


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser("verify", help=COMMANDS["verify"])
    robot_argument(parser, weight=False)
    told = (
        "the same motion, with columns qref1.. (commanded positions) or tauref1.. (torque predicted, N·m), or what "
        "--log-map names"
    )
    parser.add_argument("--before", required=True, metavar="LOG", help=f"{told}; old number in the controller")
    parser.add_argument("--after", required=True, metavar="LOG", help="the same with the new number")
    parser.add_argument("--drive-gains", type=gains_or_file, metavar="K1,K2,..|JSON", help="torque per current")
    parser.add_argument("--json", metavar="F", help="write the result as JSON")
    log_arguments(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run it."""
    robot, how = chosen_robot(arguments), log_map(arguments)
    read_gains(arguments, robot)
    before, after = (
        estimation.payload.read_following(path, robot, arguments.drive_gains, how)
        for path in (arguments.before, arguments.after)
    )
    found = estimation.payload.following_change(before, after, robot.processing.still_speed)
    report.print_blocks(report.following_screen(found))
    if arguments.json:
        report.documents.write_json(arguments.json, report.documents.following_document(found))
    return DO_NOT_USE if found.kind != "torque" and found.total.clear == "rose" else ANSWERED
