"""The report of the simulated experiment: the payload's, with the paper's tables beside its own."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from ... import report
from ..report import provenance, settings_in_words, write_page
from .analysis import Analysis


def write_paper_report(arguments: argparse.Namespace, analysis: Analysis, screen: Sequence[report.Block]) -> Path:
    """Write the report, by default into the folder of the results; returns where.

    Args:
        arguments: of ``dynident demo``.
        analysis: what was identified.
        screen: tables beside the truth and the paper's, and the lines below them.
    """
    target = Path(arguments.report or Path(arguments.out) / "report.html")
    asked = argparse.Namespace(report=str(target), plots=arguments.plots)
    write_page(asked, lambda: _page(arguments, analysis, screen))
    return target


def _page(arguments: argparse.Namespace, analysis: Analysis, screen: Sequence[report.Block]) -> report.Page:
    answer, experiment = analysis.answer, analysis.experiment
    robot = answer.problem.robot
    processing = robot.processing
    predictions = [answer.prediction(experiment.runs[-1].recording, True), *analysis.robot.predictions]
    simulated = {
        "recordings": f"simulated: {len(experiment.runs)} runs, the last trajectory held out",
        "seed": str(experiment.seed),
        "noise": arguments.noise,
        "errors of the drive gains": f"{100.0 * experiment.disturbances.gain_error:g} %",
    }
    warnings = answer.warnings
    return report.payload_page(
        answer,
        report.documents.payload_document(answer, processing, None, warnings),
        predictions,
        answer.excitation,
        provenance(arguments, {}, settings_in_words(robot, processing, None, simulated)),
        warnings,
        others=len(experiment.runs) - 2,
        extra=(
            report.Section("paper", "Beside the truth and the paper", screen),
            report.robot_section(analysis.robot, None),
        ),
        origin="The paper's experiment on a simulated robot",
    )
