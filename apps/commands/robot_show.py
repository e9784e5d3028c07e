"""``dynident robot show``: the modified DH table, limits and frames of a robot, and a drawing."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ... import model
from ...common.errors import InputError
from .. import report
from .. import view as views
from . import ANSWERED
from .options import FramedRobotOptions, Options, ViewOptions, in_si, option, print_lines
from .values import numbers


@dataclass(frozen=True)
class _Drawing(Options):
    """A stick figure of the robot."""

    at: tuple[float, ...] | None = option(
        type=numbers, metavar="Q1,Q2,..", help="positions to draw [deg or m] (default: 0)"
    )
    drawing: str | None = option(writes="file", metavar="F", help="write a stick figure: .png, .svg or .pdf")


def run(arm: FramedRobotOptions, drawing: _Drawing, view: ViewOptions) -> int:
    """Run it."""
    view.check_view()
    check_drawing(drawing.drawing)
    robot = arm.load()
    at = drawing.at or (0.0,) * robot.n
    if len(at) != robot.n:
        raise InputError(f"--at has {len(at)} numbers, {robot.name} has {robot.n} joints: give one per joint")
    report.print_blocks(report.robot_description(model.stand_in.rehearsed(robot)))
    if drawing.drawing:
        draw(robot, drawing.drawing, at)
    view.write_view(lambda: views.view_of(robot, _still(robot, at)))
    return ANSWERED


def _still(robot: model.Robot, at: tuple[float, ...]) -> model.Motion:
    """The arm held at positions in degrees and metres."""
    q = in_si(at, robot)[None]
    return model.Motion(np.zeros(1), q, np.zeros_like(q), np.zeros_like(q))


def check_drawing(path: str | None) -> None:
    """Refuse a drawing in a format that is not known."""
    if path and Path(path).suffix.lower() not in (".png", ".svg", ".pdf"):
        raise InputError(f"--drawing {path!r}: a drawing ends in .png, .svg or .pdf")


def draw(robot: Any, path: str, at: tuple[float, ...]) -> None:
    """Write the drawing of a robot at positions in degrees and metres, and say so."""
    q = [math.radians(x) if joint.revolute else x for x, joint in zip(at, robot.joints, strict=True)]
    shown = ", ".join(f"{x:g}" for x in at)
    report.save_drawing(path, robot, q, f"{robot.title or robot.name} at {shown} (degrees, m)")
    print_lines(f"Drawn at {shown}: {path}")
