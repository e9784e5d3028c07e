"""Reads recordings: CSV, plain or gzip, header ``t,q1..qn[,qd1..qdn],tau1..taun`` or ``i1..in``."""

import csv
import gzip
import io
import math
import re
import warnings
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..model import InputError, Recording, Robot
from ..model.arrays import Array

_ALIASES = {
    "time": "t", "timestamp": "t", "position": "q", "pos": "q", "velocity": "qd", "vel": "qd", "speed": "qd",
    "dq": "qd", "qdot": "qd", "torque": "tau", "tq": "tau", "current": "i", "cur": "i",
}  # fmt: skip


def read_recording(path: str | Path, robot: Robot, drive_gains: Sequence[float] | None = None) -> Recording:
    """Read one CSV file.

    Args:
        path: the file; ``.gz`` is unpacked.
        robot: tells how many joints there are.
        drive_gains: torque per current of each joint [N·m/A or N/A], if currents are to be used.

    Returns:
        The recording; its notes list the columns that were ignored.

    Raises:
        InputError: names the file, line and column of whatever cannot be used.
    """
    path = Path(path)
    header = _header(path)
    torque, notes = _torque_columns(path, header, robot.n, drive_gains)
    wanted = ["t", *_numbered("q", robot.n)]
    speeds = _numbered("qd", robot.n)
    found = [name for name in speeds if name in header]
    if found:
        wanted += speeds
    wanted += torque
    _check_names(path, header, wanted, robot)
    ignored = [name for name in header if name not in wanted]
    if ignored:
        notes.append(f"{path.name}: columns not used: {', '.join(ignored)}")
    table = _numbers(path, header, wanted)
    if len(table) < 2:
        raise InputError(f"{path}: {len(table)} rows of numbers: a recording needs many")
    _check_time(path, table[:, 0])
    n = robot.n
    gains = np.ones(n) if drive_gains is None else np.array(drive_gains, dtype=float)
    return Recording(
        t=table[:, 0],
        q=table[:, 1 : n + 1],
        qd=table[:, n + 1 : 2 * n + 1] if found else None,
        torque=table[:, -n:] * gains,
        source=str(path),
        notes=tuple(notes),
    )


class TrajectoryTable(NamedTuple):
    """A planned motion as a file holds it: times [s], positions, and speeds and accelerations where it has them."""

    t: Array
    q: Array
    qd: Array | None
    qdd: Array | None


def read_trajectory(path: str | Path, robot: Robot) -> TrajectoryTable:
    """Read a planned motion from CSV: header ``t,q1..qn[,qd1..qdn[,qdd1..qddn]]``; other columns are not used.

    Args:
        path: the file; ``.gz`` is unpacked.
        robot: tells how many joints there are.

    Raises:
        InputError: names the file, line and column of whatever cannot be used.
    """
    path, n = Path(path), robot.n
    header = _header(path)
    wanted = ["t", *_numbered("q", n)]
    for kind in ("qd", "qdd"):
        if not set(_numbered(kind, n)) & set(header):
            break
        wanted += _numbered(kind, n)
    _check_names(path, header, wanted, robot)
    table = _numbers(path, header, wanted)
    if len(table) < 2:
        raise InputError(f"{path}: {len(table)} rows of numbers: a trajectory needs more")
    _check_time(path, table[:, 0])
    parts = [table[:, 1 + k * n : 1 + (k + 1) * n] for k in range(3)]
    qd, qdd = (part if part.shape[1] else None for part in parts[1:])
    return TrajectoryTable(table[:, 0], parts[0], qd, qdd)


def _numbered(prefix: str, n: int) -> list[str]:
    return [f"{prefix}{joint}" for joint in range(1, n + 1)]


def _torque_columns(
    path: Path, header: list[str], n: int, gains: Sequence[float] | None
) -> tuple[list[str], list[str]]:
    """Columns that carry the torque, and what to tell the user about the choice."""
    torques, currents = _numbered("tau", n), _numbered("i", n)
    if gains is None:
        if not set(torques) & set(header) and set(currents) & set(header):
            raise InputError(
                f"{path}: carries currents (i1..i{n}) but no torques: give --drive-gains, {n} numbers in N·m/A"
            )
        return torques, []
    if len(gains) != n:
        raise InputError(f"--drive-gains has {len(gains)} numbers, the robot has {n} joints: give one per joint")
    for joint, gain in enumerate(gains, 1):
        if not math.isfinite(gain) or gain == 0.0:
            raise InputError(f"--drive-gains: gain {joint} is {gain}: give a number other than zero in N·m/A")
    if not set(currents) & set(header):
        raise InputError(f"{path}: --drive-gains given, but the file has no currents i1..i{n}: leave them out")
    both = set(torques) <= set(header)
    return currents, [f"{path.name}: has torques too; currents and drive gains are used"] * both


def _check_names(path: Path, header: list[str], wanted: list[str], robot: Robot) -> None:
    twice = sorted({name for name in header if header.count(name) > 1})
    if twice:
        raise InputError(f"{path}: column {twice[0]!r} stands in the header twice: rename one")
    known = {"t"} | {name for prefix in ("q", "qd", "tau", "i") for name in _numbered(prefix, robot.n)}
    for name in header:
        if name in known:
            continue
        meant = _meant(name)
        if meant in known and (meant not in header or meant == name.strip().lower()):
            raise InputError(f"{path}: column {name!r} looks like {meant!r}: rename it")
        beyond = re.fullmatch(r"(q|qd|tau|i)(\d+)", name)
        if beyond:
            raise InputError(
                f"{path}: column {name!r}, but robot {robot.name!r} has {robot.n} joints: is it the right robot?"
            )
    missing = [name for name in wanted if name not in header]
    if missing:
        raise InputError(f"{path}: column {', '.join(missing)} missing; found {', '.join(header)}")


def _meant(name: str) -> str:
    """The known name that a header entry most likely stands for, or the entry itself."""
    plain = re.sub(r"[\[(].*?[\])]|[^a-z0-9]", "", name.lower())
    match = re.fullmatch(r"([a-z]+?)0*(\d*)", plain)
    if not match:
        return name
    return _ALIASES.get(match[1], match[1]) + match[2]


@contextmanager
def _opened(path: Path) -> Iterator[io.TextIOBase]:
    if path.exists() and not path.is_file():
        raise InputError(f"{path}: is not a regular file: give the path of a CSV file")
    try:
        open_binary = gzip.open if path.suffix == ".gz" else open
        with open_binary(path, "rb") as binary, io.TextIOWrapper(binary, encoding="utf-8-sig", newline="") as text:
            yield text
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (OSError, EOFError, UnicodeDecodeError, zlib.error, csv.Error) as error:
        raise InputError(f"{path}: cannot be read ({error})") from None


def _header_line(text: io.TextIOBase) -> tuple[str, int]:
    """The header and its line's number; lines before it that start with # say something about the file."""
    line, place = text.readline(), 1
    while line.startswith("#"):
        line, place = text.readline(), place + 1
    return line, place


def _header(path: Path) -> list[str]:
    with _opened(path) as text:
        line, place = _header_line(text)
    header = [name.strip() for name in line.rstrip("\r\n").split(",")]
    if header == [""]:
        raise InputError(f"{path}: is empty: a header line and rows of numbers are needed")
    if len(header) == 1:
        raise InputError(f"{path}: the header {line.strip()[:40]!r} has one column: separate columns by commas")
    if all(re.fullmatch(r"[-+.\deE]+", name) for name in header):
        raise InputError(f"{path}: line {place} holds numbers: a header with column names is needed")
    return header


def _numbers(path: Path, header: list[str], wanted: list[str]) -> Array:
    """The wanted columns, shape (rows, len(wanted))."""
    places = [header.index(name) for name in wanted]
    table: Array | None = None
    _check_width(path, header)
    with _opened(path) as text, warnings.catch_warnings():
        _header_line(text)
        try:
            warnings.simplefilter("ignore", UserWarning)  # an empty table is told below
            table = np.loadtxt(text, delimiter=",", usecols=places, ndmin=2, comments=None)
        except (ValueError, IndexError):
            table = None
    if table is None or not np.isfinite(table).all():
        raise _bad_cell(path, header, wanted)
    return table


def _check_width(path: Path, header: list[str]) -> None:
    """Decimal commas make more cells than names."""
    with _opened(path) as text:
        _, place = _header_line(text)
        cells = text.readline().rstrip("\r\n,").split(",")
    if len(cells) > len(header):
        raise InputError(
            f"{path}: line {place + 1} has {len(cells)} cells, the header {len(header)} names: numbers need "
            "decimal points, not commas"
        )


def _bad_cell(path: Path, header: list[str], wanted: list[str]) -> InputError:
    """Say where the first cell stands that is not a finite number."""
    places = {name: header.index(name) for name in wanted}
    with _opened(path) as text:
        _, place = _header_line(text)
        for line, cells in enumerate(csv.reader(text), place + 1):
            if not cells:
                continue
            for name, place in places.items():
                cell = cells[place].strip() if place < len(cells) else ""
                try:
                    good = math.isfinite(float(cell))
                except ValueError:
                    good = False
                if not good:
                    return InputError(
                        f"{path}: line {line}, column {name!r}: {cell[:20]!r} is not a finite number: "
                        "mend or remove the row"
                    )
    return InputError(f"{path}: the rows cannot be read as numbers")


def _check_time(path: Path, t: Array) -> None:
    with _opened(path) as text:
        _, place = _header_line(text)
    steps = np.diff(t)
    if (steps <= 0.0).any():
        k = int(np.argmax(steps <= 0.0))
        what = "stands still" if steps[k] == 0.0 else "runs back"
        raise InputError(
            f"{path}: line {k + 2 + place}, column 't': time {what} ({t[k]:g} s, then {t[k + 1]:g} s): "
            "remove the repeated rows or split the file"
        )
    if np.median(steps) > 0.5:
        raise InputError(
            f"{path}: column 't': {np.median(steps):g} s from row to row: t must be in seconds; is it in ms?"
        )
    gap = int(np.argmax(steps))
    if steps[gap] > max(10.0 * np.median(steps), 0.25):
        raise InputError(
            f"{path}: line {gap + 2 + place}, column 't': {steps[gap]:g} s missing after {t[gap]:g} s: split "
            "the file there and give both parts"
        )
