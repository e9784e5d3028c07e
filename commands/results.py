"""Files that ``payload`` and ``identify`` write beside the JSON: the printed tables, and the equations."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from .. import estimation, report
from ..common.files import write_text

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


def result_arguments(parser: argparse.ArgumentParser) -> None:
    """``--csv``, ``--latex`` and ``--npz``."""
    group = parser.add_argument_group("tables and equations")
    group.add_argument("--csv", metavar="F", help="write the printed tables for a spreadsheet")
    group.add_argument("--latex", metavar="F", help="write the printed tables for a paper (booktabs)")
    group.add_argument("--npz", metavar="F", help="write W, Y, weights and reduced factors for your own solver")


def write_results(
    arguments: argparse.Namespace,
    screen: Sequence[report.Block],
    system: Callable[[], estimation.answers.ObservationSystem],
) -> None:
    """Write what was asked for.

    Args:
        arguments: of the command.
        screen: what the terminal shows; its tables are written.
        system: makes the equations, held whole; called only where they are asked for.
    """
    if arguments.csv:
        write_text(arguments.csv, report.csv_tables(report.tables_of(screen)))
    if arguments.latex:
        write_text(arguments.latex, report.latex_tables(report.tables_of(screen)))
    if arguments.npz:
        report.npz.write_npz(arguments.npz, system())
