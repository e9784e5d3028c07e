"""Coverage of the drive gains' 95 % intervals on simulated UR10e pairs, white and lasting noise on the currents.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/gain_coverage.py [--runs 40]

Gains of bodies that can exist, payload of known mass; the formula's and the jackknife's intervals. White noise,
then AR(1) noise of 20 samples at 100 Hz. Also what a fit of torques would give.
"""

import argparse
from collections.abc import Callable

import numpy as np
from dynident.estimation import gain_problem, identify_gains
from dynident.estimation.gains import known_mass
from dynident.estimation.gains.current_side import torque_side
from dynident.model import InertialParameters, Processing, Recording, load_robot
from dynident.trajectories import Simulator, ViaPoints
from numpy.typing import NDArray

TRUTH = np.array([11.5, 12.4, 9.9, 10.4, 10.3, 10.1])
NOISE = np.array([0.5, 0.5, 0.3, 0.15, 0.15, 0.1])
BODY = InertialParameters.from_com(6.0, [0.03, 0.12, 0.06], np.diag([0.03, 0.04, 0.02]))
SETTINGS = Processing(decimate=4)
Noise = Callable[[np.random.Generator, tuple[int, ...]], NDArray[np.float64]]


def white(draw: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.float64]:
    return draw.standard_normal(shape)


def lasting(draw: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.float64]:
    from scipy.signal import lfilter

    a = np.exp(-1.0 / 20.0)
    return np.asarray(lfilter([np.sqrt(1.0 - a * a)], [1.0, -a], draw.standard_normal(shape), axis=0))


def simulator() -> Simulator:
    from dataclasses import replace

    known = {**load_robot("rx90").parameters, **{f"OFF{joint}": 0.3 * joint for joint in range(1, 7)}}
    return Simulator(replace(load_robot("ur10e"), parameters=known))


def run(runs: int, noise: Noise, name: str) -> None:
    draw = np.random.default_rng(3)
    motion = ViaPoints(draw.uniform(-1.2, 1.2, (40, 6)), draw.uniform(0.6, 1.2, 39)).motion(100.0)
    exact = [simulator().measure(motion, load).torque / TRUTH for load in (None, BODY)]
    inside: dict[str, list[NDArray[np.bool_]]] = {"formula": [], "jackknife": []}
    fitted = []
    for seed in range(runs):
        draw = np.random.default_rng([7, seed])
        pair = [
            Recording(motion.t, motion.q, i + NOISE * noise(draw, i.shape), motion.qd, f"log {k}")
            for k, i in enumerate(exact)
        ]
        problem = gain_problem(load_robot("ur10e"), pair[:1], pair[1:], SETTINGS)
        found = identify_gains(problem, known_mass(6.0))
        error = np.abs(np.log(found.values / TRUTH))
        inside["formula"].append(error < 1.96 * found.relative_sigma)
        if found.robust is not None:
            inside["jackknife"].append(error < found.robust.quantile95 * found.robust.sigma)
        free = [k for k, column in enumerate(problem.equations.columns) if column != "M_L"]
        known = np.zeros(len(problem.equations.columns))
        known[-1] = 6.0
        fitted.append(1.0 / torque_side(problem.equations.factors, free, known, None)[0] / TRUTH)
    for kind, hits in inside.items():
        shares = " ".join(f"{100 * share:.0f}" for share in np.mean(hits, axis=0))
        print(f"{name}, {kind}: {len(hits)} runs, covered {100 * np.mean(hits):.1f} % (joints {shares} %)")
    bias = " ".join(f"{100 * (value - 1):+.1f}" for value in np.mean(fitted, axis=0))
    print(f"{name}: a fit of torques is off by {bias} %")


def main() -> None:
    """Print coverage."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=40)
    runs = parser.parse_args().runs
    run(runs, white, "white noise")
    run(runs, lasting, "AR(1) noise of 20 samples")


if __name__ == "__main__":
    main()
