"""Backward elimination: both stop rules, and what downdating gains over refits.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/essential.py [--repeat 50]

Simulated RX90 with noise as behind Table 2; with DYNIDENT_DATA the real TX40 recording too. A refit takes the
triangular factor of the kept columns from the reduced problem and solves it; times are the processor's.
"""

import argparse
import os
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from dynident.apps.logs.read import read_recording
from dynident.estimation import Identification, Settings, SigmaBound, SigmaRatio, identify
from dynident.estimation.answers.identification import impossible_robot
from dynident.estimation.fit.essential import eliminate
from dynident.estimation.fit.least_squares import weighted
from dynident.model import load_robot
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points
from rich.console import Console


def refitted(result: Identification) -> tuple[list[str], list[float]]:
    """Order and errors of the elimination down to no parameter, each set solved anew."""
    problem, weights = result.problem, result.estimate.weights
    essential = list(problem.columns)
    order: list[str] = []
    errors: list[float] = []
    while essential:
        estimate = weighted(problem.select(essential), weights)
        error = np.linalg.norm(weights * estimate.fit.error_norms)
        errors.append(float(error / np.sqrt(estimate.degrees_of_freedom)))
        relative = estimate.sigma / np.abs(estimate.values)
        order.append(essential.pop(int(np.argmax(relative))))
    return order, errors


def median_ms(call: Callable[[], object], repeat: int) -> float:
    """Median processor time in milliseconds, after one call that is not counted."""
    call()
    times = []
    for _ in range(repeat):
        start = time.process_time()
        call()
        times.append(time.process_time() - start)
    return 1e3 * float(np.median(times))


def report(console: Console, result: Identification, repeat: int) -> None:
    """Print one robot's figures."""
    name = result.robot.title or result.robot.name
    for rule in (SigmaRatio(), SigmaBound(0.10), SigmaBound(0.05)):
        elimination = eliminate(result.problem, result.estimate, rule)
        against = impossible_robot(result.robot, result.base, result.estimate, elimination)
        console.print(
            f"{name}: {len(elimination.essential)} of {len(elimination.path.order)} essential "
            f"({rule.description}); error's sigma {elimination.sigma_ratio:.4f} times, largest relative sigma "
            f"{100.0 * elimination.largest_relative_sigma:.1f} %, {'impossible' if against else 'possible'}"
        )
    path = result.elimination.path
    order, errors = refitted(result)
    apart = np.abs(path.sigma_ratio[:-1] / (np.array(errors) / errors[0]) - 1.0).max()
    fast = median_ms(lambda: eliminate(result.problem, result.estimate), repeat)
    slow = median_ms(lambda: refitted(result), max(repeat // 5, 3))
    console.print(
        f"  whole path by downdating {fast:.2f} ms, by refits {slow:.2f} ms ({slow / fast:.1f} times); "
        f"order equal: {list(path.order) == order}, error's sigma apart by {apart:.1e}"
    )


def main() -> None:
    """Print all figures."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--repeat", type=int, default=50)
    repeat = parser.parse_args().repeat
    console = Console(width=160)
    robot = load_robot("rx90")
    simulator = Simulator(robot)
    motions = [random_via_points(robot, 14, seed=k).motion(250.0) for k in range(18)]
    records = [simulator.record(m, None, RX90_NOISE, [0, k, 0], f"trajectory {k}") for k, m in enumerate(motions)]
    report(console, identify(robot, records, Settings(robust=False)), repeat)
    folder = os.environ.get("DYNIDENT_DATA")
    if folder:
        tx40 = load_robot("tx40")
        real = read_recording(Path(folder) / "tx40/tx40.csv.gz", tx40)
        report(console, identify(tx40, [real], Settings(robust=False)), repeat)


if __name__ == "__main__":
    main()
