"""A table of the terminal as plain rows, from which CSV and LaTeX are made: one table, three ways to show it."""

from dataclasses import dataclass

from rich.table import Table
from rich.text import Text


@dataclass(frozen=True)
class Sheet:
    """Title, headings and cells of a table, as the terminal prints them.

    Attributes:
        title: of the table.
        headings: one per column; the first is often empty.
        rows: cells, a row each as long as ``headings``.
        ends: for each row whether a section ends after it.
        numeric: for each column whether it is set to the right, as numbers are.
    """

    title: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    ends: tuple[bool, ...]
    numeric: tuple[bool, ...]


def sheet_of(table: Table) -> Sheet:
    """The rows of a table."""
    columns = [[_plain(cell) for cell in column.cells] for column in table.columns]
    return Sheet(
        _plain(table.title or ""),
        tuple(_plain(column.header) for column in table.columns),
        tuple(zip(*columns, strict=True)),
        tuple(row.end_section for row in table.rows),
        tuple(column.justify == "right" for column in table.columns),
    )


def _plain(cell: object) -> str:
    return cell.plain if isinstance(cell, Text) else Text.from_markup(str(cell)).plain
