"""Parts of a report as values: ``render`` prints them, and makes pages of them by templates."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Literal, NamedTuple

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_NUMBER = re.compile(r"[<>≤~]?[-+−±]?\.?\d[\d.,:e+-]*(±\S+)?( ?%| to .*|$)|-$|not visible$")
_WORDS = 24  # letters: longer texts fold


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


class Notes:
    """Lines of words but empty ones, a list in a page; a first screen shows as many ``optional`` ones as fit."""

    def __init__(self, lines: Iterable[str], optional: bool = False) -> None:
        self.lines, self.optional = list(filter(None, lines)), optional


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
        """The blocks, made once."""
        return self.make()


@dataclass(frozen=True, eq=False)
class Drawing:
    """A figure of a page, drawn when it is first looked at; ``text``: the caption for those who do not see it."""

    name: str
    caption: str
    draw: Callable[[], Figure]
    text: str = ""

    @cached_property
    def figure(self) -> Figure:
        """The figure, made once for all its files."""
        return self.draw()


Block = Table | Text | Notes | Pair | OnPage | Drawing


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
        left = [*self.first, *(block for section in self.sections for block in section.blocks)]
        while left:
            block = left.pop(0)
            if isinstance(block, Drawing):
                yield block
            elif isinstance(block, Pair):
                left[:0] = [*block.left, *block.right]
            elif isinstance(block, OnPage):
                left[:0] = block.blocks
