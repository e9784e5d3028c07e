"""How often the nominal 95 % intervals of each method hold the truth, under white torque noise.

Run: python benchmarks/coverage.py [--runs 400] [--trajectories 4] [--jobs 2]

Simulated RX90, random via points, noise as behind the paper's Table 2, the whole processing: Butterworth,
central differences, parallel decimation, slow rows left out. The paper's payload, a thin disc.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor

import numpy as np
from dynident.estimation import (
    Observer,
    PayloadProblem,
    difference_problem,
    identify_payload,
    loaded_problem,
    measurement,
    merged,
    reduced_measurement,
)
from dynident.model import INERTIAL, base_parameters, load_robot
from dynident.model.arrays import Array
from dynident.report.paper import paper_tables
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points
from rich.console import Console
from rich.progress import track
from rich.table import Table

METHODS = (1, 2, 3, 4)


class Experiment:
    """Fixed trajectories of the RX90; each run draws other noise."""

    def __init__(self, trajectories: int) -> None:
        """Prepare the motions and the code."""
        self.robot = load_robot("rx90")
        self.base = base_parameters(self.robot)
        self.payload = paper_tables().payload
        self.simulator = Simulator(self.robot)
        self.motions = [random_via_points(self.robot, 14, seed).motion(250.0) for seed in range(trajectories)]

    def problem(self, seed: int) -> PayloadProblem:
        """One run: recordings with and without payload, processed and reduced."""
        robot, base, processing = self.robot, self.base, self.robot.processing
        measured = [
            [
                measurement(self.simulator.record(motion, load, RX90_NOISE, [seed, k, side]), processing)
                for side, load in enumerate((None, self.payload))
            ]
            for k, motion in enumerate(self.motions)
        ]
        observer = Observer(robot, base.columns)
        return PayloadProblem(
            robot=robot,
            base=base,
            loaded=loaded_problem(robot, base, [loaded for _, loaded in measured], processing),
            unloaded=merged(reduced_measurement(observer, bare, processing) for bare, _ in measured),
            difference=difference_problem(robot, [(bare, loaded) for bare, loaded in measured], processing),
        )

    def hits(self, seed: int) -> Array:
        """Whether each interval holds the truth: methods x 10."""
        problem = self.problem(seed)
        rows = []
        for method in METHODS:
            interval = identify_payload(problem, method).estimate.interval95
            rows.append((interval[:, 0] <= self.payload.vector) & (self.payload.vector <= interval[:, 1]))
        return np.array(rows, dtype=float)


def coverage(runs: range, trajectories: int, jobs: int = 1) -> Array:
    """Share of runs whose interval holds the truth: methods x 10."""
    if jobs == 1:
        experiment = Experiment(trajectories)
        return np.asarray(np.mean([experiment.hits(seed) for seed in runs], axis=0))
    parts = [runs[k::jobs] for k in range(jobs)]
    with ProcessPoolExecutor(jobs) as pool:
        tasks = [pool.submit(coverage, part, trajectories) for part in parts]
        shares = [task.result() for task in track(tasks, "runs")]
    return np.asarray(np.average(shares, axis=0, weights=[len(part) for part in parts]))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=400)
    parser.add_argument("--trajectories", type=int, default=4)
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    share = coverage(range(arguments.runs), arguments.trajectories, arguments.jobs)
    table = Table(title=f"Coverage of nominal 95 % intervals, {arguments.runs} runs [%]", box=None)
    for heading in ("method", *INERTIAL, "pooled"):
        table.add_column(heading, justify="right")
    for method, row in zip(METHODS, share, strict=True):
        table.add_row(str(method), *(f"{100 * value:.1f}" for value in (*row, row.mean())))
    Console().print(table)


if __name__ == "__main__":
    main()
