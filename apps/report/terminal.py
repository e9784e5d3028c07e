"""Reports on a terminal: tables by rich, lines as they are; nothing is wider than the terminal.

What is printed is text: no letter in it is taken for markup.
"""

import os
import textwrap
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from io import StringIO
from typing import IO

from rich.cells import cell_len
from rich.console import Console
from rich.table import Table as Grid
from rich.text import Text as Line

from ...common.errors import printable
from .blocks import Banner, Block, Notes, Pair, Report, Table, Text

LINES, COLUMNS = 25, 80
"""A screen."""
_NARROWEST = 14  # letters that a column of words needs at least
_MERGED = 24  # letters of words that stand beside several rows
_LONGEST = 3  # lines of one remark that the first screen shows
_CUT = " .."
_FEWEST = 20  # columns of the narrowest terminal that is laid out


def print_blocks(blocks: Sequence[Block], stream: IO[str] | None = None) -> None:
    """Print tables and lines; a table wider than the terminal is printed in parts, one below the other."""
    with _opened(stream) as terminal:
        for block in printed(blocks):
            _print_lines(terminal, _lines(terminal, block, ()))


def print_report(report: Report, details: bool = False, stream: IO[str] | None = None) -> None:
    """Print what fits on a screen of 25 lines and how much is left out, or all of it, with ``details``."""
    blocks = list(printed(report.first))
    if details:
        for section in report.sections:
            if any(printed(section.blocks)):
                blocks += [Notes(["", section.title.upper()]), *printed(section.blocks)]
        print_blocks([*blocks, *([Notes(["", *report.notes])] if report.notes else [])], stream)
        return
    with _opened(stream) as terminal:
        left_out, width = 0, terminal.width
        shown = {
            id(block): _lines(terminal, block, block.spare if isinstance(block, Table) else ())
            for block in blocks
            if not (isinstance(block, Notes) and block.optional)
        }
        room = LINES - 1 - sum(map(len, shown.values()))
        for block in blocks:
            _print_lines(terminal, shown.get(id(block), ()))
            for line in block.lines if isinstance(block, Notes) and block.optional else ():
                wrapped = _brief(_wrapped(line, width), width)
                if len(wrapped) > room:
                    left_out += 1
                    continue
                room -= len(wrapped)
                _print_lines(terminal, wrapped)
        notes = f"{left_out} more note{'s' * (left_out > 1)}" if left_out else ""
        if notes or report.more:
            last = f"--details: {'; '.join(text for text in (notes, report.more) if text)}"
            _print_lines(terminal, _brief(_wrapped(last, width), width, 1))


def screen_text(report: Report, details: bool = False) -> str:
    """The screen as text, 80 columns wide."""
    stream = StringIO()
    print_report(report, details, stream)
    return stream.getvalue().rstrip("\n")


def printed(blocks: Sequence[Block]) -> Iterator[Table | Text | Notes | Banner]:
    """Blocks that are text; figures, headings and what is to be copied are for pages."""
    for block in blocks:
        if isinstance(block, Pair):
            yield from printed((*block.left, *block.right))
        elif isinstance(block, Table | Notes | Banner) or (isinstance(block, Text) and not block.heading):
            yield block


class _Console(Console):
    """A terminal whose reader may leave without an end of the command."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError


@contextmanager
def _opened(stream: IO[str] | None) -> Iterator[Console]:
    """A terminal, written as long as somebody reads: `| head` has seen enough, files are still written."""
    terminal = _Console(file=stream)
    if isinstance(stream, StringIO):
        terminal = _Console(file=stream, width=COLUMNS, force_terminal=False, color_system=None)
    elif terminal.width < _FEWEST:
        terminal = _Console(file=stream, width=_FEWEST)
    try:
        yield terminal
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), terminal.file.fileno())


def _print_lines(terminal: Console, lines: Sequence[str]) -> None:
    for line in lines:
        terminal.print(Line(printable(line)), soft_wrap=True)


def _lines(terminal: Console, block: Table | Text | Notes | Banner, spare: Collection[str]) -> list[str]:
    if isinstance(block, Table):
        return _table_lines(terminal, block, spare)
    lines = block.lines if isinstance(block, Notes) else (block.words,)
    return [part for line in lines for part in _wrapped(line, terminal.width)]


def _wrapped(line: str, width: int) -> list[str]:
    """A line as wide as the terminal; an item of a list stays to the right of its dash."""
    indent = " " * (len(line) - len(line.lstrip(" -")))
    return textwrap.wrap(line, width, subsequent_indent=indent, break_on_hyphens=False) or [""]


def _brief(lines: list[str], width: int, most: int = _LONGEST) -> list[str]:
    """First lines of a remark, the last one cut at a word; where one is left out, that is seen."""
    if len(lines) <= most:
        return lines
    last, room = lines[most - 1], width - len(_CUT)
    if len(last) > room:  # at a word: half a number is another one
        last = last[: room + 1].rpartition(" ")[0] or last[:room]
    return [*lines[: most - 1], f"{last.rstrip(' ,;:')}{_CUT}"]


def _table_lines(terminal: Console, table: Table, spare: Collection[str]) -> list[str]:
    """Title and rows, in parts that repeat the names of the rows where the table is too wide."""
    parted = table.sections(spare)
    rows = [row for section in parted for row in (_merged(section) if table.merged else section)]
    names = next((k for k, look in enumerate(table.looks) if look == "number"), len(table.headings))
    names = min(max(names, 1), len(table.headings) - 1) if len(table.headings) > 1 else 1
    parts: list[list[int]] = [[*range(names)]]
    for k in range(names, len(table.headings)):
        if len(parts[-1]) > names and _width(table, rows, [*parts[-1], k]) > terminal.width:
            parts.append([*range(names)])
        parts[-1].append(k)
    lines = textwrap.wrap(printable(table.title), terminal.width)
    for part in parts:
        folds = _width(table, rows, part) > terminal.width  # even a part of the columns is too wide
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
        lines += ["".join(piece.text for piece in line).rstrip() for line in terminal.render_lines(grid, pad=False)]
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
