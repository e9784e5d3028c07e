"""``dynident robot mjcf``, ``usd``, ``urdf`` and ``sdf``: the whole robot with its parameters for a simulator."""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass

from ... import estimation, model
from ...common.errors import InputError
from ...common.files import write_text
from ...common.letters import one_line
from ...common.schema import present
from .. import export, fleet, results
from ..export.simulators.whole_robot import pooled_whole_robot, stored_whole_robot
from . import ANSWERED, DO_NOT_USE
from .options import Options, RobotOptions, option, print_lines
from .values import number

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
    passport: tuple[str, ...] = option(
        reads="passport",
        action="append",
        default=[],
        metavar="F",
        help="the --passport of 'dynident identify' instead; give it again to pool several identifications",
    )
    prior_mass: float | None = option(
        type=number, metavar="KG", help="of the moving links, beside --passport: cylinders of this mass as prior"
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
        if len(self.robot_parameters) > 1:
            raise InputError(
                "several --robot-parameters: a JSON holds numbers, not the equations that pooling needs: give "
                "--passport once for each, as 'dynident identify --passport F' writes them"
            )
        if not self.passport:
            self.refuse("prior_mass", "belongs to --passport: 'dynident identify' has taken it for its JSON")
        elif self.robot_parameters:
            raise InputError("give --robot-parameters or --passport: each is a whole robot")
        self.refuse(
            "gauge",
            "is gone: only links that can exist are written, where data say nothing by a prior: 'dynident identify "
            "--constrained prior --prior-mass KG --json F' gives them (KG: the moving links' mass)",
        )


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


def _numbers(bodies: _Bodies, robot: model.Robot) -> tuple[estimation.possible.WholeRobot, tuple[str, ...]]:
    """The robot with its numbers, and what speaks against using them."""
    if bodies.passport:
        return _pooled(bodies, robot)
    if not bodies.robot_parameters:
        source = f"the description of {robot.name}, nothing identified"
        return estimation.possible.whole_robot(robot, dict(robot.parameters), source), ()
    (path,) = bodies.robot_parameters
    stored = results.read_stored_robot(path)
    whole = stored_whole_robot(robot, stored, path)
    return whole, tuple(present(stored.reasons_against_use) or ())


def _pooled(bodies: _Bodies, robot: model.Robot) -> tuple[estimation.possible.WholeRobot, tuple[str, ...]]:
    """The robot by the equations of all passports together.

    Raises:
        InputError: if they are of another robot, of different ones, of payloads, or contradict each other.
    """
    passports = [fleet.read_passport(path) for path in bodies.passport]
    passport = fleet.merged_passports(passports) if len(passports) > 1 else passports[0]
    result = fleet.answered(passport)
    if not isinstance(result, estimation.Identification):
        raise InputError(f"{bodies.passport[0]}: a passport of a payload: give those of 'dynident identify'")
    _check_described(robot, result.robot, bodies.passport[0])
    try:
        whole = pooled_whole_robot(result, bodies.prior_mass, passport.name)
    except estimation.SolverError as error:
        raise InputError(str(error)) from None
    return whole, tuple(result.verdict.reasons)


def _check_described(described: model.Robot, identified: model.Robot, path: str) -> None:
    """Refuse passports of another robot than the one that is described."""
    forms = [described.with_offsets(offsets) for offsets in (False, True)]
    if described.coupling is not None:
        forms += [form.with_coulomb(coulomb) for form in forms for coulomb in ("sum", "paper")]
    if identified.name != described.name or identified.fingerprint not in {form.fingerprint for form in forms}:
        raise InputError(
            f"{path}: of robot {identified.name!r}, which is not {described.name!r} as it is described: give the "
            "passports of one robot, and that robot as --robot"
        )
