"""``dynident robot check``: does a recording agree with the robot's kinematics? By tool poses, and by torques."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ... import estimation
from ...common.errors import InputError
from ...common.progress import Progress
from .. import logs, report
from . import ANSWERED, DO_NOT_USE
from .options import FilterOptions, PageOptions, RobotOptions, Setup, option
from .progress import status

DESCRIPTION = """
Where a log carries the pose of the tool (columns x, y, z and qx, qy, qz, qw, or [pose] of the log map), forward
kinematics must reproduce it: the residual is told with the constant base and tool that fit best. Where it carries
torques or currents, recorded without payload, other orders, senses and zeros of the joints are ranked by what the
robot's model leaves unexplained. The best one is suggested, never applied. Exit status 1 if the pose is not
reproduced within 5 mm and 1 degree, or if another reading does clearly better.
"""
"""What its help says."""
_LEAST_MOVEMENT = 0.05
"""m: a tool that moves by less proves nothing."""


@dataclass(frozen=True)
class _Data(PageOptions):
    """The recordings, and the result as JSON and as a report, which has no figure."""

    WITHOUT: ClassVar[frozenset[str]] = frozenset({"plots"})

    data: tuple[str, ...] = option(
        reads="without payload", action="append", required=True, metavar="LOG", help="recording without payload"
    )


def run(arm: RobotOptions, processing: FilterOptions, files: _Data) -> int:
    """Run it."""
    setup = processing.setup(arm.load())
    robot = setup.robot
    with status("reading") as progress:
        poses = _checked_poses(files.data, setup, progress)
        recordings = setup.read(_with_torques(files.data, setup) if poses else files.data)
        check = None
        if recordings:
            check = estimation.rank_readings(robot, recordings, setup.processing, progress)
    files.show(report.readings_screen(poses, check))
    files.write_json(
        lambda: report.documents.robot_check_document(
            robot, [report.documents.pose_document(look) for look in poses], check
        )
    )
    files.write_page(
        lambda: report.readings_page(
            robot, poses, check, files.provenance(setup.in_words(), files, arm, processing)
        )
    )
    return ANSWERED if report.readings_agree(poses, check) else DO_NOT_USE


def _with_torques(paths: tuple[str, ...], setup: Setup) -> list[str]:
    """Logs that carry torques beside their poses."""
    return [path for path in paths if logs.holds_torques(path, setup.robot, setup.log_map)]


def _checked_poses(paths: Sequence[str], setup: Setup, progress: Progress) -> list[report.documents.PoseLook]:
    """Check every log that carries tool poses.

    Raises:
        InputError: names the log that cannot be used.
    """
    checked, robot = [], setup.robot
    for path in paths:
        poses = logs.read_tool_poses(path, robot, setup.log_map)
        if poses is None:
            continue
        progress(f"comparing tool poses of {poses.source}")
        if max(np.ptp(poses.positions, axis=0)) < _LEAST_MOVEMENT:
            raise InputError(
                f"{poses.source}: the tool moves by less than {1e3 * _LEAST_MOVEMENT:g} mm: too little to check "
                "the kinematics by; is the unit of its pose right?"
            )
        check = estimation.check_pose(robot, poses.q, poses.positions, poses.rotations)
        look = report.documents.PoseLook(poses.source, check)
        if not check.reproduced and not look.wrong_unit:
            readings = estimation.rank_readings_by_pose(robot, poses.q, poses.positions, poses.rotations, progress)
            look = look._replace(readings=readings)
        checked.append(look)
    return checked
