"""Tables, words and figures as values; ``terminal`` and ``html`` decide how each looks."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import isfinite
from typing import TYPE_CHECKING, Literal, NamedTuple

from ..numbers import interval_digits

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Spread(NamedTuple):
    """A number and its standard deviation, each with the digits to print."""

    value: str
    sigma: str

    def __str__(self) -> str:
        """Both in one cell."""
        return f"{self.value}±{self.sigma}"


Cell = str | Spread


class Column(NamedTuple):
    """A column of a table: ``numeric`` ones are set to the right, long words fold where it ``folds``."""

    heading: str
    numeric: bool = False
    folds: bool = False


def columns(names: Sequence[str], numbers: Sequence[str] = (), words: Sequence[str] = ()) -> tuple[Column, ...]:
    """Headings of names at the left, of numbers, and of words that fold."""
    return (
        *(Column(heading) for heading in names),
        *(Column(heading, numeric=True) for heading in numbers),
        *(Column(heading, folds=True) for heading in words),
    )


@dataclass(frozen=True, eq=False)
class Table:
    """Rows under headings; the first cell names its row.

    Attributes:
        columns: c of them.
        rows: c cells each.
        ends: names of the rows after which a section of the table ends.
        style: "roomy" with space between columns; "bare" without headings; "plain" of long texts; "quantities" with
            a last column whose words hold for their whole section; "tight" without any line between rows.
    """

    title: str
    columns: tuple[Column, ...]
    rows: Sequence[tuple[Cell, ...]]
    ends: Collection[str] = ()
    style: Literal["", "roomy", "bare", "plain", "quantities", "tight"] = ""

    def __post_init__(self) -> None:
        """Every row fits the headings.

        Raises:
            ValueError: if one does not.
        """
        if any(len(row) != len(self.columns) for row in self.rows):
            raise ValueError(f"{self.title!r}: every row needs {len(self.columns)} cells")

    @property
    def sections(self) -> list[list[tuple[Cell, ...]]]:
        """The rows, parted where sections end."""
        parts: list[list[tuple[Cell, ...]]] = [[]]
        for row in self.rows:
            parts[-1].append(row)
            if row[0] in self.ends:
                parts.append([])
        return [part for part in parts if part]


class Text(NamedTuple):
    """A paragraph, a remark in small print, or a heading within a section."""

    words: str
    kind: Literal["paragraph", "note", "heading"] = "paragraph"


class Notes(NamedTuple):
    """Lines of words: a list in a page, line by line on a terminal.

    Attributes:
        optional: whether a screen shows as many as fit, the first ones first; with the details it shows all.
    """

    lines: Sequence[str]
    optional: bool = False


class Banner(NamedTuple):
    """The verdict: its level, and what it says."""

    level: str
    words: str


class Code(NamedTuple):
    """Text to be copied; ``name``: its identifier in the page."""

    name: str
    text: str


class Details(NamedTuple):
    """Blocks below a summary, to be opened."""

    summary: str
    blocks: Sequence[Block]
    opened: bool = False


class Pair(NamedTuple):
    """Blocks side by side where there is room."""

    left: Sequence[Block]
    right: Sequence[Block]


@dataclass(frozen=True, eq=False)
class Drawing:
    """A figure and what is said about it; it is drawn when it is first looked at.

    Attributes:
        name: of its file and of its place in the page.
        text: what it shows, in words, for those who do not see it.
        draw: makes the figure.
    """

    name: str
    caption: str
    text: str
    draw: Callable[[], Figure]

    @cached_property
    def figure(self) -> Figure:
        """The figure, made once for all its files."""
        return self.draw()


Block = Table | Text | Notes | Banner | Code | Details | Pair | Drawing


class Section(NamedTuple):
    """A part of a page: its identifier, its heading, and what stands in it."""

    name: str
    title: str
    blocks: Sequence[Block]


class Screen(NamedTuple):
    """The output of a command: first what to do, on one screen; the details where they are asked for.

    Attributes:
        first: fits on a terminal of 25 lines of 80 columns.
        details: what it rests on.
        more: what the details hold, in words.
    """

    first: Sequence[Block]
    details: Sequence[Block] = ()
    more: str = ""

    @property
    def blocks(self) -> list[Block]:
        """All of it."""
        return [*self.first, *self.details]


class Page(NamedTuple):
    """A whole report: what leads, then sections; ``subtitle`` and ``foot`` are single lines."""

    title: str
    subtitle: str
    lead: Sequence[Block]
    sections: Sequence[Section]
    foot: str

    def blocks(self) -> Iterator[Block]:
        """Every block, those within others too."""
        yield from _within(self.lead)
        for section in self.sections:
            yield from _within(section.blocks)

    def drawings(self) -> list[Drawing]:
        """Every figure, in order."""
        return [block for block in self.blocks() if isinstance(block, Drawing)]


def tables_of(blocks: Iterable[Block]) -> list[Table]:
    """The tables among blocks, in order."""
    return [block for block in blocks if isinstance(block, Table)]


def _within(blocks: Iterable[Block]) -> Iterator[Block]:
    for block in blocks:
        yield block
        if isinstance(block, Pair):
            yield from _within((*block.left, *block.right))
        elif isinstance(block, Details):
            yield from _within(block.blocks)


def with_sigma(value: float, sigma: float) -> Cell:
    """Two digits of sigma, the value to the same place."""
    if not isfinite(sigma) or sigma <= 0.0:
        return f"{value:.6g}"
    digits = interval_digits(2.0 * sigma)
    return Spread(f"{value:.{digits}f}", f"{sigma:.{digits}f}")
