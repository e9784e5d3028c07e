"""How often 95 % intervals hold the truth: the formula's, the jackknife's and the recommended ones.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/monte_carlo.py [--runs 1000] [--trajectories 18] [--noise white ar]

Simulated RX90 with the paper's payload (a thin disc: the constraint is active) and a cube (inactive); torque noise
white, AR(1) with a correlation time of 20 samples at 250 Hz, and of 20 samples after decimation. Methods 3 and 4,
and the robot's 54 parameters. The first run is compared with the library's own way from recordings to standard
deviations; from there to the intervals all is the library's.
"""

import argparse
import time
from collections.abc import Sequence

import numpy as np
from dynident.benchmarks.repeated_noise import BODIES, Experiment
from dynident.common.arrays import Array
from dynident.estimation import Estimate, solve_constrained
from dynident.estimation.fit.estimate import error_model
from dynident.estimation.possible.intervals import profile_intervals
from dynident.model import INERTIAL
from rich.console import Console
from rich.table import Table

NOISES = {"white": 0.0, "ar": 20.0, "late": 200.0}
"""Correlation time in samples at 250 Hz; decimation is by 10."""
KINDS = ("formula", "jackknife", "recommended")


def _held(ends: Array, truth: Array) -> Array:
    return np.asarray((ends[..., 0] <= truth) & (truth <= ends[..., 1]), dtype=float)


class Tally:
    """What the runs of one noise showed."""

    def __init__(self, experiment: Experiment) -> None:
        """Nothing yet."""
        self.experiment = experiment
        self.robot: dict[str, list[Array]] = {kind: [] for kind in KINDS[:2]}
        self.payload: dict[tuple[str, int, str], list[Array]] = {}
        self.squares: dict[tuple[str, int], list[Array]] = {}
        self.active: dict[tuple[str, int], int] = {}

    def add(self, known: Estimate, estimates: dict[tuple[str, int], Estimate]) -> None:
        """Count one run."""
        for kind, ends in (("formula", known.interval95), ("jackknife", known.robust_interval95)):
            if ends is not None:
                self.robot[kind].append(_held(ends, self.experiment.truth))
        upper = np.triu_indices(3)
        for (name, method), estimate in estimates.items():
            body = BODIES[name]
            result = solve_constrained(error_model(estimate))
            intervals = profile_intervals(result)
            jackknifed = estimate.robust_interval95
            assert jackknifed is not None
            three = (estimate.interval95, jackknifed, intervals.parameters)
            for kind, both in zip(KINDS, three, strict=True):
                self.payload.setdefault((name, method, kind), []).append(_held(both, body.vector))
            derived = [
                _held(intervals.com, body.com),
                _held(intervals.inertia_com[upper], body.inertia_com[upper]),
                _held(intervals.principal_moments, np.asarray(np.linalg.eigvalsh(body.inertia_com), dtype=float)),
            ]
            self.payload.setdefault((name, method, "derived"), []).append(np.concatenate(derived))
            errors = [result.values - body.vector, estimate.values - body.vector]
            self.squares.setdefault((name, method), []).append(np.square(errors))
            self.active[name, method] = self.active.get((name, method), 0) + bool(result.active)

    def tables(self, title: str, runs: int) -> list[Table]:
        """Coverage in percent; the root-mean-square ratio of XX and YY."""
        ten = _table(f"{title}: coverage of nominal 95 % intervals [%]", ("body", "method", "", *INERTIAL, "min"))
        for (name, method, kind), hits in self.payload.items():
            if kind != "derived":
                share = 100.0 * np.mean(hits, axis=0)
                ten.add_row(name, str(method), kind, *(f"{value:.1f}" for value in (*share, share.min())))
        names = [*(f"com {a}" for a in "xyz"), *INERTIAL[:6], "I1", "I2", "I3"]
        derived = _table("recommended, at the centre of mass [%]", ("body", "method", *names))
        for (name, method, kind), hits in self.payload.items():
            if kind == "derived":
                derived.add_row(name, str(method), *(f"{value:.1f}" for value in 100.0 * np.mean(hits, axis=0)))
        robot = _table("the robot's 54 parameters [%]", ("", "min", "mean", "max"))
        for kind, hits in self.robot.items():
            share = 100.0 * np.mean(hits, axis=0)
            robot.add_row(kind, *(f"{value:.1f}" for value in (share.min(), share.mean(), share.max())))
        rms = _table("rms error, constrained to free", ("body", "method", "XX", "YY", "active [%]"))
        for (name, method), squares in self.squares.items():
            ratio = np.sqrt(np.divide(*np.mean(squares, axis=0)))[[0, 3]]
            share = 100.0 * self.active[name, method] / runs
            rms.add_row(name, str(method), *(f"{value:.3f}" for value in ratio), f"{share:.0f}")
        return [ten, derived, robot, rms]


def _table(title: str, headings: Sequence[str]) -> Table:
    table = Table(title=title, box=None, title_justify="left")
    for heading in headings:
        table.add_column(heading, justify="right")
    return table


def difference(experiment: Experiment, memory: float) -> tuple[float, float]:
    """Largest difference from the library in the first run: values in sigma, and robust sigma, relative."""
    _, estimates = experiment.run(memory, 0)
    apart = []
    for method, long in experiment.by_the_library(memory, 0, "disc").items():
        short = estimates["disc", method]
        assert short.sigma_robust is not None
        assert long.sigma_robust is not None
        values = np.abs(short.values - long.values) / long.sigma
        apart.append((values.max(), np.abs(short.sigma_robust / long.sigma_robust - 1.0).max()))
    values, sigma = np.max(apart, axis=0)
    return float(values), float(sigma)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--trajectories", type=int, default=18)
    parser.add_argument("--noise", nargs="+", choices=tuple(NOISES), default=list(NOISES))
    arguments = parser.parse_args()
    console = Console(width=140)
    experiment = Experiment(arguments.trajectories)
    for noise in arguments.noise:
        start = time.process_time()
        values, sigma = difference(experiment, NOISES[noise])
        console.print(f"against the library: values {values:.1e} sigma, robust sigma {sigma:.1e}")
        tally = Tally(experiment)
        for seed in range(arguments.runs):
            tally.add(*experiment.run(NOISES[noise], seed))
        title = f"{noise} noise, {arguments.trajectories} trajectories, {arguments.runs} runs"
        console.print(*tally.tables(title, arguments.runs), f"{time.process_time() - start:.0f} s CPU", sep="\n")


if __name__ == "__main__":
    main()
