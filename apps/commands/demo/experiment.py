"""The paper's experiment on a simulated RX90, from trajectories to the tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from .... import estimation, model
from ....common.files import made_folder
from ... import report, results
from ...logs.map import LogMap
from ..options import PageOptions, Setup
from ..progress import bar, status
from .analysis import Analysis, analyse
from .comparison import constrained_table, experiment_notes, paper_payload_table, table1, table2
from .paper import paper_tables
from .setup import levels, paper_robot, simulate_paper


def demonstrate(
    folder: Path, seed: int, trajectories: int, noise: str, gain_error: float, pages: PageOptions
) -> None:
    """Simulate, identify by all four methods, and print the result next to the truth and the paper.

    Args:
        folder: of the results; made if it is not there.
        seed: of the trajectories and the noise.
        trajectories: each is run without and with payload; one more is held out.
        noise: "paper", "slow" or "none".
        gain_error: standard deviation of the drive gains, relative.
        pages: where the report goes, unless into the folder, and its figures.
    """
    made_folder(folder)
    robot, paper = paper_robot(), paper_tables()
    with bar("simulating") as progress:
        experiment = simulate_paper(robot, paper.payload, levels(noise, gain_error), seed, trajectories, progress)
    with status("reducing") as progress:
        analysis = analyse(experiment, progress)
    answer = analysis.answer
    tables = [
        *table1(answer, paper),
        table2(analysis.joint, analysis.essential, analysis.truth, paper),
        paper_payload_table(answer.estimates, paper.payload, paper),
        constrained_table(answer, paper.payload),
    ]
    notes = experiment_notes(experiment, analysis.robot, analysis.joint, analysis.held_out, paper)
    processing = robot.processing
    document = report.documents.payload_document(answer, processing, None)
    report.documents.write_json(folder / "payload.json", document)
    identified = report.documents.identification_document(analysis.robot, processing, None)
    report.documents.write_json(folder / "robot.json", identified)
    page = _page(analysis, document, [*tables, report.Notes(notes)], noise, pages)
    pages = replace(pages, report=pages.report or str(folder / "report.html"))
    pages.write_page(lambda: page)
    report.save_figure(page.drawings()[0].figure, folder / "torques.png")
    written = (*(folder / name for name in ("payload.json", "robot.json", "torques.png")), pages.report)
    shown = _screen(answer, paper.payload, str(folder / "payload.json"), ", ".join(map(str, written)))
    pages.show(shown._replace(details=[*tables, report.Notes(notes), *shown.details]))


def _screen(
    answer: estimation.PayloadAnswer, truth: model.InertialParameters, document: str, written: str
) -> report.Screen:
    """The payload beside the truth, and what to type into a controller."""
    screen = report.payload_screen(answer, document)
    place = ", ".join(f"{1e3 * x:g}" for x in truth.com)
    head = (
        f"The paper's experiment on a simulated RX90; it carries {truth.mass:g} kg at ({place}) mm, which the "
        "identification is not told."
    )
    first = [report.Notes([head]), *screen.first, report.Notes([f"Written: {written}"])]
    return report.Screen(first, screen.details, f"the paper's tables beside these, {screen.more}")


def _page(
    analysis: Analysis,
    document: results.StoredPayload,
    screen: Sequence[report.Block],
    noise: str,
    pages: PageOptions,
) -> report.Page:
    """The payload's report, with the paper's tables beside its own."""
    answer, experiment = analysis.answer, analysis.experiment
    robot = answer.problem.robot
    setup = Setup(robot, robot.processing, None, None, LogMap(source="simulated"))
    simulated = {
        "recordings": f"simulated: {len(experiment.runs)} runs, the last trajectory held out",
        "seed": str(experiment.seed),
        "noise": noise,
        "errors of the drive gains": f"{100.0 * experiment.disturbances.gain_error:g} %",
    }
    return report.payload_page(
        answer,
        document,
        [answer.prediction(experiment.runs[-1].recording, True), *analysis.robot.predictions],
        answer.excitation,
        pages.provenance(setup.in_words() | simulated),
        others=len(experiment.runs) - 2,
        extra=(
            report.Section("paper", "Beside the truth and the paper", screen),
            report.robot_section(analysis.robot, None),
        ),
        origin="The paper's experiment on a simulated robot",
    )
