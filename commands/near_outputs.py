"""Figures and report of a motion near a pose."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from rich.table import Table

from .. import report, trajectories
from ..common.files import write_text
from .report import provenance

_RATE = 100.0  # Hz
_MOTION = "Positions and speeds of every joint between its limits, and torques where they are known, over time."
_POSES = "The arm at eight times of the motion, from the first to the last."


def write_near_outputs(
    arguments: argparse.Namespace, found: trajectories.NearDesign, tables: Sequence[Table], lines: Sequence[str]
) -> None:
    """Write what ``--plots`` and ``--report`` ask for; ``tables`` and ``lines`` as the terminal has them."""
    if arguments.plots:
        _write_plots(Path(arguments.plots), found)
    if arguments.report:
        report.html.write_report(arguments.report, near_page(arguments, found, tables, lines))


def near_page(
    arguments: argparse.Namespace, found: trajectories.NearDesign, tables: Sequence[Table], lines: Sequence[str]
) -> report.html.Page:
    """What the motion shows of a payload, the motion between its limits, and the arm in motion."""
    robot, (motion, poses) = found.request.robot, _drawings(found)
    joints = ", ".join(map(str, found.request.joints))
    kept = (
        "every limit" if found.request.torque_limited else "every limit but those of torque, which were NOT checked"
    )
    lead = report.html.paragraph(
        f"{found.motion.duration:.1f} s; joints {joints} move, the others are held. Keeps {kept}."
    )
    moving = report.html.plain_section("moving", "The arm in motion", (), (), [poses])
    arm = report.html.tag(
        "div",
        report.html.without_namespaces(report.arm.arm_animation(robot, found.motion, "moving-arm")),
        class_="drawing wide",
    )
    sections = [
        report.html.plain_section("payload", "What it shows of a payload", tables, lines),
        report.html.plain_section("motion", "The motion between its limits", (), (), [motion]),
        moving.with_content(arm),
    ]
    roles = {"robot's parameters": arguments.robot_parameters, "scene": arguments.scene}
    files = {role: [path] for role, path in roles.items() if path}
    return report.html.plain_page(_title(found), lead, sections, provenance(arguments, files, {}))


def _write_plots(folder: Path, found: trajectories.NearDesign) -> None:

    report.figures.save_drawings(folder, _drawings(found))
    write_text(folder / "arm.svg", report.arm.arm_animation(found.request.robot, found.motion))


def _drawings(found: trajectories.NearDesign) -> tuple[report.figures.Drawing, report.figures.Drawing]:
    motion = report.motion_figures.motion_figure(found.design.problem, found.motion.motion(_RATE), _title(found))
    poses = report.arm.arm_strip(found.request.robot, found.motion)
    return report.figures.Drawing("motion", motion, _MOTION, _MOTION), report.figures.Drawing(
        "poses", poses, _POSES, _POSES
    )


def _title(found: trajectories.NearDesign) -> str:
    robot = found.request.robot
    return f"Motion that weighs a payload: {robot.title or robot.name}"
