"""From a log of any format, by its ending, to a recording or to a planned motion in SI units, block by block."""

import hashlib
from collections.abc import Callable, Iterator, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.paged import collected, parts
from ...model import Recording, Robot
from .arrays_log import mat_log, npz_log, parquet_log
from .columns import Columns, Naming, choose
from .csv_log import csv_log
from .map import LogMap
from .quantity import factor
from .ros_bag import ros_bag
from .table import Layout, RawLog

_READERS: dict[str, Callable[[Path, Layout], RawLog]] = {
    ".npz": npz_log,
    ".mat": mat_log,
    ".parquet": parquet_log,
    ".mcap": ros_bag,
    ".db3": ros_bag,
}
"""By ending; everything else is text."""


def open_log(path: str | Path, log_map: LogMap) -> RawLog:
    """Open a file, a ROS 2 bag's folder, or with ``LogMap.files`` a folder of files that belong together.

    Raises:
        InputError: if there is no such file, or it cannot be read.
    """
    path = Path(path)
    folder = not log_map.files and (path / "metadata.yaml").is_file()
    reader = ros_bag if folder else _READERS.get(path.suffix.lower(), csv_log)
    if log_map.layout.topic and reader is not ros_bag and path.exists():
        raise InputError(f"{path}: is no ROS 2 bag and has no topics: leave --topic, or topic in the log map, out")
    if log_map.files:
        return _joined(path, log_map)
    if not folder:
        _check_file(path)
    return reader(path, log_map.layout)


def _check_file(path: Path) -> None:
    if not path.exists():
        raise InputError(f"{path}: no such file")
    if not path.is_file():
        raise InputError(f"{path}: is not a regular file: give the path of a log file or of a ROS 2 bag")


def _joined(folder: Path, log_map: LogMap) -> RawLog:
    """Files side by side, row by row."""
    if not folder.is_dir():
        raise InputError(f"{folder}: {log_map.source} needs the folder that holds {log_map.files[0].name}")
    logs = []
    for part in log_map.files:
        path = folder / part.name
        if not path.is_file():
            raise InputError(f"{path}: no such file; {log_map.source} needs it")
        logs.append(_READERS.get(path.suffix.lower(), csv_log)(path, part))

    def blocks(columns: Sequence[str]) -> Iterator[Array]:
        shares = [(log, [name for name in columns if name in log.names]) for log in logs]
        used = [(log, names) for log, names in shares if names]
        order = [[name for _, names in used for name in names].index(name) for name in columns]
        for side_by_side in zip_longest(*(log.blocks(names) for log, names in used), fillvalue=np.empty((0, 0))):
            if len({len(part) for part in side_by_side}) > 1:
                files = ", ".join(log.path.name for log, _ in used)
                raise InputError(f"{folder}: {files} have not the same number of rows: are they of one recording?")
            yield np.hstack(side_by_side)[:, order]

    return RawLog(folder, tuple(name for log in logs for name in log.names), blocks)


_MEDIAN_OF = 1_000_000


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
    raw = opened(path, robot, log_map)
    columns = choose(raw, log_map, robot, drive_gains)
    read = hashlib.blake2b(digest_size=16)

    def pieces() -> Iterator[tuple[Array, ...]]:
        for t, q, load, *speeds in _pieces(raw, columns, log_map):
            # Row by row, so that the size of blocks does not matter.
            read.update(np.column_stack([t, q, load]).tobytes())
            yield t, q, _torques(load, robot, drive_gains) if columns.kind == "current" else load, *speeds

    widths = [1, robot.n, robot.n] + [robot.n] * bool(columns.velocity)
    times, q, torque, *speeds = collected(pieces(), widths)
    t = times.reshape(-1)
    if len(t) < 2:
        raise InputError(f"{raw.path}: {len(t)} rows of numbers: a recording needs many")
    _check_time(raw, columns.time, t)
    qd = speeds[0] if speeds else None
    return Recording(t, q, torque, qd, str(raw.path), columns.notes, read.hexdigest())


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


def opened(path: str | Path, robot: Robot, log_map: LogMap) -> RawLog:
    """A log open for reading, by a map that fits the robot.

    Raises:
        InputError: if the map is another robot's, or the log cannot be opened.
    """
    log_map.check(robot.n)
    return open_log(path, log_map)


def _torques(currents: Array, robot: Robot, gains: Sequence[float] | None) -> Array:
    """Joint torques of motor currents."""
    motors = currents * (1.0 if gains is None else np.array(gains, dtype=float))
    return robot.coupling.joint_torques(motors) if robot.coupling else motors


def _pieces(raw: RawLog, columns: Columns, log_map: LogMap) -> Iterator[tuple[Array, ...]]:
    """Rows in SI units: time, positions, torques or the motors' currents in their place, perhaps speeds."""
    row, n, first = 0, len(columns.position), len(columns.all[: bool(columns.time)])
    for values in raw.finite_blocks(columns.all):
        time, position, velocity, load = np.split(values, [first, first + n, values.shape[1] - n], axis=1)
        if columns.time:
            t = time[:, 0] * factor("time", log_map.time.unit)
        else:
            t = (row + np.arange(len(values))) / (log_map.time.rate or 1.0)
        speeds = [log_map.si("velocity", velocity)] if columns.velocity else []
        yield t, log_map.si("position", position), log_map.si(columns.kind, load), *speeds
        row += len(values)


def _check_time(raw: RawLog, column: str, t: Array) -> None:
    """Refuse times [s] that do not rise, leave a gap, or are in another unit.

    Raises:
        InputError: says where.
    """
    typical = _typical_step(t)
    for part in parts(len(t) - 1):
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
    for part in parts(len(t) - 1):
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
    return float(np.median(t[1::thin] - t[:-1:thin])) if len(t) > 1 else 0.0


class TrajectoryTable(NamedTuple):
    """A planned motion as a file holds it: times [s], positions, and speeds and accelerations where it has them."""

    t: Array
    q: Array
    qd: Array | None
    qdd: Array | None


def read_trajectory(path: str | Path, robot: Robot) -> TrajectoryTable:
    """Read a planned motion: columns ``t``, ``q1..qn``, ``qd1..qdn`` and ``qdd1..qddn`` or without the last ones.

    Other columns are not used; SI units.

    Args:
        path: the file.
        robot: tells how many joints there are.

    Raises:
        InputError: names the file, line and column of whatever cannot be used.
    """
    n, raw = robot.n, open_log(path, LogMap())
    wanted = ["t", *_numbered("q", n)]
    for kind in ("qd", "qdd"):
        if not set(_numbered(kind, n)) & set(raw.names):
            break
        wanted += _numbered(kind, n)
    missing = [name for name in wanted if name not in raw.names]
    if missing:
        raise InputError(
            f"{path}: column {', '.join(missing)} missing for a trajectory of {n} joints; found "
            f"{', '.join(raw.names)}"
        )
    if f"q{n + 1}" in raw.names:
        raise InputError(
            f"{path}: column 'q{n + 1}', but robot {robot.name!r} has {n} joints: is it the right robot?"
        )
    values = raw.whole(wanted)
    if len(values) < 2:
        raise InputError(f"{path}: {len(values)} rows of numbers: a trajectory needs more")
    _check_time(raw, "t", values[:, 0])
    q, qd, qdd = (values[:, 1 + k * n : 1 + (k + 1) * n] for k in range(3))
    return TrajectoryTable(values[:, 0], q, qd if qd.shape[1] else None, qdd if qdd.shape[1] else None)


def _numbered(prefix: str, n: int) -> list[str]:
    return [f"{prefix}{joint}" for joint in range(1, n + 1)]
