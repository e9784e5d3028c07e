"""From a file of any log's format to a planned motion."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Robot
from .mapping import LogMap
from .opening import open_log
from .recording import check_finite, check_time


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
    parts: list[Array] = []
    for table in raw.blocks(wanted):
        check_finite(raw, table, sum(map(len, parts)))
        parts.append(table.columns(wanted))
    values = np.concatenate(parts) if parts else np.empty((0, len(wanted)))
    if len(values) < 2:
        raise InputError(f"{path}: {len(values)} rows of numbers: a trajectory needs more")
    check_time(raw, "t", values[:, 0])
    q, qd, qdd = (values[:, 1 + k * n : 1 + (k + 1) * n] for k in range(3))
    return TrajectoryTable(values[:, 0], q, qd if qd.shape[1] else None, qdd if qdd.shape[1] else None)


def _numbered(prefix: str, n: int) -> list[str]:
    return [f"{prefix}{joint}" for joint in range(1, n + 1)]
