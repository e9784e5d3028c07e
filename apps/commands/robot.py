"""``dynident robot``: shipped robots, a new one from a data sheet, and what a description says."""

from __future__ import annotations

from functools import partial
from typing import Any

from ... import model
from . import ANSWERED, COMMANDS, robot_check, robot_new, robot_show, robot_simulator
from .options import add_command


def add_parser(commands: Any) -> None:
    """Arguments of the command and of those below it."""
    parser = commands.add_parser("robot", help=COMMANDS["robot"])
    below = parser.add_subparsers(required=True, metavar="what")
    add_command(below, "list", run_list, help="the shipped robots")
    add_command(below, "show", robot_show.run, help="table, limits and frames of a robot, and a drawing")
    new, check = robot_new.DESCRIPTION, robot_check.DESCRIPTION
    add_command(below, "new", robot_new.run, help="make a robot's file from a data sheet", description=new)
    question = "check order, senses and zeros of the joints by a recording: its tool poses, its torques"
    add_command(below, "check", robot_check.run, help=question, description=check)
    for name, title in robot_simulator.FORMATS.items():
        add_command(below, name, partial(robot_simulator.run, name), help=f"write the whole robot as {title}")


def run_list() -> int:
    """Names and titles."""
    for name in model.robot_names():
        print(f"{name:14s}{model.load_robot(name).title}")
    return ANSWERED
