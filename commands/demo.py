"""``dynident demo``: the paper's experiment on a simulated RX90."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from .arguments import positive, whole


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser("demo", help="the paper's experiment on a simulated RX90")
    parser.add_argument("--out", default="demo", metavar="DIR", help="folder of the results (default: demo)")
    parser.add_argument("--seed", type=whole, default=0, help="of the trajectories and the noise (default: 0)")
    parser.add_argument(
        "--trajectories", type=positive, default=18, metavar="N", help="default: 18, as in the paper"
    )
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run it."""
    from .paper_experiment import run_demo

    return run_demo(Path(arguments.out), arguments.seed, arguments.trajectories)
