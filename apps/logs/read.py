"""From an open log to a recording in SI units."""

import hashlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...estimation.signals.rows import cut, pieces
from ...model import Processing, Recording, Robot
from .clock import Clock, check_rate, clock_of
from .columns import Columns, Naming, choose
from .map import LogMap, with_units
from .opening import opened
from .table import RawLog

_MOVES = 1e-3  # rad or m: a joint that covers less does not move


def read_recordings(
    path: str | Path,
    robot: Robot,
    drive_gains: Sequence[float] | None = None,
    log_map: LogMap | None = None,
    processing: Processing | None = None,
) -> tuple[Recording, ...]:
    """Read one log: CSV, TSV (plain or gzip), NPZ, MAT, Parquet or a ROS 2 bag, split where rows are missing.

    Args:
        path: the file or folder.
        robot: tells how many joints there are.
        drive_gains: torque per current of each motor, on the joint side [N·m/A or N/A], if currents are to be used;
            of coupled drives motor j's and motor k's torques act on joint j, as (9) says.
        log_map: which columns, units, side and signs; by default those of a recorder that is known, else t, q1,
            tau1 or i1 and so on in SI units.
        processing: settings, of which the cut-off says what a gap is; the robot's own by default.

    Returns:
        The recording, or its pieces between gaps; notes tell how it was read and which columns were ignored.

    Raises:
        InputError: names the file, line and column of whatever cannot be used.
    """
    recording, _ = read_beside(path, robot, drive_gains, log_map)
    stretches = pieces(recording.t, (processing or robot.processing).cutoff, recording.source)
    return tuple(cut(recording, stretches))


def read_recording(
    path: str | Path, robot: Robot, drive_gains: Sequence[float] | None = None, log_map: LogMap | None = None
) -> Recording:
    """Read a log without gaps, as ``read_recordings``.

    Raises:
        InputError: names the file, line and column of whatever cannot be used; if gaps split it.
    """
    first, *others = read_recordings(path, robot, drive_gains, log_map)
    if others:
        raise InputError(f"{path}: {first.notes[-1]}: read_recordings gives them, or split the file")
    return first


def read_beside(
    path: str | Path,
    robot: Robot,
    drive_gains: Sequence[float] | None = None,
    log_map: LogMap | None = None,
    reference: str = "",
) -> tuple[Recording, Array]:
    """Read one log whole, perhaps with what the controller wanted.

    Args:
        path: the file or folder.
        robot: as of ``read_recordings``, like ``drive_gains`` and ``log_map``.
        drive_gains: torque per current.
        log_map: which columns, units, side and signs.
        reference: of ``REFERENCES``; empty for none.

    Returns:
        The recording, gaps in it, and the reference [rad, m, N·m or N], N x n, or N x 0 without one.

    Raises:
        InputError: names the file, line and column of whatever cannot be used.
    """
    log_map = log_map or LogMap()
    raw = opened(path, robot, log_map)
    columns = choose(raw, log_map, robot, drive_gains)
    log_map, units = _stated(raw, columns, log_map)
    beside = Naming(raw, log_map, robot).columns(reference) if reference else ()
    values, n = raw.whole([*columns.all, *beside]), len(columns.position)
    if columns.time:
        clock = clock_of(raw, columns.time, columns.time_unit, values[:, 0])
        values = values if clock.later.all() else values[clock.later]
    else:
        clock = Clock(np.arange(len(values)) / (log_map.time.rate or 1.0), np.ones(len(values), dtype=bool))
    _check_rows(raw, columns, clock.t)
    first, last = int(bool(columns.time)), len(columns.all)
    _, position, velocity, load, others = np.split(values, [first, first + n, last - n, last], axis=1)
    q, load = log_map.si("position", position), log_map.si(columns.kind, load)
    qd = log_map.si("velocity", velocity) if columns.velocity else None
    read = hashlib.blake2b(
        np.ascontiguousarray(np.column_stack([clock.t, q, load])).data, digest_size=16
    ).hexdigest()
    torque = _torques(load, robot, drive_gains) if columns.kind == "current" else load
    notes = [*raw.notes(), *units, *clock.notes, *columns.notes]
    if dead := _without_speed(q, qd):
        qd = None
        notes.append(f"speeds of joint {', '.join(map(str, dead))} are zero throughout: taken from positions")
    noted = tuple(f"{raw.path.name}: {note}" for note in notes)
    commanded = log_map.si(reference, others) if reference else q[:, :0]
    gains = tuple(drive_gains or ()) if columns.kind == "current" else ()
    return Recording(clock.t, q, torque, qd, str(raw.path), noted, read, gains, clock.origin), commanded


def _check_rows(raw: RawLog, columns: Columns, t: Array) -> None:
    """Refuse a log of too few rows, or whose times cannot be."""
    if len(t) < 2:
        raise InputError(
            f"{raw.path}: {len(t)} rows of numbers, where a recording needs many: record "
            "again, or give the file that holds them"
        )
    check_rate(raw, columns.time, t)


def _stated(raw: RawLog, columns: Columns, log_map: LogMap) -> tuple[LogMap, list[str]]:
    """A log map with the units that the file itself tells, and what to say of these."""
    units = []
    for kind, names in (
        ("position", columns.position),
        ("velocity", columns.velocity),
        (columns.kind, columns.load),
    ):
        changed = with_units(log_map, kind, names, raw.units, str(raw.path))
        if changed is not log_map:
            units.append(f"{kind} {', '.join(dict.fromkeys(changed.quantity(kind).unit))}")
        log_map = changed
    return log_map, [f"units as the file tells them: {'; '.join(units)}"] if units else []


def _without_speed(q: Array, qd: Array | None) -> list[int]:
    """Numbers of the joints that move although their recorded speeds are all zero."""
    if qd is None:
        return []
    return [int(j) + 1 for j in np.flatnonzero(~qd.any(axis=0) & (np.ptp(q, axis=0) > _MOVES))]


def holds_currents_only(path: str | Path, robot: Robot, log_map: LogMap | None = None) -> bool:
    """Whether a log carries currents but no torques.

    Raises:
        InputError: if it cannot be opened.
    """
    log_map = log_map or LogMap()
    naming = Naming(opened(path, robot, log_map), log_map, robot)
    return naming.holds("current") and not naming.holds("torque")


def holds_torques(path: str | Path, robot: Robot, log_map: LogMap | None = None) -> bool:
    """Whether a log carries torques or currents.

    Raises:
        InputError: if it cannot be opened.
    """
    log_map = log_map or LogMap()
    naming = Naming(opened(path, robot, log_map), log_map, robot)
    return naming.holds("torque") or naming.holds("current")


def _torques(currents: Array, robot: Robot, gains: Sequence[float] | None) -> Array:
    """Joint torques of motor currents."""
    motors = currents * (1.0 if gains is None else np.array(gains, dtype=float))
    return robot.coupling.joint_torques(motors) if robot.coupling else motors
