"""``dynident weigh``: a payload from a short motion of a few joints near a pose."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from rich.console import Console

from .. import estimation, model, report
from ..common.errors import InputError
from . import COMMANDS
from .arguments import ANSWERED, DO_NOT_USE, processing_arguments, read_recordings, robot_argument, settings
from .knowledge import constraints_of, friction_argument, friction_change, gain_errors_of, knowledge_arguments
from .report import provenance, report_arguments, settings_in_words, write_page

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser("weigh", help=COMMANDS["weigh"])
    robot_argument(parser)
    parser.add_argument(
        "--loaded",
        action="append",
        required=True,
        metavar="LOG",
        help="the motion with the payload; give it again for repeated recordings, in the order they were made",
    )
    parser.add_argument(
        "--unloaded",
        action="append",
        default=[],
        metavar="LOG",
        help="the same motion without it: one for all of --loaded, or one for each",
    )
    parser.add_argument("--robot-parameters", metavar="JSON", help="the --json of 'dynident identify', instead")
    parser.add_argument("--moving", type=joint_list, metavar="J1,J2,..", help="joints that move; seen by default")
    parser.add_argument(
        "--inertia", metavar="box:AxBxC|cylinder:DxL", help="assume this body's inertia if none is measured [mm]"
    )
    parser.add_argument(
        "--details", action="store_true", help="the second page: parameters, joints, condition numbers"
    )
    parser.add_argument(
        "--max-mismatch", type=float, metavar="RAD", help="largest difference of position with and without payload"
    )
    friction_argument(parser, "--robot-parameters")
    knowledge_arguments(parser)
    processing_arguments(parser)
    report_arguments(parser)
    parser.set_defaults(run=run)


def joint_list(text: str) -> tuple[int, ...]:
    """Numbers of joints separated by commas."""
    try:
        joints = tuple(int(part) for part in text.split(","))
    except ValueError:
        joints = ()
    if not joints or min(joints) < 1 or len(set(joints)) != len(joints):
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of different joint numbers such as 2,3,5,6")
    return joints


def run(arguments: argparse.Namespace) -> int:
    """Run it."""
    if not arguments.unloaded and not arguments.robot_parameters:
        raise InputError("give --unloaded recordings or --robot-parameters: without either nothing can be compared")
    if arguments.friction_change is not None and not arguments.robot_parameters:
        raise InputError("--friction-change belongs to --robot-parameters: a difference of torques frees friction")
    constraints = constraints_of(arguments)
    stand_in = estimation.StandIn.parse(arguments.inertia) if arguments.inertia is not None else None
    stored = estimation.files.read_stored_robot(arguments.robot_parameters) if arguments.robot_parameters else None
    robot, processing = settings(arguments, stored)
    told = set[str]()
    loaded, unloaded = (
        read_recordings(paths, robot, arguments.drive_gains, told, arguments)
        for paths in (arguments.loaded, arguments.unloaded)
    )
    gains = gain_errors_of(arguments, robot, loaded, unloaded, stored, compared=bool(unloaded))
    with Console(stderr=True).status("reading") as status:
        problem, others = _problems(arguments, robot, processing, loaded, unloaded, stored, status.update)
        status.update("estimating")
        try:
            answer = estimation.answer_payload(
                problem, constraints=constraints, gains=gains, stand_in=stand_in, others=others
            )
        except estimation.SolverError as error:
            raise InputError(str(error)) from None
    measured = stand_in is not None and answer.stand_in is None
    report.print_blocks(report.weigh_screen(answer, measured, arguments.details))
    if arguments.json:
        report.documents.write_json(
            arguments.json, report.documents.payload_document(answer, processing, arguments.drive_gains)
        )
    write_page(arguments, lambda: _page(arguments, answer, processing))
    return DO_NOT_USE if answer.verdict.level == "do_not_use" else ANSWERED


def _page(
    arguments: argparse.Namespace, answer: estimation.PayloadAnswer, processing: model.Processing
) -> report.Page:
    """The report.

    Raises:
        InputError: if --plots asks for figures and there are none.
    """
    gains = arguments.drive_gains
    files = {
        "without payload": arguments.unloaded,
        "with payload": arguments.loaded,
        "robot's parameters": [arguments.robot_parameters] if arguments.robot_parameters else [],
    }
    settings_told = settings_in_words(answer.problem.robot, processing, gains)
    document = report.documents.payload_document(answer, processing, gains)
    page = report.weigh_page(answer, document, provenance(arguments, files, settings_told))
    if arguments.plots and not page.drawings():
        raise InputError("--plots: no joints see the mass, there is nothing to draw")
    return page


def _problems(
    arguments: argparse.Namespace,
    robot: model.Robot,
    processing: model.Processing,
    loaded: Sequence[model.Recording],
    unloaded: Sequence[model.Recording],
    stored: estimation.files.StoredRobot | None,
    progress: Callable[[str], None],
) -> tuple[estimation.PayloadProblem, list[estimation.PayloadProblem]]:
    """What is answered, and what it is compared with: torque differences first, the robot's parameters beside."""
    problems = []
    if unloaded:
        problems.append(
            estimation.payload.difference_weighing(robot, loaded, unloaded, processing, arguments.moving, progress)
        )
    if stored is not None:
        problems.append(
            estimation.payload.known_robot_weighing(
                robot, loaded, stored.estimate, processing, arguments.moving, progress, friction_change(arguments)
            )
        )
    return problems[0], problems[1:]
