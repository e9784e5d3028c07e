"""The paper's experiment on a simulated RX90, from trajectories to the report."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from .... import estimation, trajectories
from ....common.files import made_folder
from ....common.progress import Progress
from ... import report, results
from ...logs.map import LogMap
from ..options import PageOptions, Setup
from ..progress import bar, status
from .setup import PAYLOAD, levels, paper_robot, reduced_experiment, simulate_paper


def demonstrate(folder: Path, seed: int, motions: int, noise: str, gain_error: float, pages: PageOptions) -> None:
    """Simulate, identify by all four methods, and print the payload beside the truth.

    Args:
        folder: of the results; made if it is not there.
        seed: of the trajectories and the noise.
        motions: each is run without and with payload; one more is held out.
        noise: "paper", "slow" or "none".
        gain_error: standard deviation of the drive gains, relative.
        pages: where the report goes, unless into the folder, and its figures.
    """
    made_folder(folder)
    with bar("simulating") as progress:
        experiment = simulate_paper(paper_robot(), levels(noise, gain_error), seed, motions, progress)
    with status("reducing") as progress:
        robot, answer = identified(experiment, progress)
    processing = experiment.robot.processing
    document = report.documents.payload_document(answer, processing, None)
    report.documents.write_json(folder / "payload.json", document)
    report.documents.write_json(
        folder / "robot.json", report.documents.identification_document(robot, processing, None)
    )
    page = _page(experiment, robot, answer, document, noise, pages)
    pages = replace(pages, report=pages.report or str(folder / "report.html"))
    pages.write_page(lambda: page)
    report.save_figure(page.drawings()[0].figure, folder / "torques.png")
    written = (*(folder / name for name in ("payload.json", "robot.json", "torques.png")), pages.report)
    pages.show(_screen(answer, str(folder / "payload.json"), ", ".join(map(str, written))))


def identified(
    experiment: trajectories.Experiment, progress: Progress
) -> tuple[estimation.Identification, estimation.PayloadAnswer]:
    """The robot from the runs without payload, and the payload by all methods; the last trajectory is held out."""
    problem = reduced_experiment(experiment, progress)
    *unloaded, last = (run.recording for run in experiment.runs[::2])
    progress("the robot alone")
    robot = estimation.identify(experiment.robot, unloaded, validation=[last], progress=progress, robust=True)
    progress("the payload")
    return robot, estimation.answer_payload(problem, held_out=[last])


def _screen(answer: estimation.PayloadAnswer, document: str, written: str) -> report.Screen:
    """The payload beside the truth, and what to type into a controller."""
    screen = report.payload_screen(answer, document)
    place = ", ".join(f"{1e3 * x:g}" for x in PAYLOAD.com)
    head = (
        f"The paper's experiment on a simulated RX90; it carries {PAYLOAD.mass:g} kg at ({place}) mm, which the "
        "identification is not told."
    )
    first = [report.Notes([head]), *screen.first, report.Notes([f"Written: {written}"])]
    return screen._replace(first=first)


def _page(
    experiment: trajectories.Experiment,
    identified: estimation.Identification,
    answer: estimation.PayloadAnswer,
    document: results.StoredPayload,
    noise: str,
    pages: PageOptions,
) -> report.Page:
    """The payload's report, the robot's parameters below."""
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
        pages.provenance(setup.in_words() | simulated),
        [answer.prediction(experiment.runs[-1].recording, True), *identified.predictions],
        others=len(experiment.runs) - 2,
        extra=(report.robot_section(identified, None),),
        origin="The paper's experiment on a simulated robot",
    )
