"""``dynident robot urdf``: the whole robot with its identified parameters as URDF."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from .arguments import ANSWERED, chosen_robot, robot_argument

if TYPE_CHECKING:
    from ..model import Robot


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser("urdf", help="write the whole robot with its bodies as URDF")
    robot_argument(parser)
    parser.add_argument(
        "--robot-parameters",
        metavar="JSON",
        help="the --json of 'dynident identify' (default: the parameters of the robot's own file)",
    )
    parser.add_argument("--out", required=True, metavar="F.urdf", help="file to write")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run it."""
    from ..model.files import write_text
    from ..report.urdf import robot_urdf

    robot = chosen_robot(arguments)
    if arguments.robot_parameters:
        robot, parameters, gauge = _identified(robot, arguments.robot_parameters)
    else:
        parameters, gauge = dict(robot.parameters), "the values are those of the robot's own description."
    write_text(arguments.out, robot_urdf(robot, parameters, gauge))
    print(f"{arguments.out}: {gauge}")
    return ANSWERED


def _identified(robot: Robot, path: str) -> tuple[Robot, dict[str, float], str]:
    """Standard parameters of one robot that can exist and has the base parameters nearest to the identified."""
    from ..estimation import solve_constrained_base
    from ..estimation.stored import read_stored_robot
    from ..model import InputError, base_parameters

    stored = read_stored_robot(path)
    robot = stored.applied_to(robot)
    base = base_parameters(robot)
    if stored.estimate.names != base.columns:
        raise InputError(f"{path}: other base parameters than this robot's: identify the robot again")
    answer = solve_constrained_base(robot, base, stored.estimate)
    gauge = (
        f"the {len(base.columns)} base parameters are identified (from {path}, moved to those of a robot that can "
        f"exist: chi2 rises by {answer.chi2_rise:.3g}); all other combinations, single masses among them, are one "
        "choice of many under which every link can exist, made by the solver and not by data."
    )
    return robot, answer.witness, gauge
