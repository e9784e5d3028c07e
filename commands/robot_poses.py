"""The part of ``dynident robot check`` that compares logged tool poses with forward kinematics."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .. import estimation, report
from ..common.errors import InputError
from ..common.progress import Progress
from .options import Setup

_LEAST_MOVEMENT = 0.05
"""m: a tool that moves by less proves nothing."""


def checked_poses(paths: Sequence[str], setup: Setup, progress: Progress) -> list[report.documents.PoseLook]:
    """Check every log that carries tool poses.

    Raises:
        InputError: names the log that cannot be used.
    """
    checked, robot = [], setup.robot
    for path in paths:
        poses = estimation.recordings.read_tool_poses(path, robot, setup.log_map)
        if poses is None:
            continue
        progress(f"comparing tool poses of {poses.source}")
        if max(np.ptp(poses.positions, axis=0)) < _LEAST_MOVEMENT:
            raise InputError(
                f"{poses.source}: the tool moves by less than {1e3 * _LEAST_MOVEMENT:g} mm: too little to check "
                "the kinematics by; is the unit of its pose right?"
            )
        check = estimation.diagnosis.check_pose(robot, poses.q, poses.positions, poses.rotations)
        look = report.documents.PoseLook(poses.source, check)
        if not check.reproduced and not look.wrong_unit:
            readings = estimation.diagnosis.rank_readings_by_pose(
                robot, poses.q, poses.positions, poses.rotations, progress
            )
            look = look._replace(readings=readings)
        checked.append(look)
    return checked
