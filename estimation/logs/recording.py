"""From a log's raw tables to a recording in SI units, block by block."""

import hashlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...model import InputError, Recording, Robot
from ...model.arrays import Array
from .columns import Columns, choose, currents_only, holds_load
from .mapping import LogMap
from .opening import open_log
from .table import RawLog, Table
from .units import factor


class Samples(NamedTuple):
    """Some rows of a recording: ``t`` (N,) [s], ``q``, ``torque`` and ``qd`` (or None), N x n, joint side, SI."""

    t: Array
    q: Array
    torque: Array
    qd: Array | None


def read_recording(
    path: str | Path, robot: Robot, drive_gains: Sequence[float] | None = None, log_map: LogMap | None = None
) -> Recording:
    """Read one log: CSV, TSV (plain or gzip), NPZ, MAT, Parquet or a ROS 2 bag.

    Blocks of rows go straight to their place: a long log takes the memory of its recording and little more.

    Args:
        path: the file or folder.
        robot: tells how many joints there are.
        drive_gains: torque per current of each joint [N·m/A or N/A], if currents are to be used.
        log_map: which columns, units, side and signs; by default t, q1, tau1 or i1 and so on in SI units.

    Returns:
        The recording; its notes list the columns that were ignored.

    Raises:
        InputError: names the file, line and column of whatever cannot be used.
    """
    log_map = log_map or LogMap()
    raw, columns = _opened(path, robot, drive_gains, log_map)
    kinds = ("t", "q", "torque", "qd") if columns.velocity else ("t", "q", "torque")
    columns_of = {"t": 1, "q": robot.n, "torque": robot.n, "qd": robot.n}
    grown, read = {kind: _Growing(columns_of[kind]) for kind in kinds}, hashlib.blake2b(digest_size=16)
    gains = np.ones(robot.n) if drive_gains is None else np.array(drive_gains, dtype=float)
    for samples in _samples(raw, columns, robot, None, log_map):
        # Row by row, so that the size of blocks does not matter.
        read.update(np.column_stack([samples.t, samples.q, samples.torque]).tobytes())
        for kind, growing in grown.items():
            growing.add(samples.torque * gains if kind == "torque" else getattr(samples, kind))
    values = {kind: growing.taken() for kind, growing in grown.items()}
    if len(values["t"]) < 2:
        raise InputError(f"{raw.path}: {len(values['t'])} rows of numbers: a recording needs many")
    t = values["t"].reshape(-1)
    check_time(raw, columns.time, t)
    told = (str(raw.path), columns.notes, read.hexdigest())
    return Recording(t, values["q"], values["torque"], values.get("qd"), *told)


def stream_samples(
    path: str | Path, robot: Robot, drive_gains: Sequence[float] | None = None, log_map: LogMap | None = None
) -> Iterator[Samples]:
    """The same rows block by block, for logs that no memory holds; time is checked within blocks only.

    Raises:
        InputError: as ``read_recording``.
    """
    log_map = log_map or LogMap()
    raw, columns = _opened(path, robot, drive_gains, log_map)
    yield from _samples(raw, columns, robot, drive_gains, log_map)


def holds_currents_only(path: str | Path, robot: Robot, log_map: LogMap | None = None) -> bool:
    """Whether a log carries currents but no torques.

    Raises:
        InputError: if it cannot be opened.
    """
    log_map = log_map or LogMap()
    log_map.check(robot.n)
    return currents_only(open_log(path, log_map), log_map, robot)


def holds_torques(path: str | Path, robot: Robot, log_map: LogMap | None = None) -> bool:
    """Whether a log carries torques or currents.

    Raises:
        InputError: if it cannot be opened.
    """
    log_map = log_map or LogMap()
    log_map.check(robot.n)
    return holds_load(open_log(path, log_map), log_map, robot)


def _opened(
    path: str | Path, robot: Robot, gains: Sequence[float] | None, log_map: LogMap
) -> tuple[RawLog, Columns]:
    log_map.check(robot.n)
    raw = open_log(path, log_map)
    return raw, choose(raw, log_map, robot, gains)


def _samples(
    raw: RawLog, columns: Columns, robot: Robot, gains: Sequence[float] | None, log_map: LogMap
) -> Iterator[Samples]:
    scale = np.ones(robot.n) if gains is None else np.array(gains, dtype=float)
    row = 0
    for table in raw.blocks(columns.wanted):
        check_finite(raw, table, row)
        if columns.time:
            t = table.columns([columns.time])[:, 0] * factor("time", log_map.time_unit)
        else:
            t = (row + np.arange(len(table.values))) / (log_map.rate or 1.0)
        q = log_map.si("position", table.columns(columns.position))
        load = log_map.si(columns.kind, table.columns(columns.load)) * scale
        qd = log_map.si("velocity", table.columns(columns.velocity)) if columns.velocity else None
        yield Samples(t, q, load, qd)
        row += len(table.values)


class _Growing:
    """Rows that arrive in blocks, in one array that grows in place."""

    def __init__(self, width: int) -> None:
        self._array = np.empty((0, width))
        self._rows = 0

    def add(self, block: Array) -> None:
        end = self._rows + len(block)
        if end > len(self._array):
            self._array.resize((max(end, len(self._array) * 5 // 4), self._array.shape[1]), refcheck=False)
        self._array[self._rows : end] = block.reshape(len(block), -1)
        self._rows = end

    def taken(self) -> Array:
        """The rows, locked, so that a recording need not copy them."""
        array = self._array
        array.resize((self._rows, array.shape[1]), refcheck=False)
        array.setflags(write=False)
        return array


def check_finite(raw: RawLog, table: Table, row: int) -> None:
    """Refuse rows with a number that is not finite; ``row``: of the table's first.

    Raises:
        InputError: says where it stands.
    """
    good = np.isfinite(table.values)
    if not good.all():
        k, place = np.argwhere(~good)[0]
        raise InputError(
            f"{raw.path}: {raw.place(row + int(k))}, column {table.names[place]!r}: {table.values[k, place]} is "
            "not a finite number: mend or remove the row"
        )


def check_time(raw: RawLog, column: str, t: Array) -> None:
    """Refuse times [s] that do not rise, leave a gap, or are in another unit.

    Raises:
        InputError: says where.
    """
    steps = np.diff(t)
    if (steps <= 0.0).any():
        k = int(np.argmax(steps <= 0.0))
        what = "stands still" if steps[k] == 0.0 else "runs back"
        raise InputError(
            f"{raw.path}: {raw.place(k + 1)}, column {column!r}: time {what} ({t[k]:g} s, then {t[k + 1]:g} s): "
            "remove the repeated rows or split the file"
        )
    if np.median(steps) > 0.5:
        raise InputError(
            f"{raw.path}: column {column!r}: {np.median(steps):g} s from row to row: t must be in seconds; is it "
            "in ms? (--units t=ms)"
        )
    gap = int(np.argmax(steps))
    if steps[gap] > max(10.0 * np.median(steps), 0.25):
        raise InputError(
            f"{raw.path}: {raw.place(gap + 1)}, column {column!r}: {steps[gap]:g} s missing after {t[gap]:g} s: "
            "split the file there and give both parts"
        )
