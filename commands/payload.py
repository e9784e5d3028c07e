"""``dynident payload``: a payload from recordings with and without it."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from rich.console import Console

from .. import estimation, model, report
from ..common.errors import InputError
from . import COMMANDS
from .arguments import (
    ANSWERED,
    DO_NOT_USE,
    essential_arguments,
    essential_rule,
    payload_frame_argument,
    processing_arguments,
    read_recordings,
    robot_argument,
    settings,
)
from .knowledge import constraints_of, friction_argument, friction_change, gain_errors_of, knowledge_arguments
from .report import provenance, report_arguments, settings_in_words, write_page
from .results import result_arguments, write_results

if TYPE_CHECKING:
    from collections.abc import Sequence


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser("payload", help=COMMANDS["payload"])
    robot_argument(parser)
    payload_frame_argument(parser)
    parser.add_argument(
        "--unloaded",
        action="append",
        default=[],
        metavar="LOG",
        help="recording without payload; repeatable: several are recordings of one robot",
    )
    parser.add_argument(
        "--loaded",
        action="append",
        required=True,
        metavar="LOG",
        help="recording with payload; repeatable: several are of one payload; method 3 pairs them in order",
    )
    parser.add_argument("--robot-parameters", metavar="JSON", help="the --json of 'dynident identify' (method 1)")
    parser.add_argument("--method", choices=("1", "2", "3", "4", "all"), default="all", help="default: all")
    parser.add_argument("--free-friction", action="store_true", help="method 1: estimate friction anew under load")
    friction_argument(parser, "method 4 and --robot-parameters")
    parser.add_argument(
        "--max-mismatch", type=float, metavar="RAD", help="method 3: largest difference of position"
    )
    parser.add_argument(
        "--validate",
        action="append",
        default=[],
        metavar="LOG",
        help="another one without payload, held out; repeatable",
    )
    knowledge_arguments(parser)
    essential_arguments(parser)
    processing_arguments(parser)
    result_arguments(parser)
    report_arguments(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run it."""
    rule = essential_rule(arguments)
    _check(arguments, rule is not None)
    constraints = constraints_of(arguments)
    stored = estimation.files.read_stored_robot(arguments.robot_parameters) if arguments.robot_parameters else None
    robot, processing = settings(arguments, stored)
    gains, told = arguments.drive_gains, set[str]()
    unloaded = read_recordings(arguments.unloaded, robot, gains, told, arguments)
    loaded = read_recordings(arguments.loaded, robot, gains, told, arguments)
    held_out = read_recordings(arguments.validate, robot, gains, told, arguments)
    gain_errors = gain_errors_of(arguments, robot, loaded, unloaded, stored)
    known = stored.estimate if stored else None
    with Console(stderr=True).status("reading") as status:
        problem = estimation.payload_problem(
            robot,
            loaded,
            unloaded,
            known,
            processing,
            status.update,
            robust=True,
            friction_change=friction_change(arguments),
        )
        status.update("estimating")
        methods = None if arguments.method == "all" else (int(arguments.method),)
        try:
            answer = estimation.answer_payload(
                problem,
                methods,
                arguments.free_friction,
                held_out,
                processing,
                constraints=constraints,
                gains=gain_errors,
                essential=rule,
            )
        except estimation.SolverError as error:
            raise InputError(str(error)) from None
        warnings = answer.warnings
    screen = report.payload_screen(answer, warnings)
    report.print_blocks(screen)
    if arguments.json:
        report.documents.write_json(
            arguments.json, report.documents.payload_document(answer, processing, gains, warnings)
        )
    write_page(arguments, lambda: _page(arguments, answer, loaded, held_out, processing, warnings))
    write_results(
        arguments,
        screen,
        lambda: estimation.answers.payload_system(problem, loaded, unloaded, processing),
    )
    return DO_NOT_USE if answer.verdict.level == "do_not_use" else ANSWERED


def _check(arguments: argparse.Namespace, essential: bool) -> None:
    """Refuse options that the methods asked for cannot use."""
    if not arguments.unloaded and not arguments.robot_parameters:
        raise InputError("give --unloaded recordings or --robot-parameters: without either nothing can be compared")
    if arguments.free_friction and arguments.method not in ("1", "all"):
        raise InputError("--free-friction belongs to method 1, which is not among the methods asked for")
    if (
        arguments.friction_change is not None
        and not arguments.robot_parameters
        and arguments.method not in ("4", "all")
    ):
        raise InputError("--friction-change belongs to method 4 and to --robot-parameters: neither is asked for")
    if essential and arguments.method not in ("4", "all"):
        raise InputError("--essential-ratio and --essential-sigma belong to method 4, which is not asked for")


def _page(
    arguments: argparse.Namespace,
    answer: estimation.PayloadAnswer,
    loaded: Sequence[model.Recording],
    held_out: Sequence[model.Recording],
    processing: model.Processing,
    warnings: Sequence[str],
) -> report.Page:
    """The report."""
    gains, problem = arguments.drive_gains, answer.problem
    files = {
        "without payload": arguments.unloaded,
        "with payload": arguments.loaded,
        "held out": arguments.validate,
        "robot's parameters": [arguments.robot_parameters] if arguments.robot_parameters else [],
    }
    return report.payload_page(
        answer,
        report.documents.payload_document(answer, processing, gains, warnings),
        answer.predictions,
        answer.excitation,
        provenance(arguments, files, settings_in_words(problem.robot, processing, gains)),
        warnings,
        others=len(loaded) + len(held_out) - len(answer.predictions),
    )
