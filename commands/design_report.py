"""The report of a designed motion."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.table import Table

from .. import model, report, trajectories
from .design_problem import Request
from .report import provenance

_FILES = {
    "motion": "evaluate",
    "robot's parameters": "robot_parameters",
    "heaviest payload": "heaviest_payload",
    "scene": "scene",
}


def design_page(
    arguments: argparse.Namespace,
    request: Request,
    score: trajectories.Score,
    motion: model.Motion,
    design: trajectories.Design | None,
    told: tuple[Sequence[Table], Sequence[str]],
) -> report.html.Page:
    """What the motion would teach, its limits, and the arm in motion.

    Args:
        arguments: of ``dynident design``.
        request: what was asked for.
        score: of the motion.
        motion: its samples.
        design: the designed motion; None where one was only judged.
        told: tables and lines of the terminal.
    """
    robot = request.problem.robot
    title = f"Motion for the {robot.title or robot.name}"
    tables, lines = told
    drawings = limit_drawings(request, score, motion)
    sections = [report.html.plain_section("motion", "Motion and what it would teach", tables, lines, drawings)]
    if design is not None:
        moving = report.html.plain_section("moving", "The arm in motion", (), (), [poses_drawing(design)])
        arm = report.html.tag(
            "div",
            report.html.without_namespaces(report.arm.arm_animation(robot, design.plan, "moving-arm")),
            class_="drawing wide",
        )
        sections.append(moving.with_content(arm))
    missed = [f"Limit not kept: {limit}" for limit in score.violations]
    lead = report.html.bullets(missed) if missed else report.html.Html("<p>The motion keeps every limit.</p>")
    return report.html.plain_page(title, lead, sections, provenance(arguments, _files(arguments), {}))


def limit_drawings(
    request: Request, score: trajectories.Score, motion: model.Motion
) -> list[report.figures.Drawing]:
    """The motion between its limits, and what it would teach where it teaches everything."""
    robot = request.problem.robot
    title = robot.title or robot.name
    limits = report.motion_figures.motion_figure(request.problem, motion, f"{title}: motion between its limits")
    drawings = [report.figures.Drawing("motion", limits, _MOTION, _MOTION)]
    if np.isfinite(list(score.learnt.sigma.values())).all():
        words = f"{title}: what the motion would teach"
        figure = report.motion_figures.sigma_figure(score, words, request.reference, request.labels)
        drawings.append(report.figures.Drawing("predicted_sigma", figure, _SIGMA, _SIGMA))
    return drawings


def poses_drawing(design: trajectories.Design) -> report.figures.Drawing:
    """The arm along the designed motion."""
    return report.figures.Drawing("poses", report.arm.arm_strip(design.problem.robot, design.plan), _POSES, _POSES)


_MOTION = "Positions, speeds and torques of every joint between their limits, over time."
_SIGMA = "Standard deviation that identification would leave to each parameter, predicted."
_POSES = "The arm at eight times of the motion, from the first to the last."


def _files(arguments: argparse.Namespace) -> dict[str, list[str]]:
    """Files among the arguments; a payload may also be told in words."""
    found = {role: [getattr(arguments, name)] for role, name in _FILES.items() if getattr(arguments, name)}
    found["earlier data"] = list(arguments.data_from or [])
    return {role: [path for path in paths if Path(path).is_file()] for role, paths in found.items()}
