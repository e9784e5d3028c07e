"""``dynident gains``: torque per motor current, from recordings without and with a known payload."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

from rich.console import Console

from .. import estimation, report
from ..common.errors import InputError
from . import COMMANDS
from .arguments import ANSWERED, DO_NOT_USE, processing_arguments, read_recordings, robot_argument, settings


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser("gains", help=COMMANDS["gains"])
    robot_argument(parser)
    for option, what in (("unloaded", "currents without payload"), ("loaded", "currents with it")):
        parser.add_argument(
            f"--{option}", action="append", required=True, metavar="LOG", help=f"{what}; repeatable"
        )
    known = parser.add_mutually_exclusive_group(required=True)
    known.add_argument("--mass", type=float, metavar="KG", help="the payload's mass")
    known.add_argument("--payload", metavar="TOML", help="mass, com, inertia_com as far as they are known")
    parser.add_argument("--mass-sigma", type=float, metavar="KG", help="its standard deviation (default: 0)")
    processing_arguments(parser, gains=False)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run it."""
    if arguments.payload and arguments.mass_sigma is not None:
        raise InputError("--mass-sigma belongs to --mass; in a payload's file it is the key mass_sigma")
    load = estimation.gains.read_known_load(arguments.payload) if arguments.payload else None
    load = load or estimation.gains.known_mass(arguments.mass, arguments.mass_sigma or 0.0)
    robot, processing = settings(arguments)
    told = set[str]()
    amperes = (1.0,) * robot.n
    plain = replace(robot, drives=replace(robot.drives, coupling=None))  # each motor's own current
    unloaded, loaded = (
        read_recordings(paths, plain, amperes, told, arguments) for paths in (arguments.unloaded, arguments.loaded)
    )
    with Console(stderr=True).status("reading") as status:
        problem = estimation.gains.gain_problem(robot, unloaded, loaded, processing, status.update, load)
        status.update("estimating")
        gains = estimation.identify_gains(problem, load)
    report.print_blocks(report.gains_screen(gains))
    if arguments.json:
        report.documents.write_json(arguments.json, report.documents.gains_document(gains, processing))
    return ANSWERED if any(gains.identified) else DO_NOT_USE
