"""How a text file writes its table: encoding, what separates cells, decimal sign, units, remarks; found out."""

import csv
import gzip
import io
import re
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import IO, cast

from ...common.errors import InputError
from .quantity import known_unit
from .table import DELIMITERS, Layout, listed

_SAMPLE = 1 << 17
"""Bytes that a dialect is found out from."""
_GZIP = b"\x1f\x8b"
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
_SEPARATOR = re.compile(r'"?sep=(.)"?', re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?")
_NAMES = {"\t": "tabs", ";": "semicolons", ",": "commas", "|": "bars", None: "blanks"}
_ENCODINGS = {"utf-8-sig": "a byte order mark", "latin-1": "Latin-1 text"}


@dataclass(frozen=True)
class Dialect:
    """How a text file writes its table.

    Attributes:
        encoding: Python's name of it.
        delimiter: between cells; None stands for any white space.
        decimal: "." or ",".
        before: lines before the first row of numbers.
        header: names of the columns as they stand there; empty where there is no such line.
        units: of the columns, as a row below the header gives them; empty without one.
        told: what differs from a plain file, in words.
    """

    encoding: str = "utf-8"
    delimiter: str | None = ","
    decimal: str = "."
    before: int = 0
    header: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    told: tuple[str, ...] = ()

    def cells(self, line: str) -> list[str]:
        """Cells of one line, without quotation marks; what a last delimiter ends is no further cell."""
        line = line.rstrip("\r\n")
        if self.delimiter is None:
            return line.split()
        try:
            split = next(csv.reader([line], delimiter=self.delimiter, skipinitialspace=True), [])
        except csv.Error:  # a cell of more than 131,072 characters
            return [line]
        cells = [cell.strip() for cell in split]
        return cells[:-1] if len(cells) > 1 and not cells[-1] and len(cells) > len(self.header) > 0 else cells

    def plain(self, cell: str) -> str:
        """A number as Python writes it."""
        return cell.replace(",", ".") if self.decimal == "," else cell


def dialect_of(path: Path, layout: Layout) -> Dialect:
    """Find out how a file writes its table; what the layout says is taken as said.

    Raises:
        InputError: if it is no text, or cannot be read.
    """
    encoding = _encoding(path)
    with opened_text(path, encoding) as text:
        lines = text.read(_SAMPLE).splitlines()
    if len(lines) > 1 and len("\n".join(lines)) >= _SAMPLE - 1:
        lines.pop()  # perhaps the beginning of one
    start, remarks, stated = (layout.skip, [], "") if layout.skip else _preamble(lines)
    header_line = lines[start] if start < len(lines) else ""
    below = lines[start + (not layout.names) :]
    delimiter = DELIMITERS[layout.delimiter] if layout.delimiter else stated or _delimiter(path, header_line, below)
    dialect = Dialect(encoding, delimiter, layout.decimal or ".", start)
    if not layout.decimal and delimiter != ",":
        dialect = replace(dialect, decimal=_decimal(dialect, below))
    if not layout.names:
        dialect = _with_header(dialect, header_line, remarks, below)
    return replace(dialect, told=tuple(_told(path, layout, dialect, bool(remarks), bool(stated))))


def _encoding(path: Path) -> str:
    """The encoding by the first bytes.

    Raises:
        InputError: if these are no text's.
    """
    if path.suffix.lower() in _SPREADSHEETS and path.is_file():
        raise InputError(f"{path}: a spreadsheet: save it as CSV (Excel: Save As, 'CSV UTF-8') and give that file")
    with _binary(path) as stream:
        sample = stream.read(_SAMPLE)
    for magic, advice in _NOT_TEXT.items():
        if sample.startswith(magic):
            raise InputError(f"{path}: {advice}")
    for mark, encoding in _BOMS.items():
        if sample.startswith(mark):
            return encoding
    if sample[1::2].count(0) > len(sample) // 4:
        return "utf-16-le"
    if sample[::2].count(0) > len(sample) // 4:
        return "utf-16-be"
    if len(_CONTROL.findall(sample)) > len(sample) // 1000:
        raise InputError(f"{path}: not UTF-8 text: save it as UTF-8")
    try:
        sample[: sample.rfind(b"\n") + 1 or len(sample)].decode()
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8"


def _preamble(lines: Sequence[str]) -> tuple[int, list[str], str]:
    """Lines before the header, the remarks among them, and the delimiter that a line "sep=;" tells."""
    remarks, delimiter = [], ""
    for number, line in enumerate(lines):
        separator = _SEPARATOR.fullmatch(line.strip(" \r"))
        if separator or line.strip() == "sep=\t":
            delimiter = separator[1] if separator else "\t"
        elif line.startswith(_MARK):
            remarks.append(line)
        elif line.strip():
            return number, remarks, delimiter
    return len(lines), remarks, delimiter


def _delimiter(path: Path, header: str, below: Sequence[str]) -> str | None:
    """What cuts header and rows into equally many cells, the most of them; where none does, the header alone."""
    usual = _usual_delimiter(path)
    lines = (header, *_first_rows(below))
    # Of delimiters that do as well as each other the first counts: the usual one.
    counts = {delimiter: _cell_counts(delimiter, lines) for delimiter in dict.fromkeys((usual, *_NAMES))}
    several = {delimiter: cells for delimiter, cells in counts.items() if cells[0] > 1}
    alike = [delimiter for delimiter, cells in several.items() if len(set(cells)) == 1]
    named = [delimiter for delimiter in several if delimiter is not None]
    return max(alike or named or [usual], key=lambda delimiter: counts[delimiter][0])


def _usual_delimiter(path: Path) -> str:
    """What separates cells in files of this ending."""
    return "\t" if ".tsv" in path.suffixes else ","


def _first_rows(below: Sequence[str]) -> list[str]:
    """The first three rows of cells."""
    return [line for line in islice(below, 50) if line.strip() and not line.startswith(_MARK)][:3]


def _cell_counts(delimiter: str | None, lines: Sequence[str]) -> list[int]:
    """Into how many cells a delimiter cuts each line."""
    dialect = Dialect(delimiter=delimiter)
    return [len(dialect.cells(line.strip().rstrip(delimiter))) for line in lines]


def _decimal(dialect: Dialect, below: Sequence[str]) -> str:
    """A comma where numbers have one and none has a point."""
    cells = [cell for line in below for cell in dialect.cells(line) if not line.startswith(_MARK)]
    commas = any(_DECIMAL_COMMA.fullmatch(cell) for cell in cells)
    return "," if commas and not any("." in cell and is_number(cell) for cell in cells) else "."


def _with_header(dialect: Dialect, line: str, remarks: Sequence[str], below: Sequence[str]) -> Dialect:
    """Names of the columns, and the row of units below them; of a file of numbers the last remark may name them."""
    names = dialect.cells(line)
    while len(names) > 1 and not names[-1]:
        names.pop()
    if remarks and names and all(is_number(dialect.plain(name)) for name in names):
        named = dialect.cells(remarks[-1].lstrip("".join(_MARK)).strip())
        if len(named) == len(names):
            return replace(dialect, header=tuple(named))
    first = next((line for line in below if line.strip()), "")
    units = dialect.cells(first)[: len(names)] if _is_units(dialect, first) else []
    skipped = below.index(first) + 1 if units else 0
    return replace(dialect, header=tuple(names), units=tuple(units), before=dialect.before + 1 + skipped)


def _is_units(dialect: Dialect, line: str) -> bool:
    """Whether a row below the header holds units: no number, and some unit that is known."""
    cells = [cell for cell in dialect.cells(line) if cell]
    numbers = any(is_number(dialect.plain(cell)) for cell in cells)
    return not numbers and any(known_unit(cell.strip("[]()")) for cell in cells)


def _told(path: Path, layout: Layout, dialect: Dialect, remarks: bool, stated: bool) -> Iterator[str]:
    """What was found out and is not what a file of this ending usually is."""
    if not layout.delimiter and (dialect.delimiter != _usual_delimiter(path) or stated):
        yield f"cells separated by {_NAMES.get(dialect.delimiter, repr(dialect.delimiter))}"
    if not layout.decimal and dialect.decimal == ",":
        yield "decimal commas"
    if dialect.encoding.startswith("utf-16"):
        yield "UTF-16 text"
    elif dialect.encoding in _ENCODINGS:
        yield _ENCODINGS[dialect.encoding]
    if dialect.units:
        yield "a row of units"
    if remarks:
        yield "remarks"


def is_number(cell: str) -> bool:
    """Whether Python reads a cell as a number, not a number and infinity among them."""
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


def names_of(dialect: Dialect, layout: Layout) -> tuple[str, ...]:
    """Names of the columns, by the layout or by the header."""
    return listed(layout.names) or dialect.header


@contextmanager
def opened_text(path: Path, encoding: str) -> Iterator[io.TextIOBase]:
    """A text file, plain or gzip; what is no text of its encoding comes as a mark, for a number is none.

    Raises:
        InputError: if it cannot be read.
    """
    errors = "replace" if encoding.startswith("utf-16") else "surrogateescape"
    with _binary(path) as binary, io.TextIOWrapper(binary, encoding=encoding, errors=errors, newline="") as text:
        yield text


@contextmanager
def _binary(path: Path) -> Iterator[IO[bytes]]:
    try:
        with path.open("rb") as stream:
            packed = path.suffix.lower() == ".gz" or stream.read(2) == _GZIP
        with gzip.open(path, "rb") if packed else path.open("rb") as binary:
            yield cast(IO[bytes], binary)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except UnicodeError:
        raise InputError(f"{path}: not UTF-8 text: save it as UTF-8") from None
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
