"""The simulated experiment again and again: what spread and coverage each method really has.

Run: ``python -m dynident.examples.paper 50`` writes ``simulated_experiment.md``, its figure and its numbers (JSON).
Each experiment is recorded with the noise of the paper's robot, with noise that has a memory, and with wrong gains.
"""

from __future__ import annotations

import argparse
import multiprocessing
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

from dynident.apps.commands.entry import status
from dynident.apps.commands.simulate import TRAJECTORIES
from dynident.apps.commands.values import share, whole
from dynident.common.files import write_text
from dynident.common.schema import write_json
from dynident.examples.paper.printed import paper_tables

from .figure import save_repetitions
from .repetition import Outcome, one_experiment
from .text import Scenario, repeated_document, repeated_numbers

WORKERS = 2


def main() -> None:
    """Read the command line and run."""
    parser = argparse.ArgumentParser(prog="python -m dynident.examples.paper", description=__doc__)
    parser.add_argument("count", type=whole, metavar="N", help="number of experiments")
    parser.add_argument("--out", type=Path, default=Path("demo"), metavar="DIR", help="folder (default: demo)")
    parser.add_argument("--seed", type=whole, default=0, help="of the first one (default: 0)")
    parser.add_argument("--trajectories", type=whole, default=TRAJECTORIES, metavar="N", help="default: 18")
    parser.add_argument("--gain-error", type=share, default=0.02, metavar="SHARE", help="default: 0.02")
    arguments = parser.parse_args()
    run_repeated(arguments.out, arguments.seed, arguments.trajectories, arguments.count, arguments.gain_error)


def run_repeated(folder: Path, seed: int, trajectories: int, count: int, gain_error: float) -> None:
    """Repeat the experiment with seeds ``seed`` to ``seed + count - 1`` and write table, figure and JSON.

    Args:
        folder: where they go; made if it is not there.
        seed: the first one.
        trajectories: for identification.
        count: number of experiments.
        gain_error: standard deviation of the drive gains in the scenario with gain errors, relative.
    """
    folder.mkdir(parents=True, exist_ok=True)
    results: dict[int, dict[str, Outcome]] = {}
    # A new interpreter each: a copy of this one would share its compiled code's state.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(WORKERS, count), mp_context=context) as pool, status("experiments") as progress:
        jobs = {pool.submit(one_experiment, seed + k, trajectories, gain_error): k for k in range(count)}
        try:
            for job in as_completed(jobs):
                results[jobs[job]] = job.result()
                progress("experiments", len(results) / count)
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
    write_json(folder / "simulated_experiment.json", repeated_numbers(scenarios))
    print(document)


if __name__ == "__main__":
    main()
