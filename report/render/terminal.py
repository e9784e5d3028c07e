"""Blocks on a terminal: tables by rich, lines as they are."""

from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table as Grid
from rich.text import Text

from ..blocks import Block, Notes, Table

_FOLDS = 120


def print_blocks(blocks: Sequence[Block]) -> None:
    """Print tables and notes, on a terminal wide enough that no number of the tables is cut off."""
    grids = {id(block): _grid(block) for block in blocks if isinstance(block, Table)}
    terminal = _console(list(grids.values()))
    for block in blocks:
        if isinstance(block, Table):
            terminal.print(grids[id(block)])
        elif isinstance(block, Notes):
            for line in block.lines:
                terminal.print(line, markup=False, highlight=False)


def _console(grids: Sequence[Grid]) -> Console:
    terminal = Console()
    free = terminal.options.update(width=1000)
    widths = [Measurement.get(terminal, free, grid).maximum for grid in grids]
    # A wider table has a column of text that folds; its numbers need no more than this.
    return Console(width=max(terminal.width, *(width if width <= _FOLDS else 80 for width in widths), 0))


def _grid(table: Table) -> Grid:
    """The table as rich prints it; with four methods it fits 80 columns."""
    grid = Grid(
        title=Text(table.title, style="table.title") if table.title else None,
        title_justify="left",
        box=None if table.style == "bare" else box.SIMPLE_HEAD,
        padding=(0, 1) if table.style in ("roomy", "bare") else 0,
        show_header=table.style != "bare",
    )
    for column in table.columns:
        grid.add_column(
            Text(column.heading),
            justify="right" if column.numeric else "left",
            overflow="fold" if column.folds else "ellipsis",
            no_wrap=not column.folds,
        )
    for row in table.rows:
        grid.add_row(*(Text(str(cell)) for cell in row), end_section=row[0] in table.ends)
    return grid
