"""Words and numbers of a text apart: the words to be the same exactly, the numbers as far as they were printed."""

import re
from html.parser import HTMLParser
from typing import NamedTuple

MARK = "#"
_NUMBER = re.compile(r"(?<![A-Za-z_0-9.])[-+]?[0-9]+(?:\.[0-9]+)?(?:[eE][-+]?[0-9]+)?")
_LOCAL = (
    (re.compile(r"[^\s\"'()=,;]*/(?=(?:model/robots|examples)/)"), ""),  # where the package lies
    (re.compile(r"\b[0-9a-f]{64}\b"), "@"),  # checksums
    (re.compile(r"\b[0-9]+\.[0-9]+\.[0-9]+(?:\.?[a-z]+[0-9]*)*\b|\bnot installed\b"), "@"),  # versions
    (re.compile(r"─{2,}"), "──"),  # as wide as the numbers
    (re.compile(r"\b[0-9]{4}-[0-9]{2}-[0-9]{2}(?:[T ][0-9]{2}:[0-9]{2}(?::[0-9]{2})?)?"), "@"),  # dates
)
"""What differs from one machine or day to the next."""
_FINE = 9
"""A number with more digits than this was not rounded for reading, and keeps noise of the arithmetic."""
_NOISE = 1e-9
_ZERO = 1e-12


class Text(NamedTuple):
    """A text taken apart."""

    words: list[str]
    """Its lines, with a mark for each number and single spaces."""
    numbers: list[str]
    """As they stand, in reading order."""


def take_apart(text: str) -> Text:
    """Words and numbers of a text, without what is of one machine or day alone."""
    for pattern, mark in _LOCAL:
        text = pattern.sub(mark, text)
    numbers = _NUMBER.findall(text)
    lines = (" ".join(line.split()) for line in _NUMBER.sub(MARK, text).splitlines())
    return Text([line for line in lines if line], numbers)


def same_printed(old: str, new: str) -> bool:
    """Whether two printed numbers differ by at most one unit of the last digit; whole numbers not at all."""
    if old == new:
        return True
    was, now = float(old), float(new)
    if not (_rounded(old) or _rounded(new)):
        return was == now
    allowed = max(_unit(old), _unit(new), _ZERO)
    if _digits(old) > _FINE:
        allowed = max(allowed, _NOISE * max(1.0, abs(was)))
    return abs(now - was) <= 1.000001 * allowed


def _rounded(number: str) -> bool:
    return "." in number or "e" in number.lower()


def _unit(number: str) -> float:
    """Unit of the last printed digit."""
    digits, _, exponent = number.lower().partition("e")
    return float(10.0 ** (int(exponent or 0) - len(digits.partition(".")[2])))


def _digits(number: str) -> int:
    return len(number.lower().partition("e")[0].replace(".", "").lstrip("+-0"))


def text_of_html(page: str) -> str:
    """What a reader sees in words, a block a line: no drawings, styles or scripts."""
    reader = _Reader()
    reader.feed(page)
    return "".join(reader.pieces)


class _Reader(HTMLParser):
    _HIDDEN = frozenset({"svg", "style", "script"})
    _INLINE = frozenset({"a", "abbr", "b", "code", "em", "i", "span", "strong", "sub", "sup", "th", "td"})

    def __init__(self) -> None:
        super().__init__()
        self.pieces: list[str] = []
        self._hidden = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._hidden += tag in self._HIDDEN
        self.pieces.append(" " if tag in self._INLINE else "\n")

    def handle_endtag(self, tag: str) -> None:
        self._hidden -= tag in self._HIDDEN
        self.pieces.append(" " if tag in self._INLINE else "\n")

    def handle_data(self, data: str) -> None:
        if not self._hidden:
            self.pieces.append(" ".join(data.split("\n")))
