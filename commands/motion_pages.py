"""What is shown of a motion that was designed or judged: on the terminal, as JSON and as a report."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import NamedTuple

from .. import model, report, trajectories
from .motion_request import Request
from .options import ResultFiles
from .report import provenance, write_page

FIGURE_RATE = 100.0
"""Hz: samples of a motion in figures."""
_FILES = {
    "motion": "log",
    "robot's parameters": "robot_parameters",
    "heaviest payload": "heaviest_payload",
    "scene": "scene",
}


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
    problem, reference, labels = request
    title, score, motion, design, floor, replay, source = judged
    screen = report.design_screen(problem, score, title, reference, labels, floor, replay)
    report.print_blocks(screen)
    if files.json:
        document = report.documents.design_document(
            problem, score, reference, design=design, floor=floor, evaluated=source, replay=replay
        )
        report.documents.write_json(files.json, document)
    write_page(
        arguments,
        lambda: report.design_page(
            problem, score, motion, design, screen, reference, labels, motion_provenance(arguments)
        ),
    )


def motion_provenance(arguments: argparse.Namespace) -> report.Provenance:
    """What a page was made from: the files among the arguments; a payload may also be given in words."""
    roles = {role: [getattr(arguments, name, None)] for role, name in _FILES.items()}
    roles["earlier data"] = list(getattr(arguments, "data_from", None) or [])
    files = {role: [path for path in paths if path and Path(path).is_file()] for role, paths in roles.items()}
    return provenance(arguments, files, {})
