"""Files that ``payload`` and ``identify`` write beside the JSON: the printed tables, and the equations."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from .. import estimation, report
from ..common.files import write_text

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rich.table import Table


def result_arguments(parser: argparse.ArgumentParser) -> None:
    """``--csv``, ``--latex`` and ``--npz``."""
    group = parser.add_argument_group("tables and equations")
    group.add_argument("--csv", metavar="F", help="write the printed tables for a spreadsheet")
    group.add_argument("--latex", metavar="F", help="write the printed tables for a paper (booktabs)")
    group.add_argument("--npz", metavar="F", help="write W, Y, weights and reduced factors for your own solver")


def write_results(
    arguments: argparse.Namespace,
    tables: Sequence[Table],
    system: Callable[[], estimation.payload.ObservationSystem],
) -> None:
    """Write what was asked for.

    Args:
        arguments: of the command.
        tables: as printed.
        system: makes the equations, held whole; called only where they are asked for.
    """
    if arguments.csv:
        write_text(arguments.csv, report.csv_tables.csv_tables(tables))
    if arguments.latex:
        write_text(arguments.latex, report.latex.latex_tables(tables))
    if arguments.npz:
        report.npz.write_npz(arguments.npz, system())
