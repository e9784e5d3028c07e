"""``dynident identify``: the robot's own parameters."""

from __future__ import annotations

import argparse
from typing import Any

from .arguments import ANSWERED, DO_NOT_USE, processing_arguments, read_recordings, robot_argument, settings
from .results import result_arguments, write_results


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser("identify", help="identify the robot's own parameters, without payload")
    robot_argument(parser)
    parser.add_argument("--data", action="append", required=True, metavar="CSV", help="recording without payload")
    parser.add_argument("--validate", action="append", default=[], metavar="CSV", help="another one, held out")
    processing_arguments(parser)
    result_arguments(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run it."""
    from rich.console import Console

    from ..estimation import identification_system, identify
    from ..estimation.verdict import fit_reasons
    from ..report.tables import console, robot_notes, robot_table

    robot, processing = settings(arguments)
    told: set[str] = set()
    recordings = read_recordings(arguments.data, robot, arguments.drive_gains, told)
    held_out = read_recordings(arguments.validate, robot, arguments.drive_gains, told)
    with Console(stderr=True).status("reading") as status:
        result = identify(robot, recordings, processing, held_out, progress=status.update)
    table = robot_table(result)
    terminal = console(table)
    terminal.print(table)
    for line in robot_notes(result):
        terminal.print(line, markup=False, highlight=False)
    if arguments.json:
        from ..report.documents import identification_document, write_json

        write_json(arguments.json, identification_document(result, processing, arguments.drive_gains))
    write_results(arguments, [table], lambda: identification_system(result, recordings, processing))
    return DO_NOT_USE if fit_reasons(result.estimate.fit, "the model") else ANSWERED
