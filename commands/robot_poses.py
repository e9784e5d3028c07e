"""The part of ``dynident robot check`` that compares logged tool poses with forward kinematics."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from .. import estimation, model
from ..common.errors import InputError
from .options import Setup

_LEAST_MOVEMENT = 0.05
"""m: a tool that moves by less proves nothing."""


class CheckedLog(NamedTuple):
    """A log with tool poses: what forward kinematics leaves, and readings where that is much."""

    source: str
    check: estimation.diagnosis.PoseCheck
    readings: estimation.diagnosis.KinematicsCheck | None


def checked_poses(paths: Sequence[str], setup: Setup, progress: Callable[[str], None]) -> list[CheckedLog]:
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
        readings = None
        if not check.reproduced and not wrong_unit(check):
            readings = estimation.diagnosis.rank_readings_by_pose(
                robot, poses.q, poses.positions, poses.rotations, progress
            )
        checked.append(CheckedLog(poses.source, check, readings))
    return checked


def pose_lines(log: CheckedLog) -> list[str]:
    """The comparison in words."""
    check = log.check
    axes = "" if check.rms_angle is None else f", axes {math.degrees(check.rms_angle):.3g} deg"
    word = "reproduces" if check.reproduced else "does NOT reproduce"
    told = [
        f"{log.source}: forward kinematics {word} the tool pose of {len(check.errors)} samples: rms "
        f"{1e3 * check.rms:.3g} mm, at most {1e3 * check.errors.max():.3g} mm{axes}",
        f"  without any base and tool {1e3 * check.as_is:.4g} mm; with the ones that fit best:",
        f"  base of the robot in the log's frame: {_shown(check.base)}",
        f"  tool in the payload's frame: {_shown(check.tool, check.angles is not None)}",
    ]
    if not check.determined:
        told.append("  The motion does not tell base and tool apart: they are one choice of many.")
    unit = wrong_unit(check)
    if unit:
        told.append(f"  The tool moves {check.scale:.3g} times as far as the flange: positions in {unit}?")
    return told


def wrong_unit(check: estimation.diagnosis.PoseCheck) -> str:
    """The unit that the positions seem to be in; empty where theirs is plausible."""
    for factor, words in ((1e3, "mm that are read as m"), (1e-3, "m that are read as mm")):
        if 0.3 < check.scale / factor < 3.0:
            return words
    return ""


def _shown(pose: model.Pose, axes: bool = True) -> str:
    place = ", ".join(f"{value:.4f}" for value in pose.origin)
    turn = ", ".join(f"{math.degrees(angle) + 0.0:.2f}" for angle in pose.rpy)
    return f"({place}) m" + (f", rpy ({turn}) deg" if axes else ", axes not logged")
