"""Files that ``payload`` and ``identify`` write beside the JSON: the printed tables, and the equations."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rich.table import Table

    from ..estimation.payload import ObservationSystem


def result_arguments(parser: argparse.ArgumentParser) -> None:
    """``--csv``, ``--latex`` and ``--npz``."""
    group = parser.add_argument_group("tables and equations")
    group.add_argument("--csv", metavar="F", help="write the printed tables for a spreadsheet")
    group.add_argument("--latex", metavar="F", help="write the printed tables for a paper (booktabs)")
    group.add_argument("--npz", metavar="F", help="write W, Y, weights and reduced factors for your own solver")


def write_results(
    arguments: argparse.Namespace, tables: Sequence[Table], system: Callable[[], ObservationSystem]
) -> None:
    """Write what was asked for.

    Args:
        arguments: of the command.
        tables: as printed.
        system: makes the equations, held whole; called only where they are asked for.
    """
    from ..common.files import write_text
    from ..report.csv_tables import csv_tables
    from ..report.latex import latex_tables
    from ..report.npz import write_npz

    if arguments.csv:
        write_text(arguments.csv, csv_tables(tables))
    if arguments.latex:
        write_text(arguments.latex, latex_tables(tables))
    if arguments.npz:
        write_npz(arguments.npz, system())
