"""``dynident robot``: shipped robots, a new one from a data sheet, and what a description says."""

from __future__ import annotations

from typing import Any

from .. import model
from . import ANSWERED, COMMANDS, robot_check, robot_new, robot_show, robot_simulator
from .options import add_command


def add_parser(commands: Any) -> None:
    """Arguments of the command and of those below it."""
    parser = commands.add_parser("robot", help=COMMANDS["robot"])
    below = parser.add_subparsers(required=True, metavar="what")
    add_command(below, "list", run_list, help="the shipped robots")
    for command in (robot_show, robot_new, robot_check):
        command.add_parser(below)
    robot_simulator.add_parsers(below)


def run_list() -> int:
    """Names and titles."""
    for name in model.robot_names():
        print(f"{name:14s}{model.load_robot(name).title}")
    return ANSWERED
