"""What is shown of a motion: on the terminal, as JSON, as figures and as a report."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from rich.table import Table

from .. import model, report, trajectories
from ..common.files import write_text
from .motion_request import Request
from .options import ResultFiles
from .report import provenance

FIGURE_RATE = 100.0
"""Hz: samples of a motion in figures."""
_FILES = {
    "motion": "log",
    "robot's parameters": "robot_parameters",
    "heaviest payload": "heaviest_payload",
    "scene": "scene",
}
_MOTION = "Positions, speeds and torques of every joint between their limits, over time."
_SIGMA = "Standard deviation that identification would leave to each parameter, predicted."
_NEAR = "Positions and speeds of every joint between its limits, and torques where they are known, over time."
_POSES = "The arm at eight times of the motion, from the first to the last."


class Judged(NamedTuple):
    """A motion with its score.

    Attributes:
        title: of the score's table.
        score: of the motion.
        motion: its samples.
        design: the designed motion; None where one was only judged.
        floor: under the criterion, if it was asked for and found.
        replay: score of what a controller makes of the motion by its own profiles.
        source: file of a motion that was only judged.
    """

    title: str
    score: trajectories.Score
    motion: model.Motion
    design: trajectories.Design | None = None
    floor: trajectories.design.Floor | None = None
    replay: trajectories.Score | None = None
    source: str | None = None


def show(arguments: argparse.Namespace, files: ResultFiles, request: Request, judged: Judged) -> None:
    """Print the score, and write it in the forms asked for."""
    results, kind, score = report.design_results, request.problem.criterion.kind, judged.score
    sigmas = results.sigma_table(score, request.reference, request.labels)
    tables = [results.score_table(request.problem, score, judged.title), *([sigmas] if sigmas is not None else [])]
    lines = [f"Criterion {results.criterion_text(kind, score.value)}."]
    if judged.floor is not None:
        lines.append(results.floor_note(kind, judged.floor))
    if judged.replay is not None:
        lines.append(results.replay_note(kind, judged.replay))
    print_all(tables, lines)
    if files.json:
        document = report.documents.design_document(
            request.problem,
            score,
            request.reference,
            design=judged.design,
            floor=judged.floor,
            evaluated=judged.source,
            replay=judged.replay,
        )
        report.documents.write_json(files.json, document)
    if files.plots or files.report:
        drawings, arm = _drawings(request, judged), None if judged.design is None else judged.design.plan
        if files.plots:
            write_plots(Path(files.plots), drawings, request.problem.robot, arm)
        if files.report:
            page = _score_page(arguments, request, judged, drawings, tables, lines)
            report.html.write_report(files.report, page)


def print_all(tables: Sequence[Table], lines: Sequence[str]) -> None:
    """Print tables, then lines."""
    terminal = report.tables.console(*tables)
    terminal.print(*tables)
    for line in lines:
        terminal.print(line, markup=False, highlight=False)


def write_plots(
    folder: Path,
    drawings: Sequence[report.figures.Drawing],
    robot: model.Robot,
    plan: trajectories.motions.Plan | None,
) -> None:
    """Write figures, and the arm in motion where there is a plan."""
    report.figures.save_drawings(folder, drawings)
    if plan is not None:
        write_text(folder / "arm.svg", report.arm.arm_animation(robot, plan))


def near_page(
    arguments: argparse.Namespace, result: report.near.NearResult, tables: Sequence[Table], lines: Sequence[str]
) -> report.html.Page:
    """What a motion near a pose shows of a payload, the motion between its limits, and the arm in motion."""
    motion, poses = near_drawings(result)
    joints = ", ".join(map(str, result.shape.joints))
    limited = result.design.problem.torque_limited
    kept = "every limit" if limited else "every limit but those of torque, which were NOT checked"
    lead = report.html.paragraph(
        f"{result.motion.duration:.1f} s; joints {joints} move, the others are held. Keeps {kept}."
    )
    sections = [
        report.html.plain_section("payload", "What it shows of a payload", tables, lines),
        report.html.plain_section("motion", "The motion between its limits", (), (), [motion]),
        _moving_section(result.robot, result.motion, poses),
    ]
    return report.html.plain_page(_near_title(result), lead, sections, _provenance(arguments))


def near_drawings(result: report.near.NearResult) -> tuple[report.figures.Drawing, report.figures.Drawing]:
    """The motion between its limits, and the arm along it."""
    samples = result.motion.motion(FIGURE_RATE)
    figure = report.motion_figures.motion_figure(result.design.problem, samples, _near_title(result))
    return report.figures.Drawing("motion", figure, _NEAR, _NEAR), _poses(result.robot, result.motion)


def _near_title(result: report.near.NearResult) -> str:
    return f"Motion that weighs a payload: {result.robot.title or result.robot.name}"


def _score_page(
    arguments: argparse.Namespace,
    request: Request,
    judged: Judged,
    drawings: Sequence[report.figures.Drawing],
    tables: Sequence[Table],
    lines: Sequence[str],
) -> report.html.Page:
    """What the motion would teach, its limits, and the arm in motion."""
    robot = request.problem.robot
    limits = [drawing for drawing in drawings if drawing.name != "poses"]
    sections = [report.html.plain_section("motion", "Motion and what it would teach", tables, lines, limits)]
    if judged.design is not None:
        sections.append(_moving_section(robot, judged.design.plan, drawings[-1]))
    missed = [f"Limit not kept: {limit}" for limit in judged.score.violations]
    lead = report.html.bullets(missed) if missed else report.html.Html("<p>The motion keeps every limit.</p>")
    title = f"Motion for the {robot.title or robot.name}"
    return report.html.plain_page(title, lead, sections, _provenance(arguments))


def _moving_section(
    robot: model.Robot, plan: trajectories.motions.Plan, poses: report.figures.Drawing
) -> report.html.Section:
    """The arm along a motion, in steps and moving."""
    moving = report.html.plain_section("moving", "The arm in motion", (), (), [poses])
    animation = report.html.without_namespaces(report.arm.arm_animation(robot, plan, "moving-arm"))
    return moving.with_content(report.html.tag("div", animation, class_="drawing wide"))


def _drawings(request: Request, judged: Judged) -> list[report.figures.Drawing]:
    """The motion between its limits; what it would teach, if it teaches everything; a designed motion's poses."""
    robot, score = request.problem.robot, judged.score
    title = robot.title or robot.name
    words = f"{title}: motion between its limits"
    limits = report.motion_figures.motion_figure(request.problem, judged.motion, words)
    drawings = [report.figures.Drawing("motion", limits, _MOTION, _MOTION)]
    if np.isfinite(list(score.learnt.sigma.values())).all():
        words = f"{title}: what the motion would teach"
        figure = report.motion_figures.sigma_figure(score, words, request.reference, request.labels)
        drawings.append(report.figures.Drawing("predicted_sigma", figure, _SIGMA, _SIGMA))
    if judged.design is not None:
        drawings.append(_poses(robot, judged.design.plan))
    return drawings


def _poses(robot: model.Robot, plan: trajectories.motions.Plan) -> report.figures.Drawing:
    return report.figures.Drawing("poses", report.arm.arm_strip(robot, plan), _POSES, _POSES)


def _provenance(arguments: argparse.Namespace) -> report.html.Provenance:
    """What the page was made from: the files among the arguments; a payload may also be given in words."""
    roles = {role: [getattr(arguments, name, None)] for role, name in _FILES.items()}
    roles["earlier data"] = list(getattr(arguments, "data_from", None) or [])
    files = {role: [path for path in paths if path and Path(path).is_file()] for role, paths in roles.items()}
    return provenance(arguments, files, {})
