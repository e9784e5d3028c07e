"""Text: CSV, TSV and the like, plain or gzip, as its dialect says."""

import math
from bisect import bisect_right
from collections.abc import Sequence
from itertools import islice, repeat
from pathlib import Path

import msgspec
import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from .dialect import Dialect, dialect_of, is_number, names_of, opened_text
from .quantity import with_unit
from .table import Layout, RawLog

BLOCK = 16384
"""Lines that are decoded at once: text takes many times the memory of its numbers."""
_NUMBERS = msgspec.json.Decoder(list[float])
_REMARKS = ("#", "%")


def csv_log(path: Path, layout: Layout) -> RawLog:
    """Open a text file, whose dialect is found out where the layout does not say it.

    Raises:
        InputError: if it has no header where one is needed, or cannot be read.
    """
    dialect = dialect_of(path, layout)
    if not layout.names:
        _check_header(path, dialect)
    named = [with_unit(name) for name in names_of(dialect, layout)]
    units = dict(zip((name for name, _ in named), dialect.units, strict=False))
    units |= {name: unit for name, unit in named if unit}
    names = tuple(name for name, _ in named)
    text = _Text(path, dialect, layout.per_row, names)
    return RawLog(path, names, text.read, text.place, units=units, notes=text.notes)


def _check_header(path: Path, dialect: Dialect) -> None:
    header = dialect.header
    if not any(header):
        raise InputError(f"{path}: is empty: a header line and rows of numbers are needed")
    if len(header) == 1:
        raise InputError(
            f"{path}: the header {header[0][:40]!r} has one column: separate columns by commas, semicolons, "
            "tabs or blanks"
        )
    if all(is_number(dialect.plain(name)) for name in header):
        raise InputError(f"{path}: line {dialect.before} holds numbers: a header with column names is needed")


class _Text:
    """The rows of a text file, and what reading them showed."""

    def __init__(self, path: Path, dialect: Dialect, per_row: int, names: tuple[str, ...]) -> None:
        self._path, self._dialect, self._per_row, self._names = path, dialect, per_row, names
        self._passed: list[int] = []  # rows before which a line without numbers was passed over
        self._cut = ""

    def place(self, row: int) -> str:
        passed = bisect_right(self._passed, row)
        return f"line {self._dialect.before + 1 + row * max(self._per_row, 1) + passed}"

    def notes(self) -> tuple[str, ...]:
        peculiarities = self._dialect.told
        read = [f"text read with {', '.join(peculiarities)}"] if peculiarities else []
        return (*read, *([self._cut] if self._cut else []))

    def read(self, columns: Sequence[str]) -> Array:
        """Some of the columns."""
        places = [self._names.index(name) for name in columns]
        self._passed, self._cut, at, rows = [], "", self._dialect.before, 0
        numbers = [np.empty((0, len(places)))]
        with opened_text(self._path, self._dialect.encoding) as text:
            lines = islice(text, self._dialect.before, None)
            while block := list(islice(lines, BLOCK * max(self._per_row, 1))):
                values = self._samples(block, places) if self._per_row else self._rows(block, places, at, rows)
                if not np.isfinite(values).all():
                    raise self._bad_cell(block, at, places)
                at, rows = at + len(block), rows + len(values)
                numbers.append(values)
        return np.concatenate(numbers)

    def _samples(self, lines: list[str], places: list[int]) -> Array:
        """Samples of a file with one number a line."""
        if not any(line.strip() for line in lines):
            return np.empty((0, len(places)))
        try:
            flat = np.loadtxt([self._dialect.plain(line) for line in lines], ndmin=1, comments=None).ravel()
        except ValueError:
            raise self._bad_cell(lines, self._dialect.before, [0]) from None
        if flat.size % self._per_row:
            raise InputError(
                f"{self._path}: {flat.size} numbers are not whole samples of {self._per_row}: the file is cut"
            )
        return np.ascontiguousarray(flat.reshape(-1, self._per_row)[:, places])

    def _rows(self, lines: list[str], places: list[int], at: int, row: int) -> Array:
        """Numbers of some lines, the first of which is line ``at`` + 1 and row ``row`` + 1."""
        width = len(self._names)
        cells = self._separated(lines)
        counts = set(map(str.count, cells, repeat(",")))
        if counts != {width - 1} or not lines[-1].endswith(("\n", "\r")):
            cells = self._whole(cells, lines, places, at, row)
        if not cells:
            return np.empty((0, len(places)))
        values = _plain(cells, places, width)
        if values is not None:
            return values
        try:
            return np.loadtxt(cells, delimiter=",", usecols=places, ndmin=2, comments=None)
        except (ValueError, IndexError):
            raise self._bad_cell(lines, at, places) from None

    def _separated(self, lines: list[str]) -> list[str]:
        """Lines with decimal points whose cells commas separate."""
        delimiter, point = self._dialect.delimiter, "." if self._dialect.decimal == "," else " "
        if any('"' in line for line in lines):
            cells = ([cell.replace(",", point) for cell in self._dialect.cells(line)] for line in lines)
            return [",".join(row) + "\n" for row in cells]
        if delimiter == ",":
            return lines
        if delimiter is None:
            return [",".join(line.replace(",", point).split()) + "\n" for line in lines]
        return [line.replace(",", point).replace(delimiter, ",") for line in lines]

    def _whole(self, cells: list[str], lines: list[str], places: list[int], at: int, row: int) -> list[str]:
        """Rows as wide as the header: without remarks and empty lines, a last delimiter and a last row that is cut.

        Raises:
            InputError: names the first line that has more or fewer cells.
        """
        rows: list[str] = []
        for number, (line, original) in enumerate(zip(cells, lines, strict=True)):
            if not line.strip() or line.startswith(_REMARKS):
                self._passed.append(row + len(rows))
                continue
            line = line.rstrip("\r\n")
            count = line.count(",") + 1
            if count == len(self._names) + 1 and line.endswith(","):
                line, count = line[:-1], count - 1
            last = number + 1 == len(lines) and not original.endswith(("\n", "\r"))
            if last and self._is_cut(line, places):
                self._cut = f"the last row ({self.place(row + len(rows))}) is cut off: left out"
            elif count != len(self._names):
                raise self._bad_width(at + number + 1, count)
            else:
                rows.append(line)
        return rows

    def _is_cut(self, line: str, places: list[int]) -> bool:
        """Whether a last line ends before its last cell, or within a number."""
        cells = line.split(",")
        return len(cells) < len(self._names) or (
            len(cells) == len(self._names) and len(cells) - 1 in places and not is_number(cells[-1])
        )

    def _bad_width(self, line: int, count: int) -> InputError:
        names = self._names
        if count < len(names):
            advice = f"{names[count]!r} and what follows it is missing" if count + 1 < len(names) else (
                f"{names[count]!r} is missing")  # fmt: skip
        elif self._dialect.delimiter == "," and count > 1.5 * len(names):
            advice = "numbers need decimal points, or semicolons between them"
        else:
            advice = "mend or remove the row, or name every column"
        return InputError(f"{self._path}: line {line} has {count} cells, the header {len(names)} names: {advice}")

    def _bad_cell(self, lines: list[str], at: int, places: list[int]) -> InputError:
        """Say where the first cell stands that is not a finite number."""
        for number, line in enumerate(self._separated(lines), at + 1):
            cells = line.split(",")
            if not line.strip() or line.startswith(_REMARKS):
                continue
            for place in [0] if self._per_row else places:
                cell = cells[place].strip() if place < len(cells) else ""
                if not (is_number(cell) and math.isfinite(float(cell))):
                    return InputError(
                        f"{self._path}: line {number}, column {self._names[place]!r}: {cell[:20]!r} is not a "
                        "finite number: mend or remove the row"
                    )
        return InputError(f"{self._path}: the rows cannot be read as numbers")


def _plain(lines: list[str], places: list[int], width: int) -> Array | None:
    """Numbers of lines that hold nothing but numbers as JSON writes them; else None.

    Reads a long log in a third of the time of ``np.loadtxt``, which reads all others.
    """
    try:
        numbers = _NUMBERS.decode(f"[{','.join(lines)}]")
    except (msgspec.DecodeError, UnicodeError):
        return None
    if len(numbers) != width * len(lines):
        return None
    return np.fromiter(numbers, float, len(numbers)).reshape(-1, width)[:, places]
