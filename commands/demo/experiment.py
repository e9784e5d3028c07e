"""The paper's experiment on a simulated RX90, from trajectories to the tables."""

import argparse
from pathlib import Path

from rich.console import Console

from ... import estimation, report
from ..progress import bar
from .analysis import Analysis, analyse
from .comparison import constrained_table, experiment_notes, paper_payload_table, table1, table2
from .figures import save_torques
from .page import write_paper_report
from .paper import paper_tables
from .setup import levels, paper_robot, simulate_paper


def run_demo(arguments: argparse.Namespace, gain_error: float) -> int:
    """Simulate, identify by all four methods, and print the result next to the truth and the paper.

    Args:
        arguments: of ``dynident demo``: folder ``out`` of the results, made if it is not there; ``seed``; number of
            ``trajectories``, each run without and with payload, one more is held out; ``noise``; ``report`` and
            ``plots``.
        gain_error: standard deviation of the drive gains, relative.
    """
    folder, disturbances = Path(arguments.out), levels(arguments.noise, gain_error)
    folder.mkdir(parents=True, exist_ok=True)
    robot, paper = paper_robot(), paper_tables()
    with bar("simulating") as progress:
        experiment = simulate_paper(
            robot, paper.payload, disturbances, arguments.seed, arguments.trajectories, progress
        )
    with Console(stderr=True).status("reducing") as status:
        analysis = analyse(experiment, status.update)
    tables = [
        *table1(analysis.answer, paper),
        table2(analysis.joint, analysis.essential, analysis.truth, paper),
        paper_payload_table(analysis.answer.estimates, paper.payload, paper),
        constrained_table(analysis.answer, paper.payload),
    ]
    notes = experiment_notes(experiment, analysis.robot, analysis.joint, analysis.held_out, paper)
    report.print_blocks([*tables, report.Notes([*notes, *report.payload_notes(analysis.answer)])])
    _save(folder, analysis)
    page = write_paper_report(arguments, analysis, [*tables, report.Notes(notes)])
    files = (*(folder / name for name in ("payload.json", "robot.json", "torques.png")), page)
    written = ", ".join(str(path) for path in files)
    report.print_blocks([report.Notes([f"Written: {written}"])])
    return 0


def _save(folder: Path, analysis: Analysis) -> None:
    problem = analysis.answer.problem
    robot, processing = problem.robot, problem.robot.processing
    report.documents.write_json(
        folder / "payload.json", report.documents.payload_document(analysis.answer, processing)
    )
    report.documents.write_json(
        folder / "robot.json", report.documents.identification_document(analysis.robot, processing, None)
    )
    observer = estimation.equations.Observer(robot, problem.base.columns)
    held_out = analysis.experiment.runs[-1].recording
    observation = observer.observe(estimation.signals.measurement(held_out, processing), processing)
    bare, joint = analysis.robot.estimate.values, analysis.joint.values
    # The payload changes the base parameters as in (25)-(28).
    with_payload = joint[: len(bare)] + estimation.payload.payload_map(problem) @ joint[len(bare) :]
    save_torques(
        folder / "torques.png",
        observation,
        [("predicted with payload (method 4)", with_payload), ("predicted without payload", bare)],
        "RX90 with 7.025 kg, a trajectory that was not used",
    )
