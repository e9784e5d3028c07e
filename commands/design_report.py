"""The report of a designed motion."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from rich.table import Table

from ..report.arm import arm_animation, arm_strip
from ..report.figures import Drawing
from ..report.html import Html, Page, bullets, plain_page, plain_section, tag, without_namespaces
from ..report.motion_figures import motion_figure, sigma_figure
from .report import provenance

if TYPE_CHECKING:
    from ..model import Motion
    from ..trajectories import Design, Score
    from .design_problem import Request

_FILES = {
    "motion": "evaluate",
    "robot's parameters": "robot_parameters",
    "heaviest payload": "heaviest_payload",
    "scene": "scene",
}


def design_page(
    arguments: argparse.Namespace,
    request: Request,
    score: Score,
    motion: Motion,
    design: Design | None,
    told: tuple[Sequence[Table], Sequence[str]],
) -> Page:
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
    sections = [plain_section("motion", "Motion and what it would teach", tables, lines, drawings)]
    if design is not None:
        moving = plain_section("moving", "The arm in motion", (), (), [poses_drawing(design)])
        arm = tag("div", without_namespaces(arm_animation(robot, design.plan, "moving-arm")), class_="drawing wide")
        sections.append(moving.with_content(arm))
    missed = [f"Limit not kept: {limit}" for limit in score.violations]
    lead = bullets(missed) if missed else Html("<p>The motion keeps every limit.</p>")
    return plain_page(title, lead, sections, provenance(arguments, _files(arguments), {}))


def limit_drawings(request: Request, score: Score, motion: Motion) -> list[Drawing]:
    """The motion between its limits, and what it would teach where it teaches everything."""
    robot = request.problem.robot
    title = robot.title or robot.name
    limits = motion_figure(request.problem, motion, f"{title}: motion between its limits")
    drawings = [Drawing("motion", limits, _MOTION, _MOTION)]
    if np.isfinite(list(score.learnt.sigma.values())).all():
        words = f"{title}: what the motion would teach"
        figure = sigma_figure(score, words, request.reference, request.labels)
        drawings.append(Drawing("predicted_sigma", figure, _SIGMA, _SIGMA))
    return drawings


def poses_drawing(design: Design) -> Drawing:
    """The arm along the designed motion."""
    return Drawing("poses", arm_strip(design.problem.robot, design.plan), _POSES, _POSES)


_MOTION = "Positions, speeds and torques of every joint between their limits, over time."
_SIGMA = "Standard deviation that identification would leave to each parameter, predicted."
_POSES = "The arm at eight times of the motion, from the first to the last."


def _files(arguments: argparse.Namespace) -> dict[str, list[str]]:
    """Files among the arguments; a payload may also be told in words."""
    from pathlib import Path

    found = {role: [getattr(arguments, name)] for role, name in _FILES.items() if getattr(arguments, name)}
    found["earlier data"] = list(arguments.data_from or [])
    return {role: [path for path in paths if Path(path).is_file()] for role, paths in found.items()}
