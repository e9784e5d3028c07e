"""The report of the simulated experiment: the payload's, with the paper's tables beside its own."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from rich.table import Table

from ... import estimation, report
from ..report import provenance, settings_in_words, write_page
from .analysis import Analysis


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


def _page(
    arguments: argparse.Namespace, analysis: Analysis, tables: Sequence[Table], notes: Sequence[str]
) -> report.html.Page:
    answer, experiment = analysis.answer, analysis.experiment
    robot, base = answer.problem.robot, answer.problem.base
    processing = robot.processing
    bare, loaded = (run.recording for run in experiment.runs[-2:])
    predictions = [
        estimation.payload.payload_prediction(answer, loaded, processing, True),
        estimation.payload.robot_prediction(robot, base, analysis.robot.estimate.values, bare, processing, True),
    ]
    simulated = {
        "recordings": f"simulated: {len(experiment.runs)} runs, the last trajectory held out",
        "seed": str(experiment.seed),
        "noise": arguments.noise,
        "errors of the drive gains": f"{100.0 * experiment.disturbances.gain_error:g} %",
    }
    warnings = estimation.payload.elimination_warnings(answer)
    return report.html.payload_page(
        answer,
        report.documents.payload_document(answer, processing, None, warnings),
        predictions,
        estimation.payload.payload_excitation(answer.problem),
        provenance(arguments, {}, settings_in_words(robot, processing, None, simulated)),
        warnings,
        others=len(experiment.runs) - 2,
        extra=_extra(analysis, tables, notes),
        origin="The paper's experiment on a simulated robot",
    )


def _extra(analysis: Analysis, tables: Sequence[Table], notes: Sequence[str]) -> tuple[report.html.Section, ...]:
    return (
        report.html.plain_section("paper", "Beside the truth and the paper", tables, notes),
        report.html.robot_section(analysis.robot, None),
    )
