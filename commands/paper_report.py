"""The report of the simulated experiment: the payload's, with the paper's tables beside its own."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.table import Table

from ..estimation.payload import elimination_warnings, payload_excitation, payload_prediction, robot_prediction
from ..report.documents import payload_document
from ..report.html import Page, Section, payload_page, plain_section, robot_section
from .report import provenance, settings_in_words, write_page

if TYPE_CHECKING:
    from .paper_analysis import Analysis


def write_paper_report(
    arguments: argparse.Namespace, analysis: Analysis, tables: Sequence[Table], notes: Sequence[str]
) -> Path:
    """Write the report, by default into the folder of the results; returns where.

    Args:
        arguments: of ``dynident demo``.
        analysis: what was identified.
        tables: beside the truth and the paper's.
        notes: below them.
    """
    target = Path(arguments.report or Path(arguments.out) / "report.html")
    asked = argparse.Namespace(report=str(target), plots=arguments.plots)
    write_page(asked, lambda: _page(arguments, analysis, tables, notes))
    return target


def _page(arguments: argparse.Namespace, analysis: Analysis, tables: Sequence[Table], notes: Sequence[str]) -> Page:
    answer, experiment = analysis.answer, analysis.experiment
    robot, base = answer.problem.robot, answer.problem.base
    processing = robot.processing
    bare, loaded = (run.recording for run in experiment.runs[-2:])
    predictions = [
        payload_prediction(answer, loaded, processing, True),
        robot_prediction(robot, base, analysis.robot.estimate.values, bare, processing, True),
    ]
    simulated = {
        "recordings": f"simulated: {len(experiment.runs)} runs, the last trajectory held out",
        "seed": str(experiment.seed),
        "noise": arguments.noise,
        "errors of the drive gains": f"{100.0 * experiment.disturbances.gain_error:g} %",
    }
    warnings = elimination_warnings(answer)
    return payload_page(
        answer,
        payload_document(answer, processing, None, warnings),
        predictions,
        payload_excitation(answer.problem),
        provenance(arguments, {}, settings_in_words(robot, processing, None, simulated)),
        warnings,
        others=len(experiment.runs) - 2,
        extra=_extra(analysis, tables, notes),
        origin="The paper's experiment on a simulated robot",
    )


def _extra(analysis: Analysis, tables: Sequence[Table], notes: Sequence[str]) -> tuple[Section, ...]:
    return (
        plain_section("paper", "Beside the truth and the paper", tables, notes),
        robot_section(analysis.robot, None),
    )
