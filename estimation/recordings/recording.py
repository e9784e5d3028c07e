"""From a log's raw tables to a recording in SI units, block by block."""

import hashlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.paged import Growing, parts, release
from ...model import Recording, Robot
from .columns import Columns, choose, currents_only, holds_load
from .mapping import LogMap
from .opening import open_log
from .table import RawLog, Table
from .units import factor

_MEDIAN_OF = 1_000_000


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
        drive_gains: torque per current of each motor, on the joint side [N·m/A or N/A], if currents are to be used;
            of coupled drives motor j's and motor k's torques act on joint j, as (9) says.
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
    grown, read = {kind: Growing(columns_of[kind]) for kind in kinds}, hashlib.blake2b(digest_size=16)
    for samples in _samples(raw, columns, robot, log_map):
        # Row by row, so that the size of blocks does not matter.
        read.update(np.column_stack([samples.t, samples.q, samples.torque]).tobytes())
        samples = _with_torques(samples, columns, robot, drive_gains)
        for kind, growing in grown.items():
            growing.add(getattr(samples, kind))
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
    for samples in _samples(raw, columns, robot, log_map):
        yield _with_torques(samples, columns, robot, drive_gains)


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


def _with_torques(samples: Samples, columns: Columns, robot: Robot, gains: Sequence[float] | None) -> Samples:
    """Torques in the place of currents."""
    if columns.kind != "current":
        return samples
    motors = samples.torque * (1.0 if gains is None else np.array(gains, dtype=float))
    return samples._replace(torque=robot.coupling.joint_torques(motors) if robot.coupling else motors)


def _samples(raw: RawLog, columns: Columns, robot: Robot, log_map: LogMap) -> Iterator[Samples]:
    """Rows as they stand there, in SI units: torques, or the motors' currents in their place."""
    row = 0
    for table in raw.blocks(columns.wanted):
        check_finite(raw, table, row)
        if columns.time:
            t = table.columns([columns.time])[:, 0] * factor("time", log_map.time_unit)
        else:
            t = (row + np.arange(len(table.values))) / (log_map.rate or 1.0)
        q = log_map.si("position", table.columns(columns.position))
        load = log_map.si(columns.kind, table.columns(columns.load))
        qd = log_map.si("velocity", table.columns(columns.velocity)) if columns.velocity else None
        yield Samples(t, q, load, qd)
        row += len(table.values)


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
    typical = _typical_step(t)
    for part in parts(len(t) - 1, t):
        steps = np.diff(t[part.start : part.stop + 1])
        if (steps <= 0.0).any():
            k = int(np.argmax(steps <= 0.0))
            what, row = "stands still" if steps[k] == 0.0 else "runs back", part.start + k
            raise InputError(
                f"{raw.path}: {raw.place(row + 1)}, column {column!r}: time {what} ({t[row]:g} s, then "
                f"{t[row + 1]:g} s): remove the repeated rows or split the file"
            )
    if typical > 0.5:
        raise InputError(
            f"{raw.path}: column {column!r}: {typical:g} s from row to row: t must be in seconds; is it in ms? "
            "(--units t=ms)"
        )
    for part in parts(len(t) - 1, t):
        steps = np.diff(t[part.start : part.stop + 1])
        gap = int(np.argmax(steps))
        if steps[gap] > max(10.0 * typical, 0.25):
            row = part.start + gap
            raise InputError(
                f"{raw.path}: {raw.place(row + 1)}, column {column!r}: {steps[gap]:g} s missing after {t[row]:g} "
                "s: split the file there and give both parts"
            )


def _typical_step(t: Array) -> float:
    """Median time between rows [s]; of a long log that of a million rows all over it."""
    thin = max(1, len(t) // _MEDIAN_OF)
    release(t)
    return float(np.median(t[1::thin] - t[:-1:thin])) if len(t) > 1 else 0.0
