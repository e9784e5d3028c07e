"""Reports on a terminal: tables by rich, lines as they are; nothing is wider than the terminal.

What is printed is text: no letter in it is taken for markup.
"""

import os
import sys
import textwrap
from collections.abc import Collection, Iterator, Sequence
from shutil import get_terminal_size
from typing import IO

from rich.cells import cell_len
from rich.console import Console
from rich.table import Table as Grid
from rich.text import Text as Line

from ...common.errors import printable
from .blocks import Block, Notes, Pair, Report, Table, Text

LINES, COLUMNS = 25, 80
"""A screen."""
_NARROWEST = 14  # letters that a column of words needs at least
_MERGED = 24  # letters of words that stand beside several rows

_FEWEST = 20  # columns of the narrowest terminal that is laid out


def print_blocks(blocks: Sequence[Block], stream: IO[str] | None = None) -> None:
    """Print tables and lines; a table wider than the terminal is printed in parts, one below the other."""
    width = _columns()
    _print([line for block in printed(blocks) for line in _lines(block, width)], stream)


def print_report(report: Report, details: bool = False, stream: IO[str] | None = None) -> None:
    """Print what fits on a screen of 25 lines and how much is left out, or all of it, with ``details``."""
    _print(_screen(report, details, _columns()), stream)


def screen_text(report: Report, details: bool = False) -> str:
    """The screen as text, 80 columns wide."""
    return "\n".join(map(printable, _screen(report, details, COLUMNS))).rstrip("\n")


def _screen(report: Report, details: bool, width: int) -> list[str]:
    blocks = list(printed(report.first))
    if details:
        for section in report.sections:
            if inside := list(printed(section.blocks)):
                blocks += [Notes(["", section.title.upper()]), *inside]
        blocks += [Notes(["", *report.notes])] if report.notes else []
        return [line for block in blocks for line in _lines(block, width)]
    shown = [_lines(block, width, first=True) for block in blocks]
    room, left_out, said = LINES - 1 - sum(map(len, shown)), 0, set[str]()
    for lines, block in zip(shown, blocks, strict=True):
        for line in block.lines if isinstance(block, Notes) and block.optional else ():
            wrapped = _wrapped(line, width)
            if line in said:
                continue
            said.add(line)
            if len(wrapped) > room:
                left_out += 1
                continue
            room -= len(wrapped)
            lines += wrapped
    notes = [f"{left_out} more note{'s' * (left_out > 1)}"] if left_out else []
    if notes or report.more:
        shown.append(_wrapped(f"--details: {'; '.join([*notes, *filter(None, [report.more])])}", width)[:1])
    return [line for lines in shown for line in lines]


def printed(blocks: Sequence[Block]) -> Iterator[Table | Text | Notes]:
    """Blocks that are text; figures, headings and what is to be copied are for pages."""
    for block in blocks:
        if isinstance(block, Pair):
            yield from printed((*block.left, *block.right))
        elif isinstance(block, Table | Notes) or (isinstance(block, Text) and not block.heading):
            yield block


def _columns() -> int:
    return max(get_terminal_size((COLUMNS, LINES)).columns, _FEWEST)


def _print(lines: Sequence[str], stream: IO[str] | None) -> None:
    """Print as long as somebody reads: `| head` has seen enough, files are still written."""
    stream = stream or sys.stdout
    try:
        stream.writelines(f"{printable(line)}\n" for line in lines)
        stream.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _lines(block: Table | Text | Notes, width: int, first: bool = False) -> list[str]:
    """Lines of a block; on the ``first`` screen without spare rows and what is shown there as far as it fits."""
    if isinstance(block, Table):
        return _table_lines(block, width, block.spare if first else ())
    lines = block.lines if isinstance(block, Notes) else (block.words,)
    optional = isinstance(block, Notes) and block.optional and first
    return [part for line in lines for part in _wrapped(line, width)] if not optional else []


def _wrapped(line: str, width: int) -> list[str]:
    """A line as wide as the terminal; an item of a list stays to the right of its dash."""
    indent = " " * (len(line) - len(line.lstrip(" -")))
    return textwrap.wrap(line, width, subsequent_indent=indent, break_on_hyphens=False) or [""]


def _table_lines(table: Table, width: int, spare: Collection[str]) -> list[str]:
    """Title and rows, in parts that repeat the names of the rows where the table is too wide."""
    parted = table.sections(spare)
    rows = [row for section in parted for row in (_merged(section) if table.merged else section)]
    names = next((k for k, look in enumerate(table.looks) if look == "number"), len(table.headings))
    names = min(max(names, 1), len(table.headings) - 1) if len(table.headings) > 1 else 1
    parts: list[list[int]] = [[*range(names)]]
    for k in range(names, len(table.headings)):
        if len(parts[-1]) > names and _width(table, rows, [*parts[-1], k]) > width:
            parts.append([*range(names)])
        parts[-1].append(k)
    lines, console = textwrap.wrap(printable(table.title), width), Console(width=width, color_system=None)
    for part in parts:
        folds = _width(table, rows, part) > width  # even a part of the columns is too wide
        grid = Grid(box=None, padding=(0, 1, 0, 0), show_header=any(table.headings[k] for k in part))
        for k in part:
            grid.add_column(
                Line(printable(table.headings[k])),
                justify="right" if table.looks[k] == "number" else "left",
                no_wrap=not (table.looks[k] == "words" or folds),
                overflow="fold",
            )
        for row in rows:
            grid.add_row(*(Line(printable(row[k])) for k in part))
            if row[0] in table.ends and row is not rows[-1] and not table.merged:
                grid.add_row()
        lines += ["".join(piece.text for piece in line).rstrip() for line in console.render_lines(grid, pad=False)]
    return lines


def _merged(section: Sequence[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Rows whose last words stand beside all of them, behind a bracket."""
    if len(section) == 1:
        return list(section)
    count = len(section)
    words = textwrap.wrap(section[0][-1], _MERGED) or [""]
    words = [*words[: count - 1], " ".join(words[count - 1 :])] + [""] * (count - len(words))
    marks = ["┐", *["│"] * (count - 2), "┘"]
    return [(*row[:-1], f"{mark} {text}") for row, mark, text in zip(section, marks, words, strict=False)]


def _width(table: Table, rows: Sequence[tuple[str, ...]], part: Sequence[int]) -> int:
    needed = 1
    for k in part:
        widest = max(cell_len(text) for text in (table.headings[k], *(row[k] for row in rows)))
        needed += (min(widest, _NARROWEST) if table.looks[k] == "words" else widest) + 1
    return needed
