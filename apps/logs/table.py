"""What every reader gives: named columns of numbers; and how a text file is laid out."""

import dataclasses
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from msgspec import Meta, field
from msgspec.structs import force_setattr

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.schema import Table

_HUGE = 1e30  # a time in nanoseconds is 2e18
DELIMITERS = {"comma": ",", "tab": "\t", "semicolon": ";", "space": None}
"""What separates cells; None stands for any white space."""

Texts = str | tuple[str, ...]
"""One text stands for a list of it."""
_Count = Annotated[int, Meta(ge=0)]


@dataclass(frozen=True)
class RawLog:
    """A log that is open for reading, its numbers as they stand there.

    Attributes:
        path: the file or folder.
        names: names of all its columns.
        read: gives all rows of the columns that are asked for, in that order.
        place: tells where a row stands, "line 7"; rows count from 0.
        joints: names of joints, where the format has them.
        units: of columns, where the file names them.
        notes: what a user should know about how it was read; after its rows were read, about these too.
    """

    path: Path
    names: tuple[str, ...]
    read: Callable[[Sequence[str]], Array]
    place: Callable[[int], str] = lambda row: f"row {row + 1}"
    joints: tuple[str, ...] = ()
    units: Mapping[str, str] = dataclasses.field(default_factory=dict)
    notes: Callable[[], tuple[str, ...]] = tuple

    def whole(self, columns: Sequence[str]) -> Array:
        """All rows of the columns, rows x ``len(columns)``.

        Raises:
            InputError: says where a number stands that is not finite, or larger than any time, place or torque.
        """
        values = np.ascontiguousarray(self.read(columns))
        good = np.abs(values) < _HUGE
        if not good.all():
            row, column = np.argwhere(~good)[0]
            fault = "too large a number" if np.isfinite(values[row, column]) else "not a finite number"
            raise InputError(
                f"{self.path}: {self.place(int(row))}, column {columns[column]!r}: {values[row, column]} is "
                f"{fault}: mend or remove the row"
            )
        return values


class Layout(Table, frozen=True):
    """The layout of a text file, and what else a reader must know.

    Attributes:
        delimiter: of ``DELIMITERS``; empty: it is found out.
        decimal: "." or ","; empty: it is found out.
        names: names of the columns in the order of the file, instead of a header line; "q1..6" stands for six.
        skip: lines before the header, or before the numbers where ``names`` are given.
        per_row: numbers of one sample where the file has one number a line; 0 for a file with rows.
        topic: of a ROS bag; empty where there is only one with joint states.
    """

    delimiter: str = ""
    decimal: str = ""
    names: Texts = ()
    skip: _Count = field(default=0, name="skip_lines")
    per_row: _Count = field(default=0, name="numbers_per_row")
    topic: str = ""

    def __post_init__(self) -> None:
        """Refuse layouts without a meaning."""
        force_setattr(self, "names", spread(self.names))
        if self.delimiter and self.delimiter not in DELIMITERS:
            raise ValueError(f"delimiter {self.delimiter!r}: give one of {', '.join(DELIMITERS)}")
        if self.decimal not in ("", ".", ","):
            raise ValueError(f"decimal {self.decimal!r}: give '.' or ','")
        if self.decimal == "," and self.delimiter == "comma":
            raise ValueError("decimal ',' needs a delimiter other than comma")
        if self.per_row and self.per_row != len(self.names):
            raise ValueError(f"numbers_per_row is {self.per_row}, but {len(self.names)} names are given")
        if repeated(self.names):
            raise ValueError(f"name {repeated(self.names)!r} is given twice")


def repeated(names: Sequence[str]) -> str:
    """A name that stands there twice; empty if there is none."""
    return min((name for name in names if names.count(name) > 1), default="")


def listed(names: Texts) -> tuple[str, ...]:
    """Names of which a single one may stand alone."""
    return (names,) if isinstance(names, str) else tuple(names)


def spread(names: Texts) -> tuple[str, ...]:
    """Names with ranges written out: "q1..6" is q1 to q6.

    Raises:
        InputError: for a range that runs backwards.
    """
    result: list[str] = []
    for name in listed(names):
        match = re.fullmatch(r"(.*?)(\d+)\.\.(\d+)", name)
        if not match:
            result.append(name)
            continue
        first, last = int(match[2]), int(match[3])
        if not first <= last <= first + 1000:
            raise InputError(f"names {name!r}: a range must rise, as in q1..6")
        result += [f"{match[1]}{k}" for k in range(first, last + 1)]
    return tuple(result)


def extra(module: str, content: str) -> Any:
    """Import a library that only some formats need, of the extra ``dynident[logs]``.

    Raises:
        InputError: if it is not installed.
    """
    try:
        return import_module(module)
    except ImportError:
        package = module.split(".")[0]
        raise InputError(f"reading {content} needs {package}: install dynident[logs]") from None
