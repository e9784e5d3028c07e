"""Text: CSV, TSV and the like, plain or gzip."""

import csv
import gzip
import io
import math
import re
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import islice, repeat, takewhile
from pathlib import Path

import msgspec
import numpy as np
from msgspec.structs import replace

from ...common.arrays import Array
from ...common.errors import InputError
from .table import BLOCK, DELIMITERS, Layout, RawLog, listed

_NUMBERS = msgspec.json.Decoder(list[float])


def csv_log(path: Path, layout: Layout) -> RawLog:
    """Open a text file; lines before the header that start with # say something about it.

    Raises:
        InputError: if it has no header where one is needed, or cannot be read.
    """
    if not layout.skip:
        layout = replace(layout, skip=_remarks(path))
    delimiter = DELIMITERS[layout.delimiter or ("tab" if ".tsv" in path.suffixes else "comma")]
    text = _Text(path, layout, delimiter)
    names = listed(layout.names) or text.header()
    first = layout.skip + (1 if layout.names else 2)
    step = max(layout.per_row, 1)

    return RawLog(path, names, partial(text.blocks, names), lambda row: f"line {first + row * step}")


class _Text:
    """A text file with cells."""

    def __init__(self, path: Path, layout: Layout, delimiter: str | None) -> None:
        self._path, self._layout, self._delimiter = path, layout, delimiter
        self._before = layout.skip + (0 if layout.names else 1)

    def header(self) -> tuple[str, ...]:
        with _opened(self._path) as text:
            line = next(islice(text, self._layout.skip, None), "")
        header = self._cells(line)
        if header in ([], [""]):
            raise InputError(f"{self._path}: is empty: a header line and rows of numbers are needed")
        if len(header) == 1:
            separator = "commas" if self._delimiter == "," else f"{self._layout.delimiter or 'tab'}s"
            raise InputError(
                f"{self._path}: the header {line.strip()[:40]!r} has one column: separate columns by {separator}"
            )
        if all(re.fullmatch(r"[-+.\deE]+", name) for name in header):
            raise InputError(
                f"{self._path}: line {self._layout.skip + 1} holds numbers: a header with column names is needed"
            )
        return tuple(header)

    def blocks(self, names: Sequence[str], columns: Sequence[str]) -> Iterator[Array]:
        """Some of the columns; reads ``BLOCK`` rows at a time."""
        places = [names.index(name) for name in columns]
        self._check_width(names)
        with _opened(self._path) as text:
            lines = islice(text, self._before, None)
            while block := list(islice(lines, BLOCK * max(self._layout.per_row, 1))):
                values = self._parsed(block, places)
                if values is None or not np.isfinite(values).all():
                    raise self._bad_cell(names, columns)
                if len(values):
                    yield values

    def _parsed(self, lines: list[str], places: list[int]) -> Array | None:
        """Numbers of some lines, None where they are none."""
        if not any(line.strip() for line in lines):
            return np.empty((0, len(places)))
        if self._layout.decimal == ",":
            lines = [line.replace(",", ".") for line in lines]
        values = None if self._layout.per_row or not self._delimiter else _plain(lines, self._delimiter, places)
        if values is not None:
            return values
        try:
            if not self._layout.per_row:
                return np.loadtxt(lines, delimiter=self._delimiter, usecols=places, ndmin=2, comments=None)
            flat = np.loadtxt(lines, ndmin=1, comments=None).ravel()
        except (ValueError, IndexError):
            return None
        if flat.size % self._layout.per_row:
            raise InputError(
                f"{self._path}: {flat.size} numbers are not whole samples of {self._layout.per_row}: the file is "
                "cut"
            )
        return np.ascontiguousarray(flat.reshape(-1, self._layout.per_row)[:, places])

    def _cells(self, line: str) -> list[str]:
        line = line.rstrip("\r\n")
        return [cell.strip() for cell in line.split(self._delimiter)]

    def _check_width(self, names: Sequence[str]) -> None:
        """Decimal commas make more cells than names."""
        with _opened(self._path) as text:
            line = next(islice(text, self._before, None), "")
        cells = self._cells(line.rstrip("\r\n,")) if self._delimiter == "," else self._cells(line.rstrip())
        if len(cells) <= len(names) or self._layout.per_row:
            return
        advice = "numbers need decimal points, not commas" if self._delimiter == "," else "name every column"
        raise InputError(
            f"{self._path}: line {self._before + 1} has {len(cells)} cells, the header {len(names)} names: {advice}"
        )

    def _bad_cell(self, names: Sequence[str], columns: Sequence[str]) -> InputError:
        """Say where the first cell stands that is not a finite number."""
        places = {name: 0 if self._layout.per_row else names.index(name) for name in columns}
        with _opened(self._path) as text:
            rows = csv.reader(text, delimiter=self._delimiter) if self._delimiter else map(str.split, text)
            for line, cells in enumerate(rows, 1):
                if line <= self._before or not cells:
                    continue
                for name, place in places.items():
                    cell = cells[place].strip() if place < len(cells) else ""
                    if not _finite(cell.replace(",", ".") if self._layout.decimal == "," else cell):
                        return InputError(
                            f"{self._path}: line {line}, column {name!r}: {cell[:20]!r} is not a finite number: "
                            "mend or remove the row"
                        )
        return InputError(f"{self._path}: the rows cannot be read as numbers")


def _plain(lines: list[str], delimiter: str, places: list[int]) -> Array | None:
    """Numbers of lines that hold nothing but numbers as JSON writes them, equally many each; else None.

    Reads a long log in a third of the time of ``np.loadtxt``, which reads all others.
    """
    counts = set(map(str.count, lines, repeat(delimiter)))
    cells = max(counts) + 1
    if len(counts) > 1 or max(places) >= cells:
        return None
    try:
        numbers = _NUMBERS.decode(f"[{','.join(lines).replace(delimiter, ',')}]")
    except msgspec.DecodeError:
        return None
    if len(numbers) != cells * len(lines):
        return None
    return np.fromiter(numbers, float, len(numbers)).reshape(-1, cells)[:, places]


def _remarks(path: Path) -> int:
    with _opened(path) as text:
        return sum(1 for _ in takewhile(lambda line: line.startswith("#"), text))


def _finite(cell: str) -> bool:
    try:
        return math.isfinite(float(cell))
    except ValueError:
        return False


@contextmanager
def _opened(path: Path) -> Iterator[io.TextIOBase]:
    open_binary = gzip.open if path.suffix == ".gz" else open
    try:
        with open_binary(path, "rb") as binary, io.TextIOWrapper(binary, encoding="utf-8-sig", newline="") as text:
            yield text
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: not UTF-8 text: save it as UTF-8") from None
    except (OSError, EOFError, zlib.error, csv.Error) as error:
        raise InputError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
