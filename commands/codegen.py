"""``dynident codegen``: a function of the robot as C."""

from __future__ import annotations

import argparse
from typing import Any

from .. import model
from . import COMMANDS
from .arguments import ANSWERED, chosen_robot, robot_argument


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser("codegen", help=COMMANDS["codegen"])
    robot_argument(parser)
    parser.add_argument("--function", required=True, metavar="NAME", help="such as base_regressor")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder of the files, made if missing")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run it."""
    for path in model.generate_code(chosen_robot(arguments), arguments.function, arguments.out):
        print(path)
    return ANSWERED
