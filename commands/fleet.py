"""``dynident fleet``: many recordings of many robots."""

from __future__ import annotations

from typing import Any

from . import COMMANDS, fleet_reduce, fleet_report, fleet_simulate


def add_parser(commands: Any) -> None:
    """Arguments of the commands below it."""
    parser = commands.add_parser("fleet", help=COMMANDS["fleet"])
    below = parser.add_subparsers(required=True, metavar="what")
    for command in (fleet_reduce, fleet_report, fleet_simulate):
        command.add_parser(below)
