"""``dynident robot check``: does a recording without payload agree with the robot's kinematics?"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from .arguments import ANSWERED, DO_NOT_USE, processing_arguments, read_recordings, robot_argument, settings

if TYPE_CHECKING:
    from ..estimation import KinematicsCheck

_SHOWN = 6


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser("check", help="check order, senses and zeros of the joints by a recording")
    robot_argument(parser)
    parser.add_argument("--data", action="append", required=True, metavar="CSV", help="recording without payload")
    processing_arguments(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run it."""
    from rich.console import Console

    from ..estimation import rank_readings

    robot, processing = settings(arguments)
    recordings = read_recordings(arguments.data, robot, arguments.drive_gains, set(), arguments)
    with Console(stderr=True).status("reading") as status:
        check = rank_readings(robot, recordings, processing, status.update)
    for line in lines(check):
        print(line)
    if arguments.json:
        from ..report.documents import write_json

        write_json(arguments.json, document(robot.name, check))
    return DO_NOT_USE if check.suggested else ANSWERED


def lines(check: KinematicsCheck) -> list[str]:
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


def document(robot: str, check: KinematicsCheck) -> dict[str, Any]:
    """What ``--json`` writes."""
    ranked = [
        {
            "residual": one.residual,
            "order": [column + 1 for column in one.reading.order],
            "sign": one.reading.sign,
            "zero_deg": [90 * quarter for quarter in one.reading.quarters],
            "torque_sign": one.reading.torque,
        }
        for one in check.ranked[:20]
    ]
    return {
        "robot": robot,
        "unit": check.unit,
        "as_recorded": check.as_recorded.residual,
        "suggested": check.suggested.reading.told() if check.suggested else None,
        "ranked": ranked,
    }
