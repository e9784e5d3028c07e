"""Text: CSV, TSV and the like, plain or gzip; how a file writes its table is found out, and it is read so."""

import csv
import gzip
import re
import zlib
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import chain
from pathlib import Path
from typing import IO

import numpy as np

from ...common import Array, InputError
from .columns import RawLog
from .map import DELIMITERS, Layout, known_unit, with_unit

_SAMPLE = 1 << 17  # bytes that a dialect is found out from, and letters that a line may have
_MOST_PASSED = 1_000_000  # lines without numbers
_BOMS = {b"\xef\xbb\xbf": "utf-8-sig", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
_NOT_TEXT = {
    b"PK\x03\x04": "a spreadsheet or an archive: save it as CSV (Excel: Save As, 'CSV UTF-8'), or unpack it",
    b"\xd0\xcf\x11\xe0": "a spreadsheet: save it as CSV (Excel: Save As, 'CSV UTF-8')",
    b"#ROSBAG V": "a bag of ROS 1: convert it to ROS 2 (rosbags-convert --src A.bag --dst A)",
    b"BZh": "compressed by bzip2: unpack it, or compress it by gzip",
    b"\xfd7zXZ": "compressed by xz: unpack it, or compress it by gzip",
    b"\x28\xb5\x2f\xfd": "compressed by zstd: unpack it, or compress it by gzip",
}
"""First bytes of what people give for text, and what to do with it."""
_SPREADSHEETS = (".xlsx", ".xlsm", ".xls", ".ods", ".numbers")
_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1f]")
_MARK = ("#", "%")
_GAIN_SIGMA = re.compile(r"[#%]\s*gain_sigma\s*=\s*(.*?)\s*")
_SEPARATOR = re.compile(r'"?sep=([^"])"?', re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?")
_STOPPED = re.compile(r"string (.*) to float64 at row (\d+), column (\d+)", re.DOTALL)
_NAMES = {"\t": "tabs", ";": "semicolons", ",": "commas", "|": "bars", None: "blanks"}


class CsvLog(RawLog):
    """A text file that is open: the way in which it writes its table, and what reading its rows showed."""

    def __init__(self, path: Path, layout: Layout) -> None:
        """Find the dialect out where the layout does not say it."""
        self.path = path
        self._per_row, self._encoding = layout.per_row, _encoding(path)
        self._passed: list[int] = []  # rows before which a line without numbers was passed over
        with _opened(path, self._encoding) as text:
            lines = text.read(_SAMPLE).splitlines()
        if len(lines) > 1 and len("\n".join(lines)) >= _SAMPLE - 1:
            lines.pop()  # perhaps the beginning of one
        # Lines before the header, the remarks among them, and the delimiter that a line "sep=;" tells.
        self._before, remarks, stated = layout.skip, list[str](), ""
        for line in [] if layout.skip else lines:
            separator = _SEPARATOR.fullmatch(line.strip(" \r"))
            if separator or line.strip() == "sep=\t":
                stated = separator[1] if separator else "\t"
            elif line.startswith(_MARK):
                remarks.append(line)
            elif line.strip():
                break
            self._before += 1
        header = lines[self._before] if self._before < len(lines) else ""
        below = lines[self._before + (not layout.names) :]
        usual, self._decimal = "\t" if ".tsv" in path.suffixes else ",", layout.decimal or "."
        self._delimiter = DELIMITERS.get(layout.delimiter, stated)
        if not (layout.delimiter or stated):
            # What cuts header and first rows into equally many cells, the most; where none does, the header alone.
            # Of delimiters that do as well as each other the first counts: the usual one.
            rows = [header, *[line for line in below[:50] if line.strip() and not line.startswith(_MARK)][:3]]
            counts = {
                delimiter: [len(_cells(line.strip().rstrip(delimiter), delimiter)) for line in rows]
                for delimiter in dict.fromkeys((usual, *_NAMES))
            }
            several = {delimiter: cells for delimiter, cells in counts.items() if cells[0] > 1}
            alike = [delimiter for delimiter, cells in several.items() if len(set(cells)) == 1]
            named = [delimiter for delimiter in several if delimiter is not None]
            self._delimiter = max(alike or named or [usual], key=lambda delimiter: counts[delimiter][0])
        if not layout.decimal and self._delimiter != ",":
            # A comma where numbers have one and none has a point.
            lines = [line for line in below if not line.startswith(_MARK)]
            cells = list(chain.from_iterable(_cells(line, self._delimiter) for line in lines))
            points = any("." in cell and self._is_number(cell) for cell in cells)
            if not points and any(map(_DECIMAL_COMMA.fullmatch, cells)):
                self._decimal = ","
        names, units = (list(layout.names), []) if layout.names else self._header(header, remarks, below)
        sigma: float | None = None
        for stated_sigma in filter(None, map(_GAIN_SIGMA.fullmatch, [*remarks])):
            fraction = stated_sigma[1]
            sigma = float(fraction) if self._is_number(fraction) else -1.0
            if not 0.0 <= sigma < 1.0:
                raise InputError(f"{path}: gain_sigma = {fraction}: give a fraction from 0 to below 1; 0 if exact")
            remarks.remove(stated_sigma[0])
        columns = [with_unit(name) for name in names]
        names = [name for name, _ in columns]
        stated_units = dict(zip(names, units, strict=False)) | {name: unit for name, unit in columns if unit}
        unusual = not layout.delimiter and (self._delimiter != usual or bool(stated))
        told = {
            f"cells separated by {_NAMES.get(self._delimiter, repr(self._delimiter))}": unusual,
            "decimal commas": not layout.decimal and self._decimal == ",",
            "UTF-16 text": self._encoding.startswith("utf-16"),
            "a byte order mark": self._encoding == "utf-8-sig",
            "Latin-1 text": self._encoding == "latin-1",
            "a row of units": bool(units),
            "remarks": bool(remarks),
        }
        words = ", ".join(text for text, is_so in told.items() if is_so)
        notes = [f"text read with {words}"] * bool(words)
        super().__init__(path, tuple(names), self._read, self._place, (), stated_units, notes, sigma)

    def _header(self, line: str, remarks: Sequence[str], below: Sequence[str]) -> tuple[list[str], list[str]]:
        """Names of the columns, by the last remark of a file of numbers, and the row of units below them."""
        names = _cells(line, self._delimiter)
        while len(names) > 1 and not names[-1]:
            names.pop()
        numbers = all(map(self._is_number, names))
        if remarks and names and numbers:
            named = _cells(remarks[-1].lstrip("".join(_MARK)).strip(), self._delimiter)
            if len(named) == len(names):
                return named, []
        self._before += 1
        if not any(names):
            raise InputError(f"{self.path}: is empty: a header line and rows of numbers are needed")
        if len(names) == 1:
            fault = f"the header {names[0][:40]!r} has one column"
            raise InputError(f"{self.path}: {fault}: separate columns by commas, semicolons, tabs or blanks")
        if numbers:
            raise InputError(f"{self.path}: line {self._before} has numbers: add a header with column names")
        first = next((line for line in below if line.strip()), "")
        units = _cells(first, self._delimiter)[: len(names)]
        # A row of units holds no number, and some unit that is known.
        if any(map(self._is_number, units)) or not any(known_unit(unit.strip("[]()")) for unit in units):
            return names, []
        self._before += below.index(first) + 1
        return names, units

    def _is_number(self, cell: str) -> bool:
        """True for a number, not a number and infinity among them."""
        try:
            float(cell.replace(",", ".") if self._decimal == "," else cell)
        except ValueError:
            return False
        return "_" not in cell

    def _place(self, row: int) -> str:
        return f"line {self._before + 1 + row * max(self._per_row, 1) + bisect_right(self._passed, row)}"

    def _read(self, columns: Sequence[str]) -> Array:
        """Some of the columns; once, for what is found on the way joins the notes."""
        per_row, wanted = self._per_row, [self.names.index(name) for name in columns]
        indices = [0] if per_row else wanted
        with _opened(self.path, self._encoding) as text:
            rows = self._rows(text, indices)
            first = next(rows, None)
            if first is None:
                return np.empty((0, len(columns)))
            between, quote = (None, None) if per_row else (self._delimiter, '"')
            try:
                rows = chain([first], rows)
                rows = (row.replace(",", ".") for row in rows) if self._decimal == "," else rows
                values = np.loadtxt(rows, np.float64, None, between, usecols=indices, ndmin=2, quotechar=quote)
            except InputError:
                raise
            except (ValueError, IndexError, TypeError) as error:
                if not (match := _STOPPED.search(str(error))):
                    raise InputError(f"{self.path}: the rows cannot be read as numbers") from None
                row, name = int(match[2]), self.names[int(match[3]) - 1]
                place = f"line {self._before + 1 + row}" if per_row else self.place(row)
                fault = f"{place}, column {name!r}: {match[1][:22]} is not a finite number"
                raise InputError(f"{self.path}: {fault}: correct or remove the row") from None
        if per_row and values.size % per_row:
            raise InputError(f"{self.path}: {values.size} numbers are not a multiple of {per_row}: it is cut")
        return values.reshape(-1, per_row)[:, wanted] if per_row else values

    def _rows(self, text: IO[str], indices: list[int]) -> Iterator[str]:
        """Rows as wide as the header: without remarks and empty lines, and without a last row that is cut."""
        width, count = len(self.names), 0
        for number, line in enumerate(iter(partial(text.readline, _SAMPLE), ""), 1):
            if len(line) == _SAMPLE:  # of a packed text one of 10 GB takes 10 MB
                fault = f"line {number} has more than {_SAMPLE:,} characters, which no row of numbers has"
                raise InputError(f"{self.path}: {fault}: correct or remove it")
            if number <= self._before:
                continue
            if self._per_row:
                yield line
                continue
            if not line.strip() or line.startswith(_MARK):
                self._passed.append(count)
                if len(self._passed) > _MOST_PASSED:
                    fault = f"more than {_MOST_PASSED:,} lines without numbers, up to line {number}"
                    raise InputError(f"{self.path}: {fault}: is it a log? save its rows alone")
                continue
            whole = line.endswith(("\n", "\r"))
            # The quick way to count cells serves nearly every row.
            if self._delimiter is None or not whole or line.count(self._delimiter) != width - 1 or '"' in line:
                cells = _cells(line, self._delimiter)
                if len(cells) == width + 1 and not cells[-1]:
                    cells.pop()
                inside = width - 1 in indices and len(cells) == width and not self._is_number(cells[-1])
                if not whole and (len(cells) < width or inside):
                    self.notes.append(f"the last row ({self.place(count)}) is cut off: left out")
                    return
                if len(cells) != width:
                    advice = "correct or remove the row, or name every column"
                    if missing := self.names[len(cells) :]:
                        advice = f"{missing[0]!r}{' and what follows it' if missing[1:] else ''} is missing"
                    elif self._delimiter == "," and len(cells) > 1.5 * width:
                        advice = "numbers need decimal points, or semicolons between them"
                    counts = f"line {number} has {len(cells)} cells, the header {width} names"
                    raise InputError(f"{self.path}: {counts}: {advice}")
            count += 1
            yield line


def _cells(line: str, delimiter: str | None) -> list[str]:
    """Cells of one line, without quotation marks; no delimiter stands for any white space."""
    line = line.rstrip("\r\n")
    if delimiter is None:
        return line.split()
    try:
        split = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
    except csv.Error:  # a cell of more than 131,072 characters
        return [line]
    return [cell.strip() for cell in split]


def _encoding(path: Path) -> str:
    if path.suffix.lower() in _SPREADSHEETS and path.is_file():
        raise InputError(f"{path}: a spreadsheet: save it as CSV (Excel: Save As, 'CSV UTF-8') and give that file")
    with _opened(path, "latin-1") as text:
        sample = text.read(_SAMPLE).encode("latin-1")
    if advice := next((advice for magic, advice in _NOT_TEXT.items() if sample.startswith(magic)), ""):
        raise InputError(f"{path}: {advice}")
    if marked := next((encoding for mark, encoding in _BOMS.items() if sample.startswith(mark)), ""):
        return marked
    for first, encoding in ((1, "utf-16-le"), (0, "utf-16-be")):
        if sample[first::2].count(0) > len(sample) // 4:
            return encoding
    if len(_CONTROL.findall(sample)) > len(sample) // 1000:
        raise InputError(f"{path}: is not a text file: give a log as CSV, TSV, NPZ, MAT or Parquet")
    try:
        sample[: sample.rfind(b"\n") + 1 or len(sample)].decode()
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8"


@contextmanager
def _opened(path: Path, encoding: str) -> Iterator[IO[str]]:
    """Open a text file, plain or gzip; what is no text of its encoding comes as a mark, for a number is none."""
    errors = "replace" if encoding.startswith("utf-16") else "surrogateescape"
    try:
        with path.open("rb") as stream:
            packed = path.suffix.lower() == ".gz" or stream.read(2) == b"\x1f\x8b"
        with (gzip.open if packed else open)(path, "rt", encoding=encoding, errors=errors, newline="") as text:
            yield text
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
