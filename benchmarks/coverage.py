"""How often the nominal 95 % intervals of each method hold the truth, under torque noise with or without memory.

Run: python benchmarks/coverage.py [--runs 400] [--trajectories 4] [--jobs 2] [--robust] [--memory 20]

Simulated RX90, random via points, noise as behind the paper's Table 2, the whole processing: Butterworth,
central differences, parallel decimation, slow rows left out. The paper's payload, a thin disc. With --robust the
delete-a-block jackknife beside the formula (19), with --memory AR(1) noise of that correlation time in samples, a
third as large (decimation leaves it nearly whole).
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np
from dynident.apps.commands.demo import PAYLOAD
from dynident.common.arrays import Array
from dynident.estimation import LongMotion, Settings, payload_estimate
from dynident.estimation.payload.problem import PairedMeasurement, long_motion
from dynident.estimation.signals.filtering import measurement
from dynident.model import INERTIAL, InertialParameters, Motion, Recording, base_parameters, load_robot
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points
from rich.console import Console
from rich.progress import track
from rich.table import Table
from scipy.signal import lfilter

METHODS = (1, 2, 3, 4)


class Experiment:
    """Fixed trajectories of the RX90; each run draws other noise."""

    def __init__(self, trajectories: int, memory: float = 0.0, robust: bool = False) -> None:
        """Prepare the motions and the code; ``memory`` of the noise in samples, 0 for white noise."""
        self.memory, self.robust = memory, robust
        self.robot = load_robot("rx90")
        self.base = base_parameters(self.robot)
        self.payload = PAYLOAD
        self.simulator = Simulator(self.robot)
        self.motions = [random_via_points(self.robot, 14, seed).motion(250.0) for seed in range(trajectories)]

    def problem(self, seed: int) -> LongMotion:
        """One run: recordings with and without payload, processed and reduced."""
        robot, processing = self.robot, self.robot.processing
        measured = [
            [
                measurement(self.recording(motion, load, [seed, k, side]), processing)
                for side, load in enumerate((None, self.payload))
            ]
            for k, motion in enumerate(self.motions)
        ]
        bares, loadeds = ([pair[side] for pair in measured] for side in (0, 1))
        pairs = [PairedMeasurement(bare, loaded) for bare, loaded in measured]
        settings = Settings(processing, robust=self.robust, friction_change=0.0)
        return long_motion(robot, loadeds, bares, pairs, settings)

    def recording(self, motion: Motion, load: InertialParameters | None, seed: list[int]) -> Recording:
        """A recording with the noise that was asked for."""
        if not self.memory:
            return self.simulator.record(motion, load, RX90_NOISE, seed)
        exact = self.simulator.record(motion, load)
        return replace(exact, torque=exact.torque + remembering(exact.q.shape, self.memory, seed))

    def results(self, seed: int) -> Array:
        """Formula: whether an interval holds the truth; robust: the same, and ratio of sigma; k x methods x 10."""
        problem = self.problem(seed)
        estimates = [payload_estimate(problem, method).estimate for method in METHODS]
        rows = [[self.holds(estimate.interval95) for estimate in estimates]]
        if self.robust:
            robust = [estimate.robust_interval95 for estimate in estimates]
            rows.append([self.holds(interval) for interval in robust if interval is not None])
            sigma = [estimate.sigma_robust for estimate in estimates]
            rows.append([a / b.sigma for a, b in zip(sigma, estimates, strict=True) if a is not None])
        return np.array(rows, dtype=float)

    def holds(self, interval: Array) -> Array:
        """Whether each interval holds the truth."""
        return np.asarray((interval[:, 0] <= self.payload.vector) & (self.payload.vector <= interval[:, 1]), float)


def remembering(shape: tuple[int, ...], memory: float, seed: list[int]) -> Array:
    """Stationary AR(1) noise with autocorrelation exp(-k / memory), a third of ``RX90_NOISE``; samples x joints."""
    phi = np.exp(-1.0 / memory)
    steps = np.random.default_rng(seed).standard_normal(shape) * np.sqrt(1.0 - phi**2)
    steps[0] /= np.sqrt(1.0 - phi**2)
    return np.asarray(lfilter([1.0], [1.0, -phi], steps, axis=0) * np.array(RX90_NOISE) / 3.0)


def coverage(runs: range, trajectories: int, jobs: int = 1, memory: float = 0.0, robust: bool = False) -> Array:
    """Mean of ``Experiment.results`` over runs: 1 or, with ``robust``, 3 x methods x 10."""
    if jobs == 1:
        experiment = Experiment(trajectories, memory, robust)
        return np.asarray(np.mean([experiment.results(seed) for seed in runs], axis=0))
    parts = [runs[k::jobs] for k in range(jobs)]
    with ProcessPoolExecutor(jobs) as pool:
        tasks = [pool.submit(coverage, part, trajectories, 1, memory, robust) for part in parts]
        shares = [task.result() for task in track(tasks, "runs")]
    return np.asarray(np.average(shares, axis=0, weights=[len(part) for part in parts]))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=400)
    parser.add_argument("--trajectories", type=int, default=4)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--robust", action="store_true")
    parser.add_argument("--memory", type=float, default=0.0, metavar="SAMPLES")
    arguments = parser.parse_args()
    means = coverage(
        range(arguments.runs), arguments.trajectories, arguments.jobs, arguments.memory, arguments.robust
    )
    titles = ("Coverage by the formula [%]", "Coverage by the jackknife [%]", "sigma, jackknife to formula [%]")
    for title, values in zip(titles, means, strict=False):
        Console().print(percentages(f"{title}, {arguments.runs} runs", values))


def percentages(title: str, values: Array) -> Table:
    """Methods x 10 as a table."""
    table = Table(title=title, box=None)
    for heading in ("method", *INERTIAL, "all"):
        table.add_column(heading, justify="right")
    for method, row in zip(METHODS, values, strict=True):
        table.add_row(str(method), *(f"{100 * value:.1f}" for value in (*row, row.mean())))
    return table


if __name__ == "__main__":
    main()
