"""The simulated experiment again and again: what spread and coverage each method really has."""

from __future__ import annotations

import multiprocessing
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

from ... import model, report
from ...common.files import write_text
from ..progress import bar
from .analysis import outcome
from .figures import save_repetitions
from .paper import paper_tables
from .repeated_text import Scenario, repeated_document, repeated_numbers
from .repetition import Outcome
from .setup import TRAJECTORIES, levels, paper_robot, simulate_paper

WORKERS = 2


def run_repeated(folder: Path, seed: int, trajectories: int, count: int, gain_error: float) -> int:
    """Repeat the experiment with seeds ``seed`` to ``seed + count - 1`` and write table, figure and JSON.

    Args:
        folder: where they go; made if it is not there.
        seed: the first one.
        trajectories: for identification.
        count: number of experiments.
        gain_error: standard deviation of the drive gains in the scenario with gain errors, relative.
    """
    folder.mkdir(parents=True, exist_ok=True)
    payload = paper_tables().payload
    results: dict[int, dict[str, Outcome]] = {}
    # A new interpreter each: a copy of this one would share its compiled code's state.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(WORKERS, count), mp_context=context) as pool, bar("experiments") as progress:
        jobs = {pool.submit(one_experiment, payload, seed + k, trajectories, gain_error): k for k in range(count)}
        try:
            for job in as_completed(jobs):
                results[jobs[job]] = job.result()
                progress(len(results) / count)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    scenarios = {name: Scenario.of([results[k][name] for k in range(count)]) for name in results[0]}
    document = repeated_document(scenarios, paper_tables(), trajectories, range(seed, seed + count), gain_error)
    write_text(folder / "simulated_experiment.md", document)
    save_repetitions(
        folder / "simulated_experiment.png",
        {
            "noise as on the paper's robot": scenarios["paper"].payload,
            "slow noise (0.8 s)": scenarios["slow"].payload,
            f"drive gains wrong by {100 * gain_error:g} %": scenarios["gains"].payload,
        },
    )
    report.documents.write_json(folder / "simulated_experiment.json", repeated_numbers(scenarios))
    print(document)
    return 0


def one_experiment(
    payload: model.InertialParameters, seed: int, trajectories: int = TRAJECTORIES, gain_error: float = 0.02
) -> dict[str, Outcome]:
    """One experiment in every scenario: the same runs, recorded with other errors of measurement."""
    robot = paper_robot()
    experiment = simulate_paper(robot, payload, levels("paper"), seed, trajectories)
    recorded = {
        "paper": experiment,
        "slow": experiment.again(levels("slow")),
        "gains": experiment.again(levels("paper", gain_error)),
    }
    return {name: outcome(one, robot=name == "paper") for name, one in recorded.items()}
