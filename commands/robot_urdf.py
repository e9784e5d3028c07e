"""``dynident robot urdf``: the whole robot with its identified parameters as URDF."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .. import estimation, model, report
from ..common.errors import InputError
from ..common.files import write_text
from . import ANSWERED
from .options import Options, RobotOptions, add_command, option


@dataclass(frozen=True)
class _Bodies(Options):
    """Where the bodies come from, and the file to write."""

    robot_parameters: str | None = option(
        reads="robot's parameters",
        metavar="JSON",
        help="the --json of 'dynident identify' (default: the parameters of the robot's own file)",
    )
    gauge: estimation.possible.Gauge | None = option(
        choices=("base", "prior"),
        help="what decides the parameters that no motion shows: a convention (base), or the prior of 'identify "
        "--constrained prior' (default: prior where the JSON has it)",
    )
    out: str = option(writes="file", required=True, metavar="F.urdf", help="file to write")


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    add_command(commands, "urdf", run, RobotOptions, _Bodies, help="write the whole robot with its bodies as URDF")


def run(arm: RobotOptions, bodies: _Bodies) -> int:
    """Run it."""
    robot = arm.load()
    if bodies.robot_parameters:
        text, gauge = _identified(robot, bodies.robot_parameters, bodies.gauge)
    else:
        bodies.refuse("gauge", "belongs to --robot-parameters: the robot's own file has no gauge")
        gauge = "the values are those of the robot's own description."
        text = report.urdf.robot_urdf(robot, dict(robot.parameters), gauge)
    write_text(bodies.out, text)
    print(f"{bodies.out}: {gauge}")
    return ANSWERED


def _identified(robot: model.Robot, path: str, asked: estimation.possible.Gauge | None) -> tuple[str, str]:
    """The URDF of one robot that can exist, each number labelled; and what its gauge is, in words."""
    stored = estimation.files.read_stored_robot(path)
    robot = stored.applied_to(robot)
    base = model.base_parameters(robot)
    if stored.estimate.names != base.columns:
        raise InputError(f"{path}: other base parameters than this robot's: identify the robot again")
    gauge: estimation.possible.Gauge = asked or ("prior" if stored.nearest_prior else "base")
    parameters, words = (_by_prior if gauge == "prior" else _by_convention)(path, robot, base, stored)
    text = report.urdf.robot_urdf(
        robot, parameters, words, None, estimation.possible.robot_origins(robot, base, parameters, gauge)
    )
    return text, words


def _by_prior(
    path: str, robot: model.Robot, base: model.BaseParameters, stored: estimation.files.StoredRobot
) -> tuple[dict[str, float], str]:
    """Standard parameters nearest to the prior, as 'identify' stored them."""
    nearest = stored.nearest_prior
    if nearest is None:
        raise InputError(
            f"{path}: no parameters nearest to a prior in it: run 'dynident identify --constrained prior' for them"
        )
    if set(nearest.standard) != set(base.standard):
        raise InputError(f"{path}: other standard parameters than this robot's: identify the robot again")
    return nearest.standard, (
        f"gauge 'prior': the {len(base.columns)} base parameters are identified (from {path}, moved to those of a "
        f"robot that can exist: chi2 rises by {nearest.chi2_rise:.3g}); all other combinations, single masses "
        f"among them, are as near to a prior as the data allow: {nearest.source}."
    )


def _by_convention(
    path: str, robot: model.Robot, base: model.BaseParameters, stored: estimation.files.StoredRobot
) -> tuple[dict[str, float], str]:
    """Standard parameters of one robot that can exist and has the base parameters nearest to the identified."""
    answer = estimation.possible.solve_constrained_base(robot, base, stored.estimate)
    return answer.parameters, (
        f"gauge 'base': the {len(base.columns)} base parameters are identified (from {path}, moved to those of a "
        f"robot that can exist: chi2 rises by {answer.chi2_rise:.3g}); all other combinations, single masses among "
        "them, are one choice of many under which every link can exist, made by the solver and not by data."
    )
