"""``dynident fleet``: many recordings of many robots."""

from __future__ import annotations

from typing import Any

from . import COMMANDS, fleet_reduce, fleet_report
from .options import add_command


def add_parser(commands: Any) -> None:
    """Arguments of the commands below it."""
    parser = commands.add_parser("fleet", help=COMMANDS["fleet"])
    below = parser.add_subparsers(required=True, metavar="what")
    add_command(below, "reduce", fleet_reduce.run, help="each recording to its equations in a store")
    add_command(below, "report", fleet_report.run, help="friction, payload, scales: what changed")
