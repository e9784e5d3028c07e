"""The TX40 recording from memory to base parameters with standard deviations: this package and FIGAROH 1.0.2.

Run: DYNIDENT_DATA=<folder of recordings> python benchmarks/against_figaroh.py [--rounds 5]

All in one process, on one thread, in turn, from q and torque in memory; robots are loaded and files read before the
clock starts. FIGAROH goes four ways:

- functions: the sequence of its functions that its TX40 script calls, base parameters from 50,000 random states
  included; 100 Hz, decimation 10 x 10, offsets, coupled axes. The script's dense weight matrices and its essential
  parameters are left out.
- functions, recording: the same without the random states; base parameters come from the recording itself.
- class: ``initialize`` and ``solve`` of its base class, set as its later TX40 example sets them; 100 Hz, decimation
  by 10. Base parameters come from the recording here too; the coupling is left out, as there.
- class, bare: the same without validation on the same data, provenance and report.

``identify`` runs with the robot's own settings, and with those of the functions and of the class; essential
parameters included.
"""

import argparse
import contextlib
import io
import os
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

for _variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

import numpy as np  # noqa: E402
from dynident.apps.logs.read import read_recording  # noqa: E402
from dynident.benchmarks.figaroh_tx40 import CUTOFF, DECIMATE, Answer, Bare, Tx40, by_class, by_functions, prepared  # noqa: E402
from dynident.common.errors import InputError  # noqa: E402
from dynident.estimation import Settings, identify  # noqa: E402
from dynident.model import Processing, Recording, Robot, load_robot  # noqa: E402
from dynident.model.regressors import _terms as regressor_terms  # noqa: E402
from rich.console import Console  # noqa: E402
from rich.table import Table  # noqa: E402


def recorded(robot: Robot) -> Recording:
    """The TX40 recording.

    Raises:
        InputError: if its folder is not named or does not hold it.
    """
    folder = os.environ.get("DYNIDENT_DATA")
    if not folder:
        raise InputError("DYNIDENT_DATA is not set: set it to the folder of the recordings (tx40/tx40.csv.gz)")
    return read_recording(Path(folder) / "tx40" / "tx40.csv.gz", robot)


def main() -> int:
    """Print times, ratios and what each found."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    robot = load_robot("tx40")
    try:
        recording = recorded(robot)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    own, wide = robot.processing, robot.with_offsets(True)
    uncoupled = replace(wide, drives=replace(wide.drives, coupling=None))
    script = Processing(cutoff=CUTOFF, decimate=DECIMATE**2, still_speed=0.0, slow_fraction=own.slow_fraction)
    later = Processing(cutoff=CUTOFF, decimate=DECIMATE, still_speed=0.0)

    def theirs(kind: type[Tx40], solve: Callable[[Any], Answer]) -> tuple[float, Answer]:
        problem = prepared(kind, robot, recording)
        with contextlib.redirect_stdout(io.StringIO()):
            return timed(lambda: solve(problem))

    runs: dict[str, Callable[[], tuple[float, Answer]]] = {
        "FIGAROH, functions": lambda: theirs(Tx40, lambda problem: by_functions(problem, own.slow_fraction)),
        "FIGAROH, functions, recording": lambda: theirs(
            Tx40, lambda problem: by_functions(problem, own.slow_fraction, structural=False)
        ),
        "FIGAROH, class": lambda: theirs(Tx40, by_class),
        "FIGAROH, class, bare": lambda: theirs(Bare, by_class),
        "dynident": lambda: timed(lambda: ours(robot, recording, own)),
        "dynident, as the functions": lambda: timed(lambda: ours(wide, recording, script)),
        "dynident, as the class": lambda: timed(lambda: ours(uncoupled, recording, later)),
    }
    for run in list(runs.values())[1:]:
        run()  # imports, and compiled code into the cache
    Console(width=116).print(comparison([{title: run() for title, run in runs.items()} for _ in range(rounds)]))
    return 0


def ours(robot: Robot, recording: Recording, processing: Processing) -> Answer:
    """``identify``, as at the first call: the robot's symbolic terms are built anew."""
    regressor_terms.cache_clear()
    result = identify(robot, [recording], Settings(processing, robust=False))
    return Answer(len(result.estimate.sigma), result.problem.equations, result.estimate.fit.relative)


def timed(run: Callable[[], Answer]) -> tuple[float, Answer]:
    """Seconds, and the answer."""
    start = time.perf_counter()
    answer = run()
    return time.perf_counter() - start, answer


def comparison(results: list[dict[str, tuple[float, Answer]]]) -> Table:
    """Medians over the rounds, and how many times longer each of FIGAROH's ways takes."""
    medians = {title: float(np.median([result[title][0] for result in results])) for title in results[0]}
    references = list(medians.values())[:4]
    table = Table(title=f"TX40 recording, medians of {len(results)} rounds", box=None)
    table.caption = "right of the seconds: how many times longer FIGAROH takes"
    for heading in ("", "s", "functions", "recording", "class", "bare", "parameters", "equations", "residual"):
        table.add_column(heading, justify="right" if heading else "left")
    for title, seconds in medians.items():
        answer = results[-1][title][1]
        cells = [f"{reference / seconds:.1f}" for reference in references]
        counts = (str(answer.parameters), str(answer.equations), f"{100 * answer.residual:.2f} %")
        table.add_row(title, f"{seconds:.3f}", *cells, *counts)
    return table


if __name__ == "__main__":
    sys.exit(main())
