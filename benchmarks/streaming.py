"""One hour at 1 kHz, from an iterator to the weighted solution and its covariance, W never held.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/streaming.py [--minutes 60]

Simulated RX90, 54 parameters, white torque noise. The time the simulation itself takes is left out on every side;
for comparison stands what a Python loop over Pinocchio needs for the regressors alone, measured in the same run.
Two lengths are timed.
"""

import resource
import time
from collections.abc import Iterator

import numpy as np
from dynident.benchmarks.regressor import pinocchio_loop
from dynident.benchmarks.shared import options, show
from dynident.estimation.equations.equations import Equations
from dynident.estimation.equations.observer import Observer
from dynident.estimation.equations.reduction import reduced_pieces
from dynident.estimation.fit.least_squares import weighted
from dynident.model import Motion, base_parameters, load_robot
from dynident.model.base.rank import random_states
from dynident.model.motion import Measurement
from dynident.trajectories import RX90_NOISE, Simulator

RATE = 1000.0
PIECE = 10_000
SLOW = 0.02  # rad/s


class Source:
    """Yields a long recording piece by piece, and counts the time spent on making it."""

    def __init__(self, simulator: Simulator, samples: int) -> None:
        """Draw a Fourier motion of five harmonics whose frequencies never repeat within an hour."""
        draw = np.random.default_rng(0)
        self._simulator, self._samples = simulator, samples
        self._w = 2 * np.pi * draw.uniform(0.03, 0.6, (5, 6))
        self._a, self._phase = draw.uniform(0.1, 0.4, (5, 6)) / self._w**0.5, draw.uniform(0.0, 6.0, (5, 6))
        self.seconds = 0.0

    def __iter__(self) -> Iterator[Measurement]:
        """Pieces of ten seconds."""
        for start in range(0, self._samples, PIECE):
            before = time.perf_counter()
            t = np.arange(start, min(start + PIECE, self._samples)) / RATE
            angle = self._w * t[:, None, None] + self._phase
            sine, cosine = np.sin(angle), np.cos(angle)
            q, qd = (self._a * sine).sum(1), (self._a * self._w * cosine).sum(1)
            exact = self._simulator.measure(Motion(t, q, qd, -(self._a * self._w**2 * sine).sum(1)))
            noise = np.random.default_rng([1, start]).standard_normal(q.shape) * RX90_NOISE
            self.seconds += time.perf_counter() - before
            yield Measurement(exact.motion, exact.torque + noise)


def solved(observer: Observer, source: Source) -> tuple[Equations, float]:
    """Reduce and solve; seconds without those of the simulation."""
    start = time.perf_counter()
    problem = reduced_pieces(observer, ((piece, np.abs(piece.motion.qd) >= SLOW) for piece in source))
    weighted(problem)
    return problem, time.perf_counter() - start - source.seconds


def main() -> None:
    """Print times, memory and the comparison."""
    minutes = options(__doc__, minutes=60.0).minutes
    samples = int(minutes * 60 * RATE)
    robot = load_robot("rx90")
    simulator, observer = Simulator(robot), Observer(robot, base_parameters(robot).columns)
    solved(observer, Source(simulator, 5000))  # first calls import and load
    imported = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    _, half_seconds = solved(observer, Source(simulator, samples // 2))
    problem, seconds = solved(observer, Source(simulator, samples))
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


if __name__ == "__main__":
    main()
