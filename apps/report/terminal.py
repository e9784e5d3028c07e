"""Blocks on a terminal: tables by rich, lines as they are; nothing is wider than the terminal.

What is printed is text: no letter in it is taken for markup.
"""

import os
import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import StringIO
from typing import IO

from rich import box
from rich.cells import cell_len
from rich.console import Console
from rich.table import Table as Grid
from rich.text import Text

from ...common.errors import printable
from .blocks import Banner, Block, Cell, Column, Notes, Screen, Table
from .blocks import Text as Words

LINES, COLUMNS = 25, 80
"""A screen."""
_NARROWEST = 14
"""Letters that a column of words needs at least."""
_LONGEST = 3
"""Lines of one remark that the first screen shows."""
_CUT = " .."
_FEWEST = 20
"""Columns of the narrowest terminal that is laid out."""


def print_blocks(blocks: Sequence[Block], stream: IO[str] | None = None) -> None:
    """Print tables and lines; a table wider than the terminal is printed in parts, one below the other."""
    terminal = _terminal(stream)
    with _read(terminal):
        for block in blocks:
            _print(terminal, block)


def print_screen(screen: Screen, details: bool = False, stream: IO[str] | None = None) -> None:
    """Print what fits on a screen of 25 lines, or all of it.

    Args:
        screen: what a command answers.
        details: print the second part too, and the first one whole.
        stream: where to; standard output by default.
    """
    if details:
        print_blocks(screen.blocks, stream)
        return
    terminal = _terminal(stream)
    with _read(terminal):
        _print_first(terminal, screen)


def _print_first(terminal: Console, screen: Screen) -> None:
    """Print what fits on a screen, and say how much is left out."""
    left_out = 0
    room = LINES - 1 - sum(_height(terminal, block) for block in screen.first if not _optional(block))
    for block in screen.first:
        if not _optional(block):
            _print(terminal, block)
            continue
        for line in _lines(block):
            wrapped = _brief(_wrapped(line, terminal.width), terminal.width)
            if len(wrapped) > room:
                left_out += 1
                continue
            room -= len(wrapped)
            _print_lines(terminal, wrapped)
    if screen.more or left_out:
        _print_lines(terminal, _brief(_wrapped(_more(screen.more, left_out), terminal.width), terminal.width, 1))


def _optional(block: Block) -> bool:
    return isinstance(block, Notes) and block.optional


def screen_text(screen: Screen, details: bool = False) -> str:
    """The screen as text, 80 columns wide."""
    stream = StringIO()
    print_screen(screen, details, stream)
    return stream.getvalue().rstrip("\n")


def _more(content: str, left_out: int) -> str:
    """The last line of a screen."""
    notes = f"{left_out} more note{'s' * (left_out > 1)}" if left_out else ""
    return f"--details: {'; '.join(text for text in (notes, content) if text)}"


class _Console(Console):
    """A terminal whose reader may leave without an end of the command."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError


@contextmanager
def _read(terminal: Console) -> Iterator[None]:
    """Print as long as somebody reads: `| head` has seen enough, files that were asked for are still written."""
    try:
        yield
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), terminal.file.fileno())


def _terminal(stream: IO[str] | None) -> Console:
    if isinstance(stream, StringIO):
        return _Console(file=stream, width=COLUMNS, force_terminal=False, color_system=None)
    terminal = _Console(file=stream)
    return terminal if terminal.width >= _FEWEST else _Console(file=stream, width=_FEWEST)


def _print(terminal: Console, block: Block) -> None:
    if isinstance(block, Table):
        if block.title:
            terminal.print(Text(printable(block.title), style="table.title"))
        for grid in _grids(block, terminal.width):
            terminal.print(grid)
    else:
        _print_lines(terminal, [part for line in _lines(block) for part in _wrapped(line, terminal.width)])


def _lines(block: Block) -> Sequence[str]:
    """Lines of what is no table; figures and code are for pages."""
    if isinstance(block, Notes):
        return block.lines
    return (block.words,) if isinstance(block, Banner | Words) else ()


def _print_lines(terminal: Console, lines: Sequence[str]) -> None:
    for line in lines:
        terminal.print(Text(printable(line)), soft_wrap=True)


def _wrapped(line: str, width: int) -> list[str]:
    """A line as wide as the terminal; an item of a list stays to the right of its dash."""
    indent = " " * (len(line) - len(line.lstrip(" -")))
    return textwrap.wrap(line, width, subsequent_indent=indent, break_on_hyphens=False) or [""]


def _brief(lines: list[str], width: int, most: int = _LONGEST) -> list[str]:
    """First lines of a cell, the last one cut at a word; where one is left out, that is seen."""
    if len(lines) <= most:
        return lines
    last, room = lines[most - 1], width - len(_CUT)
    if len(last) > room:  # at a word: half a number is another one
        last = last[: room + 1].rpartition(" ")[0] or last[:room]
    return [*lines[: most - 1], f"{last.rstrip(' ,;:')}{_CUT}"]


def _height(terminal: Console, block: Block) -> int:
    """Lines that a block takes."""
    if isinstance(block, Table):
        title = len(textwrap.wrap(block.title, terminal.width))
        return title + sum(len(terminal.render_lines(grid)) for grid in _grids(block, terminal.width))
    return sum(len(_wrapped(line, terminal.width)) for line in _lines(block))


def _grids(table: Table, width: int) -> list[Grid]:
    """The table, in parts that repeat the names of its rows where it is too wide."""
    names = next((k for k, column in enumerate(table.columns) if column.numeric), len(table.columns))
    names = min(max(names, 1), len(table.columns) - 1) if len(table.columns) > 1 else 1
    parts: list[list[int]] = [[*range(names)]]
    for k in range(names, len(table.columns)):
        if len(parts[-1]) > names and _width(table, [*parts[-1], k]) > width:
            parts.append([*range(names)])
        parts[-1].append(k)
    return [_grid(table, part, _width(table, part) > width) for part in parts]


def _width(table: Table, part: Sequence[int]) -> int:
    """Columns of the terminal that those of the table need."""
    between = 3 if table.style == "roomy" else 2 if table.style == "bare" else 1
    needed = 0
    for k in part:
        cells = [table.columns[k].heading, *(str(row[k]) for row in table.rows)]
        widest = max(map(cell_len, cells))
        needed += (min(widest, _NARROWEST) if table.columns[k].folds else widest) + between
    return needed + 1


def _grid(table: Table, part: Sequence[int], folds: bool) -> Grid:
    """Some columns as rich prints them; ``folds``: even they are too wide."""
    grid = Grid(
        box=None if table.style in ("bare", "tight", "quantities") else box.SIMPLE_HEAD,
        padding=_padding(table.style),
        show_header=table.style != "bare",
    )
    columns: list[Column] = [table.columns[k] for k in part]
    for column in columns:
        wraps = column.folds or folds
        grid.add_column(
            Text(printable(column.heading)),
            justify="right" if column.numeric else "left",
            overflow="fold",
            no_wrap=not wraps,
        )
    for row in table.rows:
        cells: list[Cell] = [row[k] for k in part]
        grid.add_row(*(Text(printable(str(cell))) for cell in cells), end_section=row[0] in table.ends)
    return grid


def _padding(style: str) -> tuple[int, int] | tuple[int, int, int, int]:
    if style in ("tight", "quantities"):
        return 0, 1, 0, 0
    return (0, 1) if style in ("roomy", "bare") else (0, 0)
