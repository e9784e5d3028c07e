"""``dynident payload``: a payload from recordings with and without it."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

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
from .knowledge import constraints_of, gain_errors_of, knowledge_arguments
from .report import report_arguments, write_page
from .results import result_arguments, write_results

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..estimation import PayloadAnswer
    from ..model import Processing, Recording
    from ..report.html import Page


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser("payload", help="identify a payload from recordings with and without it")
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
    from rich.console import Console

    from ..common.errors import InputError
    from ..estimation import SolverError, answer_payload, payload_problem
    from ..estimation.files import read_stored_robot
    from ..estimation.payload import elimination_warnings, payload_system
    from ..report.by_joints_table import by_joints_table
    from ..report.constrained import recommended_notes, recommended_table
    from ..report.documents import payload_document, write_json
    from ..report.robot_tables import combined_notes
    from ..report.tables import console, payload_notes, payload_table

    if not arguments.unloaded and not arguments.robot_parameters:
        raise InputError("give --unloaded recordings or --robot-parameters: without either nothing can be compared")
    if arguments.free_friction and arguments.method not in ("1", "all"):
        raise InputError("--free-friction belongs to method 1, which is not among the methods asked for")
    rule = essential_rule(arguments)
    if rule is not None and arguments.method not in ("4", "all"):
        raise InputError("--essential-ratio and --essential-sigma belong to method 4, which is not asked for")
    constraints = constraints_of(arguments)
    stored = read_stored_robot(arguments.robot_parameters) if arguments.robot_parameters else None
    robot, processing = settings(arguments, stored)
    gains, told = arguments.drive_gains, set[str]()
    unloaded = read_recordings(arguments.unloaded, robot, gains, told, arguments)
    loaded = read_recordings(arguments.loaded, robot, gains, told, arguments)
    held_out = read_recordings(arguments.validate, robot, gains, told, arguments)
    gain_errors = gain_errors_of(arguments, robot, loaded, unloaded, stored)
    known = stored.estimate if stored else None
    with Console(stderr=True).status("reading") as status:
        problem = payload_problem(robot, loaded, unloaded, known, processing, status.update, robust=True)
        status.update("estimating")
        methods = None if arguments.method == "all" else (int(arguments.method),)
        try:
            answer = answer_payload(
                problem,
                methods,
                arguments.free_friction,
                held_out,
                processing,
                constraints=constraints,
                gains=gain_errors,
                essential=rule,
            )
        except SolverError as error:
            raise InputError(str(error)) from None
        warnings = elimination_warnings(answer)
    best, free = recommended_table(answer), payload_table(answer.estimates)
    by_joints = by_joints_table(answer.by_joints)
    free_notes = [*combined_notes(answer, warnings), *payload_notes(answer)]
    terminal = console(best, by_joints, free)
    for table, notes in ((best, recommended_notes(answer)), (by_joints, []), (free, free_notes)):
        terminal.print(table)
        for line in notes:
            terminal.print(line, markup=False, highlight=False)
        terminal.print()
    if arguments.json:
        write_json(arguments.json, payload_document(answer, processing, gains, warnings))
    write_page(arguments, lambda: _page(arguments, answer, loaded, held_out, processing, warnings))
    write_results(arguments, [best, by_joints, free], lambda: payload_system(problem, loaded, unloaded, processing))
    return DO_NOT_USE if answer.verdict.level == "do_not_use" else ANSWERED


def _page(
    arguments: argparse.Namespace,
    answer: PayloadAnswer,
    loaded: Sequence[Recording],
    held_out: Sequence[Recording],
    processing: Processing,
    warnings: Sequence[str],
) -> Page:
    """The report."""
    from ..estimation.payload import payload_excitation, payload_predictions
    from ..report.documents import payload_document
    from ..report.html import payload_page
    from .report import drawn, provenance, settings_in_words

    gains, problem = arguments.drive_gains, answer.problem
    files = {
        "without payload": arguments.unloaded,
        "with payload": arguments.loaded,
        "held out": arguments.validate,
        "robot's parameters": [arguments.robot_parameters] if arguments.robot_parameters else [],
    }
    shown = drawn(loaded), drawn(held_out)
    return payload_page(
        answer,
        payload_document(answer, processing, gains, warnings),
        payload_predictions(answer, *shown, processing),
        payload_excitation(problem),
        provenance(arguments, files, settings_in_words(problem.robot, processing, gains)),
        warnings,
        others=len(loaded) + len(held_out) - sum(map(len, shown)),
    )
