"""``dynident robot mjcf``, ``usd``, ``urdf`` and ``sdf``: the whole robot with its parameters for a simulator."""

from __future__ import annotations

import sys
from dataclasses import dataclass

from ... import estimation, model
from ...common.errors import InputError, one_line
from ...common.files import write_text
from ...common.schema import present
from .. import export, results
from ..export.simulators.whole_robot import stored_whole_robot
from . import ANSWERED, DO_NOT_USE
from .options import Options, RobotOptions, option, print_lines

FORMATS = {"mjcf": "MJCF (MuJoCo)", "usd": "USD (Isaac Sim)", "urdf": "URDF", "sdf": "SDFormat (Gazebo, Drake)"}
"""The formats, told again here so that ``--help`` need not load them."""
INTO = ("mjcf", "urdf")
"""Formats whose files can get the numbers."""


@dataclass(frozen=True)
class _Bodies(Options):
    """Where the numbers come from, and the file to write."""

    robot_parameters: tuple[str, ...] = option(
        reads="robot's parameters",
        action="append",
        default=[],
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

    def check(self, name: str) -> None:
        """Refuse what the format does not know."""
        if name not in INTO:
            self.refuse("into", f"belongs to {' and '.join(INTO)}, not to {name}")
        if len(self.robot_parameters) > 1:
            raise InputError("several --robot-parameters: give all recordings to one 'dynident identify'")


def run(name: str, arm: RobotOptions, bodies: _Bodies) -> int:
    """Run it."""
    bodies.check(name)
    form = export.simulators.FORMATS[name]
    robot = arm.load()
    whole, against = _numbers(bodies, robot)
    against += whole.heavier_than_the_arm()
    if against and not bodies.despite_verdict:
        why = "; ".join(against)
        print(f"dynident: not written: {one_line(why)} (--despite-verdict writes it all the same)", file=sys.stderr)
        return DO_NOT_USE
    notes = form.notes(whole)
    if bodies.into is None:
        write_text(bodies.out, form.text(whole))
    else:
        changed = export.simulators.into(name, bodies.into, whole, form.head(whole))
        write_text(bodies.out, changed.text)
        notes += changed.notes
    print_lines(f"{bodies.out}: {whole.source}. Prior: {whole.prior}.", *(f"  {line}" for line in notes))
    return ANSWERED


def _numbers(bodies: _Bodies, robot: model.Robot) -> tuple[estimation.WholeRobot, tuple[str, ...]]:
    """The robot with its numbers, and what speaks against using them."""
    if not bodies.robot_parameters:
        source = f"the description of {robot.name}, nothing identified"
        return estimation.whole_robot(robot, dict(robot.parameters), source), ()
    (path,) = bodies.robot_parameters
    stored = results.read_stored_robot(path)
    whole = stored_whole_robot(robot, stored, path)
    return whole, tuple(present(stored.reasons_against_use) or ())
