"""How a text file is laid out."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from ...common.errors import InputError

DELIMITERS = {"comma": ",", "tab": "\t", "semicolon": ";", "space": None}
"""What separates cells; None stands for any white space."""


@dataclass(frozen=True)
class Layout:
    """The layout of a text file, and what else a reader must be told.

    Attributes:
        delimiter: of ``DELIMITERS``; empty: tab for .tsv, comma otherwise.
        decimal: "." or ",".
        names: names of the columns in the order of the file, instead of a header line.
        skip: lines before the header, or before the numbers where ``names`` are given.
        per_row: numbers of one sample where the file has one number a line; 0 for a file with rows.
        topic: of a ROS bag; empty where there is only one with joint states.
    """

    delimiter: str = ""
    decimal: str = "."
    names: tuple[str, ...] = ()
    skip: int = 0
    per_row: int = 0
    topic: str = ""

    def __post_init__(self) -> None:
        """Refuse layouts without a meaning."""
        if self.delimiter and self.delimiter not in DELIMITERS:
            raise ValueError(f"delimiter {self.delimiter!r}: give one of {', '.join(DELIMITERS)}")
        if self.decimal not in (".", ","):
            raise ValueError(f"decimal {self.decimal!r}: give '.' or ','")
        if self.decimal == "," and self.delimiter in ("", "comma"):
            raise ValueError("decimal ',' needs a delimiter other than comma")
        if self.skip < 0 or self.per_row < 0:
            raise ValueError("skip_lines and numbers_per_row must not be negative")
        if self.per_row and self.per_row != len(self.names):
            raise ValueError(f"numbers_per_row is {self.per_row}, but {len(self.names)} names are given")
        twice = sorted({name for name in self.names if self.names.count(name) > 1})
        if twice:
            raise ValueError(f"name {twice[0]!r} is given twice")


def spread(names: Sequence[str]) -> tuple[str, ...]:
    """Names with ranges written out: "q1..6" is q1 to q6.

    Raises:
        InputError: for a range that runs backwards.
    """
    result: list[str] = []
    for name in names:
        match = re.fullmatch(r"(.*?)(\d+)\.\.(\d+)", name)
        if not match:
            result.append(name)
            continue
        first, last = int(match[2]), int(match[3])
        if not first <= last <= first + 1000:
            raise InputError(f"names {name!r}: a range must rise, as in q1..6")
        result += [f"{match[1]}{k}" for k in range(first, last + 1)]
    return tuple(result)
