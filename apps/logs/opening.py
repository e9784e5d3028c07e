"""Opens a log of any format by its ending; files that belong together stand side by side."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Robot
from .arrays_log import mat_log, npz_log, parquet_log
from .csv_log import csv_log
from .map import LogMap
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

    def read(columns: Sequence[str]) -> Array:
        shares = [(log, [name for name in columns if name in log.names]) for log in logs]
        used = [(log, names) for log, names in shares if names]
        order = [[name for _, names in used for name in names].index(name) for name in columns]
        side_by_side = [log.read(names) for log, names in used]
        if len(set(map(len, side_by_side))) > 1:
            files = ", ".join(log.path.name for log, _ in used)
            raise InputError(f"{folder}: {files} have not the same number of rows: are they of one recording?")
        return np.hstack(side_by_side)[:, order]

    def notes() -> tuple[str, ...]:
        return tuple(f"{log.path.name}: {note}" for log in logs for note in log.notes())

    units = {name: unit for log in logs for name, unit in log.units.items()}
    return RawLog(folder, tuple(name for log in logs for name in log.names), read, units=units, notes=notes)


def opened(path: str | Path, robot: Robot, log_map: LogMap) -> RawLog:
    """A log open for reading, by a map that fits the robot.

    Raises:
        InputError: if the map is another robot's, or the log cannot be opened.
    """
    log_map.check(robot.n)
    return open_log(path, log_map)
