"""One hour at 1 kHz, from an iterator to the weighted solution and its covariance, W never held; then constraints.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/streaming.py [--minutes 60]

Simulated RX90, 54 parameters, white torque noise. The time the simulation itself takes is left out on every side;
for comparison stands what a Python loop over Pinocchio needs for the regressors alone, measured in the same run.
Two lengths are timed. Constrained estimates start from an ``Estimate``: of 18 motions with noise as behind Table 2,
the payload by method 3, and the robot alone.
"""

import resource
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from dynident.benchmarks.coverage import repeated_problem
from dynident.benchmarks.regressor import pinocchio_loop
from dynident.benchmarks.shared import options, show
from dynident.estimation import payload_estimate, solve_constrained
from dynident.estimation.equations.equations import Equations
from dynident.estimation.equations.observer import Observer, reduced_pieces
from dynident.estimation.fit.linear_problem import weighted
from dynident.estimation.possible.robot import solve_constrained_base
from dynident.model import Motion, base_parameters, load_robot
from dynident.model.base import random_states
from dynident.model.motion import Measurement
from dynident.trajectories import RX90_NOISE, Simulator

RATE, PIECE, SLOW = 1000.0, 10_000, 0.02  # Hz, samples, rad/s


def pieces(simulator: Simulator, samples: int, spent: list[float]) -> Iterator[Measurement]:
    """A Fourier motion whose five frequencies never repeat within an hour, ten seconds each; ``spent`` on them."""
    draw = np.random.default_rng(0)
    w = 2 * np.pi * draw.uniform(0.03, 0.6, (5, 6))
    a, phase = draw.uniform(0.1, 0.4, (5, 6)) / w**0.5, draw.uniform(0.0, 6.0, (5, 6))
    for start in range(0, samples, PIECE):
        before = time.perf_counter()
        t = np.arange(start, min(start + PIECE, samples)) / RATE
        angle = w * t[:, None, None] + phase
        sine, cosine = np.sin(angle), np.cos(angle)
        q, qd = (a * sine).sum(1), (a * w * cosine).sum(1)
        exact = simulator.measure(Motion(t, q, qd, -(a * w**2 * sine).sum(1)))
        noise = np.random.default_rng([1, start]).standard_normal(q.shape) * RX90_NOISE
        spent.append(time.perf_counter() - before)
        yield Measurement(exact.motion, exact.torque + noise)


def solved(observer: Observer, simulator: Simulator, samples: int) -> tuple[Equations, float]:
    """Reduce and solve; seconds without those of the simulation."""
    start, spent = time.perf_counter(), list[float]()
    rows = ((piece, np.abs(piece.motion.qd) >= SLOW) for piece in pieces(simulator, samples, spent))
    problem = reduced_pieces(observer, rows)
    weighted(problem)
    return problem, time.perf_counter() - start - sum(spent)


def milliseconds(solve: Callable[[], Any], repeat: int) -> str:
    """Median processor time."""
    times = [time.process_time()]
    for _ in range(repeat + 1):
        solve()
        times.append(time.process_time())
    return f"{1e3 * float(np.median(np.diff(times)[1:])):.2f}"


def main() -> None:
    minutes = options(__doc__, minutes=60.0).minutes
    samples = int(minutes * 60 * RATE)
    robot = load_robot("rx90")
    simulator, observer = Simulator(robot), Observer(robot, base_parameters(robot).columns)
    solved(observer, simulator, 5000)  # first calls import and load
    imported = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    _, half_seconds = solved(observer, simulator, samples // 2)
    problem, seconds = solved(observer, simulator, samples)
    memory = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - imported) / 1024.0
    loop, start = pinocchio_loop(robot, random_states(robot, 20_000, 0)), time.perf_counter()
    loop()
    theirs = (time.perf_counter() - start) / 20_000 * samples
    rows = [
        [f"{samples} samples, {problem.equations} equations [s]", f"{seconds:.2f}"],
        ["us a sample", f"{1e6 * seconds / samples:.2f}"],
        ["time per sample over that of half of it", f"{seconds / samples / (half_seconds / (samples // 2)):.3f}"],
        ["Pinocchio loop, regressors alone, times as long", f"{theirs / seconds:.2f}"],
        ["peak memory over the imports [MiB]", f"{memory:.0f}"],
    ]
    show(f"{minutes:g} minutes at 1 kHz from an iterator", rows, asked=False)
    paper, _ = repeated_problem("disc", 0.0, 18, 4)
    free, known, base = payload_estimate(paper, 3).estimate, paper.bare, paper.base
    assert known is not None
    times = [
        ["payload [ms]", "<= 1", milliseconds(lambda: solve_constrained(free), 200)],
        ["robot [ms]", "<= 20", milliseconds(lambda: solve_constrained_base(robot, base, known), 40)],
    ]
    show("Constrained estimates, after the reduction", times)


if __name__ == "__main__":
    main()
