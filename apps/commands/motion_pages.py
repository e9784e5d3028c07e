"""What is shown of a motion that was designed or judged: on the terminal, as JSON and as a report."""

from __future__ import annotations

from typing import NamedTuple

from ... import model, trajectories
from .. import report
from .motion_request import Request
from .options import Options, PageOptions

FIGURE_RATE = 100.0
"""Hz: samples of a motion in figures."""


class Judged(NamedTuple):
    """A motion with its score.

    Attributes:
        title: of the score's table.
        design: the designed motion; None where one was only judged.
        floor: under the criterion, if it was asked for and found.
        replay: score of what a controller makes of the motion by its own profiles.
        source: file of a motion that was only judged.
    """

    title: str
    score: trajectories.Score
    motion: model.Motion
    design: trajectories.Design | None = None
    floor: trajectories.Floor | None = None
    replay: trajectories.Score | None = None
    source: str | None = None


def show(files: PageOptions, request: Request, judged: Judged, *parts: Options) -> None:
    """Print the score, and write it in the forms asked for; ``parts``: options that name files."""
    problem, reference, labels = request
    title, score, motion, design, floor, replay, source = judged
    screen = report.design_screen(problem, score, title, reference, labels, floor, replay, design is not None)
    files.show(screen)
    files.write_json(
        lambda: report.documents.design_document(
            problem, score, reference, design=design, floor=floor, evaluated=source, replay=replay
        )
    )
    files.write_page(
        lambda: report.design_page(
            problem, score, motion, design, screen.blocks, reference, labels, files.provenance({}, *parts)
        )
    )
