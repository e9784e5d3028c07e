"""The tool's pose in a log: which columns hold it, in which unit, and its rows in SI units."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Robot
from .columns import Naming, check_missing
from .map import LogMap
from .opening import opened
from .quantity import ToolColumns, factor, standard_pose
from .table import RawLog


class ToolPoses(NamedTuple):
    """Rows of a log: ``q`` N x n [rad or m], ``positions`` N x 3 [m], ``rotations`` N x 3 x 3 or None."""

    source: str
    q: Array
    positions: Array
    rotations: Array | None


def read_tool_poses(path: str | Path, robot: Robot, log_map: LogMap | None = None) -> ToolPoses | None:
    """Read joint positions and tool poses of a log.

    Args:
        path: the file or folder.
        robot: tells how many joints there are.
        log_map: its ``pose`` names the columns; without it x, y, z [m] and qx, qy, qz, qw are taken, if there.

    Returns:
        The poses, or None if the log has none.

    Raises:
        InputError: names the file and column of whatever cannot be used.
    """
    log_map = log_map or LogMap()
    raw = opened(path, robot, log_map)
    pose = log_map.pose or standard_pose(raw.names)
    if pose is None:
        return None
    columns = (*Naming(raw, log_map, robot).columns("position"), *pose.all)
    check_missing(raw, columns)
    values = raw.whole(columns)
    if len(values) < 4:
        raise InputError(f"{raw.path}: {len(values)} rows of numbers: a tool pose is compared from 4 on")
    q, place, turn = np.split(values, [robot.n, robot.n + 3], axis=1)
    rotations = _rotations(raw, pose, turn) if pose.rotation else None
    return ToolPoses(str(raw.path), log_map.si("position", q), place * factor("position", pose.unit), rotations)


def _rotations(raw: RawLog, pose: ToolColumns, values: Array) -> Array:
    from scipy.spatial.transform import Rotation

    if pose.form == "quaternion":
        norms = np.linalg.norm(values, axis=1)
        if (abs(norms - 1.0) > 0.01).any():
            k = int(np.argmax(abs(norms - 1.0)))
            raise InputError(
                f"{raw.path}: {raw.place(k)}, columns {', '.join(pose.rotation)}: a quaternion of length "
                f"{norms[k]:.3g}: it must be 1"
            )
        return np.asarray(Rotation.from_quat(values).as_matrix())
    values = values * factor("position", pose.rotation_unit)
    if pose.form == "rpy":
        return np.asarray(Rotation.from_euler("xyz", values).as_matrix())
    return np.asarray(Rotation.from_rotvec(values).as_matrix())
