"""``dynident robot mjcf``, ``usd``, ``urdf`` and ``sdf``: the whole robot with its parameters for a simulator."""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from functools import partial
from typing import Any

from .. import estimation, report
from ..common.files import write_text
from ..common.schema import present
from . import ANSWERED, DO_NOT_USE
from .options import Options, RobotOptions, add_command, option, print_lines

FORMATS = {"mjcf": "MJCF (MuJoCo)", "usd": "USD (Isaac Sim)", "urdf": "URDF", "sdf": "SDFormat (Gazebo, Drake)"}
"""The formats, told again here so that ``--help`` need not load them."""
INTO = ("mjcf", "urdf")
"""Formats whose files can get the numbers."""


@dataclass(frozen=True)
class _Bodies(Options):
    """Where the numbers come from, and the file to write."""

    robot_parameters: str | None = option(
        reads="robot's parameters",
        metavar="JSON",
        help="the --json of 'dynident identify' (default: the parameters of the robot's own file)",
    )
    out: str = option(writes="file", required=True, metavar="F", help="file to write")
    into: str | None = option(
        reads="model",
        metavar="F",
        help="mjcf, urdf: a model of your own that gets the numbers, matched by names of joints",
    )
    despite_verdict: bool = option(action="store_true", help="write it whatever the verdict")
    gauge: str | None = option(help=argparse.SUPPRESS)

    def check(self, name: str) -> None:
        """Refuse what the format does not know, and what there was once, with what to do today."""
        if name not in INTO:
            self.refuse("into", f"belongs to {' and '.join(INTO)}, not to {name}")
        self.refuse(
            "gauge",
            "is gone: only links that can exist are written, where data say nothing by a prior: 'dynident identify "
            "--constrained prior --prior-mass KG --json F' gives them (KG: the moving links' mass)",
        )


def add_parsers(commands: Any) -> None:
    """Arguments of the commands, one a format."""
    for name, title in FORMATS.items():
        add_command(
            commands, name, partial(run, name), RobotOptions, _Bodies, help=f"write the whole robot as {title}"
        )


def run(name: str, arm: RobotOptions, bodies: _Bodies) -> int:
    """Run it."""
    bodies.check(name)
    form = report.simulators.FORMATS[name]
    robot = arm.load()
    against: tuple[str, ...] = ()
    if bodies.robot_parameters is None:
        source = f"the description of {robot.name}, nothing identified"
        whole = estimation.possible.whole_robot(robot, dict(robot.parameters), source)
    else:
        stored = estimation.files.read_stored_robot(bodies.robot_parameters)
        against = present(stored.reasons_against_use) or ()
        whole = estimation.answers.stored_whole_robot(robot, stored, bodies.robot_parameters)
    against += whole.heavier_than_the_arm()
    if against and not bodies.despite_verdict:
        why = "; ".join(against)
        print(f"dynident: not written: {why} (--despite-verdict writes it all the same)", file=sys.stderr)
        return DO_NOT_USE
    notes = form.notes(whole)
    if bodies.into is None:
        write_text(bodies.out, form.text(whole))
    else:
        changed = report.simulators.into(name, bodies.into, whole, form.head(whole))
        write_text(bodies.out, changed.text)
        notes += changed.notes
    print_lines(f"{bodies.out}: {whole.source}. Prior: {whole.prior}.", *(f"  {line}" for line in notes))
    return ANSWERED
