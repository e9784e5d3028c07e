"""``dynident demo``: the paper's experiment on a simulated RX90."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ...common.errors import InputError
from .. import COMMANDS
from ..report import report_arguments
from ..values import positive, share, whole
from .experiment import run_demo
from .repeated import run_repeated


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser("demo", help=COMMANDS["demo"])
    parser.add_argument("--out", default="demo", metavar="DIR", help="folder of the results (default: demo)")
    parser.add_argument("--seed", type=whole, default=0, help="of the trajectories and the noise (default: 0)")
    parser.add_argument(
        "--trajectories", type=positive, default=18, metavar="N", help="default: 18, as in the paper"
    )
    parser.add_argument(
        "--noise",
        choices=("paper", "slow", "none"),
        default="paper",
        help="as the paper's robot (default), with a memory of 0.8 s, or none",
    )
    parser.add_argument(
        "--gain-error", type=share, metavar="SHARE", help="of the drive gains, such as 0.02 (default: 0)"
    )
    parser.add_argument(
        "--repeat",
        type=positive,
        metavar="N",
        help="N experiments with seeds from --seed on, each with every noise and with a gain error "
        "(default: 0.02): spread and coverage of every method",
    )
    report_arguments(parser, "DIR/report.html")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run it."""
    if arguments.repeat is None:
        return run_demo(arguments, arguments.gain_error or 0.0)
    if arguments.noise != "paper":
        raise InputError("--repeat runs every noise: leave --noise out")
    if arguments.report or arguments.plots:
        raise InputError("--report and --plots belong to one experiment: leave --repeat out")

    gain_error = 0.02 if arguments.gain_error is None else arguments.gain_error
    folder, seed = Path(arguments.out), arguments.seed
    return run_repeated(folder, seed, arguments.trajectories, arguments.repeat, gain_error)
