"""Reports: their parts as values, printed on a terminal, and as one self-contained HTML file with its figures.

The page is what ``templates/page.html`` makes of the parts. Texts are escaped where they enter; on a terminal none
is taken for markup.
"""

from __future__ import annotations

import html
import os
import re
import sys
import textwrap
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import cache, cached_property
from shutil import get_terminal_size
from typing import IO, TYPE_CHECKING, Literal, NamedTuple

from rich.cells import cell_len
from rich.console import Console
from rich.table import Table as Grid
from rich.text import Text as Line

from ... import __version__
from ...common.errors import InputError, printable
from ...common.versions import versions
from .figures import Figure, figure_bytes

if TYPE_CHECKING:
    from jinja2 import Template

LINES, COLUMNS = 25, 80
"""A screen."""
_NUMBER = re.compile(r"[<>≤~]?[-+−±]?\.?\d[\d.,:e+-]*(±\S+)?( ?%| to .*|$)|-$|not visible$")
_WORDS = 24  # letters: longer texts fold
_FEWEST = 20  # columns of the narrowest terminal that is laid out
_NARROWEST = 14  # letters that a column of words needs at least
_MERGED = 24  # letters of words that stand beside several rows


@dataclass(frozen=True, eq=False)
class Table:
    """Rows under headings; the first cell names its row, and columns of numbers are set to the right."""

    title: str
    headings: Sequence[str]
    rows: Sequence[tuple[str, ...]]
    ends: Collection[str] = ()  # names of the rows after which a section of the table ends
    merged: bool = False  # the last column's words hold for their whole section, and stand there once
    spare: Collection[str] = ()  # names of rows that the first screen leaves out
    looks: list[Literal["number", "words", "name"]] = field(init=False, default_factory=list)
    """The look of each column: of numbers, of words that fold, of short texts."""
    sections: list[list[tuple[str, ...]]] = field(init=False, default_factory=list)  # the rows, parted at the ends

    def __post_init__(self) -> None:
        """Every row fits the headings."""
        if any(len(row) != len(self.headings) for row in self.rows):
            raise ValueError(f"{self.title!r}: every row needs {len(self.headings)} cells")
        for k in range(len(self.headings)):
            texts = [row[k] for row in self.rows if row[k]]
            number, long = k and texts and all(map(_NUMBER.match, texts)), any(len(text) > _WORDS for text in texts)
            self.looks.append("number" if number else "words" if long else "name")
        for before, row in zip([None, *self.rows], self.rows, strict=False):
            if before is None or before[0] in self.ends:
                self.sections.append([])
            self.sections[-1].append(row)


class Text(NamedTuple):
    """A paragraph; a verdict, by its ``level``; or, of pages alone, a heading in a section or text to be copied."""

    words: str
    heading: bool = False
    level: str = ""
    copied: str | None = None  # identifier of a text to be copied


class Notes(NamedTuple):
    """Lines of words but empty ones, a list in a page; a first screen shows as many ``optional`` ones as fit."""

    lines: Sequence[str]
    optional: bool = False


class Drawing(NamedTuple):
    """A figure of a page, which is drawn for it; ``text``: the caption for those who do not see it."""

    name: str
    caption: str
    figure: Figure
    text: str = ""


class Pair(NamedTuple):
    """Blocks side by side where there is room."""

    left: Sequence[Block]
    right: Sequence[Block]


@dataclass(frozen=True, eq=False)
class OnPage:
    """Blocks that only a page shows: they are made when there is one; below a summary, if any, to be opened."""

    make: Callable[[], Sequence[Block]]
    summary: str = ""
    opened: bool = False

    @cached_property
    def blocks(self) -> Sequence[Block]:
        """The blocks, made once for the page and all files of figures."""
        return self.make()


Block = Table | Text | Notes | Drawing | Pair | OnPage


class Section(NamedTuple):
    """A part of a report: its identifier, its heading, and what stands in it."""

    name: str
    title: str
    blocks: Sequence[Block]


@dataclass(frozen=True)
class Report:
    """An answer as it is shown: the same blocks make its screen and its page."""

    title: str
    first: Sequence[Block]  # what to do, on a screen of 25 lines of 80 columns, and at the head of the page
    sections: Sequence[Section] = ()  # what it rests on: on a terminal the details
    more: str = ""  # what the details hold
    subtitle: str = ""
    notes: Sequence[str] = ()  # on the data, at the end

    def drawings(self) -> Iterator[Drawing]:
        """Every figure, in order."""
        blocks = [*self.first, *(block for section in self.sections for block in section.blocks)]
        return (block for block in leaves(blocks, page=True) if isinstance(block, Drawing))


def leaves(blocks: Iterable[Block], page: bool = False) -> Iterator[Table | Text | Notes | Drawing]:
    """Blocks that hold no others, in order: those of a terminal, or all that a ``page`` shows, made if need be."""
    for block in blocks:
        match block:
            case Pair():
                yield from leaves((*block.left, *block.right), page)
            case OnPage():
                yield from leaves(block.blocks if page else (), page)
            case _ if page:
                yield block
            case Table() | Notes() | Text(heading=False, copied=None):
                yield block


def print_report(report: Report, details: bool = False, stream: IO[str] | None = None) -> None:
    """Print what fits on a screen of 25 lines and how much is left out, or all of it, with ``details``."""
    width, stream = max(get_terminal_size((COLUMNS, LINES)).columns, _FEWEST), stream or sys.stdout
    try:
        stream.writelines(f"{line}\n" for line in screen_lines(report, details, width))
        stream.flush()
    except BrokenPipeError:  # `| head` has seen enough, files are still written
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def screen_lines(report: Report, details: bool = False, width: int = COLUMNS) -> list[str]:
    """Lines of the screen, or with ``details`` of all that a terminal shows."""
    blocks = list(leaves(report.first))
    if details:
        for section in report.sections:
            if inside := list(leaves(section.blocks)):
                blocks += [Text(""), Text(section.title.upper()), *inside]
        blocks += [Text(""), Notes(report.notes)] if report.notes else []
        return [printable(line) for block in blocks for line in _lines(block, width)]
    shown = [_lines(block, width, first=True) for block in blocks]
    room, left_out, said = LINES - 1 - sum(map(len, shown)), 0, set[str]()
    for lines, block in zip(shown, blocks, strict=True):
        for line in filter(None, block.lines) if isinstance(block, Notes) and block.optional else ():
            if line in said:
                continue
            said.add(line)
            wrapped = _wrapped(line, width)
            if len(wrapped) > room:
                left_out += 1
                continue
            room -= len(wrapped)
            lines += wrapped
    notes = [f"{left_out} more note{'s' * (left_out > 1)}"] if left_out else []
    if notes or report.more:
        shown.append(_wrapped(f"--details: {'; '.join([*notes, *filter(None, [report.more])])}", width)[:1])
    return [printable(line) for lines in shown for line in lines]


def _lines(table: Table | Text | Notes | Drawing, width: int, first: bool = False) -> list[str]:
    """Lines of a block; on the ``first`` screen without spare rows and what is shown there as far as it fits."""
    if isinstance(table, Notes):
        told = [] if table.optional and first else filter(None, table.lines)
        return [part for line in told for part in _wrapped(line, width)]
    if not isinstance(table, Table):
        return _wrapped(table.words, width) if isinstance(table, Text) else []
    rows = list[tuple[str, ...]]()
    for whole in table.sections:
        section = [row for row in whole if not (first and row[0] in table.spare)]
        count = len(section)
        if not table.merged or count <= 1:
            rows += section
            continue
        # The last words stand beside all rows, behind a bracket.
        words = textwrap.wrap(section[0][-1], _MERGED) or [""]
        words = [*words[: count - 1], " ".join(words[count - 1 :])] + [""] * (count - len(words))
        marks = ["┐", *["│"] * (count - 2), "┘"]
        rows += [(*row[:-1], f"{mark} {text}") for row, mark, text in zip(section, marks, words, strict=False)]
    names = next((k for k, look in enumerate(table.looks) if look == "number"), len(table.headings))
    names, widths = max(min(names, len(table.headings) - 1), 1), list[int]()
    for k, (heading, look) in enumerate(zip(table.headings, table.looks, strict=True)):
        widest = max(map(cell_len, (heading, *(row[k] for row in rows))))
        widths.append(1 + (min(widest, _NARROWEST) if look == "words" else widest))
    # Columns in parts, one below the other, that repeat the names of the rows where the table is too wide.
    parts: list[list[int]] = [[*range(names)]]
    for k in range(names, len(table.headings)):
        if len(parts[-1]) > names and sum(widths[part] for part in (*parts[-1], k)) >= width:
            parts.append([*range(names)])
        parts[-1].append(k)
    lines, console = textwrap.wrap(printable(table.title), width), Console(width=width, color_system=None)
    for part in parts:
        folds = sum(widths[k] for k in part) >= width  # even a part of the columns is too wide
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


def _wrapped(line: str, width: int) -> list[str]:
    """A line as wide as the terminal; an item of a list stays to the right of its dash."""
    indent = " " * (len(line) - len(line.lstrip(" -")))
    return textwrap.wrap(line, width, subsequent_indent=indent, break_on_hyphens=False) or [""]


def page_html(
    report: Report, command: str, files: Sequence[tuple[str, str, str]] = (), settings: Mapping[str, str] = {}
) -> str:
    """The file's text, with all that repeats it: the command as typed, files that were read, settings, versions.

    ``files``: role, name and SHA-256 checksum of each. By SOURCE_DATE_EPOCH the same input gives the same file.
    """
    fixed = os.environ.get("SOURCE_DATE_EPOCH")
    try:
        date = datetime.fromtimestamp(int(fixed), UTC) if fixed else datetime.now(UTC)
    except (ValueError, OverflowError, OSError):
        raise InputError(f"SOURCE_DATE_EPOCH {fixed!r} is not a time: give seconds since 1970") from None
    parts = (
        ("Files that were read", ("", "file", "SHA-256"), files),
        ("Settings", ("", "value"), list(settings.items())),
        ("Versions", ("", "version"), list(versions().items())),
    )
    data = [Notes(report.notes), *(Table(title, headings, rows) for title, headings, rows in parts if rows)]
    day = date.strftime("%Y-%m-%d %H:%M UTC")
    return _template().render(report=report, command=command, data=data, day=day, version=__version__)


def blocks_html(blocks: Sequence[Block]) -> str:
    """Some blocks alone."""
    return _template().render(report=None, blocks=blocks)


@cache
def _template() -> Template:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(loader=PackageLoader(str(__package__)), autoescape=True, undefined=StrictUndefined)
    environment.trim_blocks = environment.lstrip_blocks = True
    environment.filters["svg"] = _inline_svg
    return environment.get_template("page.html")


def _inline_svg(drawing: Drawing) -> str:
    """The drawing alone, its text as text in the reader's fonts, with a description for those who do not see it."""
    drawn = figure_bytes(drawing.figure, name=drawing.name).decode()
    text = re.sub(r"^.*?(?=<svg\b)|<metadata>.*?</metadata>\s*", "", drawn, flags=re.DOTALL)
    text = re.sub(r' xmlns(?::xlink)?="[^"]*"', "", text).replace("xlink:href", "href")  # HTML needs no address
    text = re.sub(r"(font: [^;\"]*?)'DejaVu Sans'[^;\"]*", r"\1sans-serif", text)
    # Identifiers are hashes that only one figure has; those that nothing refers to go.
    used = set(re.findall(r'(?:href="#|url\(#)([^")]+)', text))
    text = re.sub(r' id="([^"]+)"', lambda m: m[0] if m[1] in used else "", text)
    text = re.sub(r' (?:width|height)="[\d.]+pt"', "", text, count=2)
    text = text.replace("<svg ", f'<svg role="img" aria-labelledby="{drawing.name}-text" ', 1)
    head, _, rest = text.partition(">")
    title = f'<title id="{drawing.name}-text">{html.escape(drawing.text or drawing.caption)}</title>'
    return f"{head}>{title}{rest}"  # whose names of files matplotlib has escaped
