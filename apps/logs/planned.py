"""Planned motions from files of any format."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...estimation.signals.rows import typical_step
from ...model import Robot
from .clock import check_rate
from .map import LogMap
from .opening import open_log
from .table import RawLog


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
        robot: tells how many joints there are.

    Raises:
        InputError: names the file, line and column of whatever cannot be used.
    """
    n, raw = robot.n, open_log(path, LogMap())
    columns = ["t", *_numbered("q", n)]
    for kind in ("qd", "qdd"):
        if not set(_numbered(kind, n)) & set(raw.names):
            break
        columns += _numbered(kind, n)
    missing = [name for name in columns if name not in raw.names]
    if missing:
        raise InputError(
            f"{path}: column {', '.join(missing)} missing for a trajectory of {n} joints; found "
            f"{', '.join(raw.names)}"
        )
    if f"q{n + 1}" in raw.names:
        raise InputError(
            f"{path}: column 'q{n + 1}', but robot {robot.name!r} has {n} joints: is it the right robot?"
        )
    values = raw.whole(columns)
    if len(values) < 2:
        raise InputError(f"{path}: {len(values)} rows of numbers: a trajectory needs more")
    _check_planned(raw, values[:, 0])
    q, qd, qdd = (values[:, 1 + k * n : 1 + (k + 1) * n] for k in range(3))
    return TrajectoryTable(values[:, 0], q, qd if qd.shape[1] else None, qdd if qdd.shape[1] else None)


def _check_planned(raw: RawLog, t: Array) -> None:
    """Refuse times [s] of a planned motion that do not rise, leave a gap, or are in another unit."""
    steps = np.diff(t)
    k = int(np.argmax(steps <= 0.0))
    if steps[k] <= 0.0:
        fault = "stands still" if steps[k] == 0.0 else "runs back"
        raise InputError(
            f"{raw.path}: {raw.place(k + 1)}, column 't': time {fault} ({t[k]:g} s, then {t[k + 1]:g} s): remove "
            "the repeated rows"
        )
    check_rate(raw, "t", t)
    k = int(np.argmax(steps))
    if steps[k] > max(10.0 * typical_step(t), 0.25):
        raise InputError(
            f"{raw.path}: {raw.place(k + 1)}, column 't': {steps[k]:g} s missing after {t[k]:g} s: plan "
            "every moment"
        )


def _numbered(prefix: str, n: int) -> list[str]:
    return [f"{prefix}{joint}" for joint in range(1, n + 1)]
