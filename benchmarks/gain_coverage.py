"""Coverage of the drive gains' 95 % intervals on simulated pairs, white and lasting noise on the currents.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/gain_coverage.py [--runs 40] [--arm ur10e|rx90|rx90-spring|tx40]

A UR10e, two arms with coupled drives, and one with a known spring as well.

Gains of bodies that can exist, payload of known mass; the formula's and the jackknife's intervals. White noise,
then AR(1) noise of 20 samples at 100 Hz. Also what a fit of torques would give.
"""

import argparse
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from dynident.apps.commands.demo import ASSUMED_SPRING
from dynident.common.arrays import Array
from dynident.estimation import Settings, answer_gains
from dynident.estimation.gains.current_side import torque_side
from dynident.estimation.gains.known_load import known_mass
from dynident.estimation.gains.problem import gain_problem
from dynident.model import InertialParameters, Motion, Processing, Recording, Robot, load_robot
from dynident.model.drives import SPRING, parameter_kind
from dynident.trajectories import Simulator, ViaPoints
from numpy.typing import NDArray

TRUTH = {
    "ur10e": np.array([11.5, 12.4, 9.9, 10.4, 10.3, 10.1]),
    "rx90": np.array([40.0, 45.0, 38.0, 20.0, 18.0, 12.0]),
    "rx90-spring": np.array([40.0, 45.0, 38.0, 20.0, 18.0, 12.0]),
    "tx40": np.array([11.5, 12.4, 9.9, 6.4, 5.3, 4.1]),
}
"""N·m/A, of the motors on the joint side."""
NOISE = np.array([0.5, 0.5, 0.3, 0.15, 0.15, 0.1])
"""A, of the UR10e."""
RELATIVE_NOISE = 0.06
"""Of the others, of each motor's current."""
BODY = InertialParameters.from_com(6.0, [0.03, 0.12, 0.06], np.diag([0.03, 0.04, 0.02]))
SETTINGS = Processing(decimate=4)
Noise = Callable[[np.random.Generator, tuple[int, ...]], NDArray[np.float64]]


def white(draw: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.float64]:
    return draw.standard_normal(shape)


def lasting(draw: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.float64]:
    from scipy.signal import lfilter

    a = np.exp(-1.0 / 20.0)
    return np.asarray(lfilter([np.sqrt(1.0 - a * a)], [1.0, -a], draw.standard_normal(shape), axis=0))


def arm(name: str) -> Robot:
    """A robot; the RX90 perhaps with the spring that is assumed elsewhere."""
    robot = load_robot(name.split("-")[0])
    return replace(robot, drives=replace(robot.drives, spring=ASSUMED_SPRING)) if "spring" in name else robot


def simulator(name: str = "ur10e") -> Simulator:
    """A simulator of an arm with the RX90's parameters."""
    known = {**load_robot("rx90").parameters, **{f"OFF{joint}": 0.3 * joint for joint in range(1, 7)}}
    return Simulator(replace(arm(name), parameters=known))


def exact_currents(name: str) -> tuple[Motion, list[Array]]:
    """Motor currents without and with the payload."""
    robot, draw, source = arm(name), np.random.default_rng(3), simulator(name)
    middle = np.mean([joint.limits.position for joint in robot.joints], axis=1) if name == "tx40" else np.zeros(6)
    path = middle + draw.uniform(-1.2, 1.2, (40, 6))
    motion = ViaPoints(path, draw.uniform(0.6, 1.2, 39)).motion(100.0)
    torques = [source.measure(motion, load).torque for load in (None, BODY)]
    coupling = robot.coupling
    return motion, [(coupling.motor_torques(t) if coupling else t) / TRUTH[name] for t in torques]


def run(arm_name: str, runs: int, noise: Noise, name: str) -> None:
    motion, exact = exact_currents(arm_name)
    truth, level = TRUTH[arm_name], NOISE
    if arm_name != "ur10e":
        level = RELATIVE_NOISE * np.sqrt(np.mean(exact[0] ** 2, axis=0))
    inside: dict[str, list[NDArray[np.bool_]]] = {"formula": [], "jackknife": []}
    fitted = []
    for seed in range(runs):
        draw = np.random.default_rng([7, seed])
        pair = [
            Recording(motion.t, motion.q, i + level * noise(draw, i.shape), motion.qd, f"log {k}")
            for k, i in enumerate(exact)
        ]
        load = known_mass(6.0)
        problem = gain_problem(arm(arm_name), pair[:1], pair[1:], Settings(SETTINGS), load=load)
        gains = answer_gains(problem, load)
        error = np.abs(np.log(gains.values / truth))
        inside["formula"].append(error < 1.96 * gains.logarithms.sigma)
        if gains.logarithms.robust is None:
            print(f"{arm_name}, {name}, run {seed}: {gains.without_robust}")
        else:
            inside["jackknife"].append(error < gains.logarithms.robust.quantile95 * gains.logarithms.robust.sigma)
        known = np.array([1.0 if parameter_kind(c) == SPRING else 0.0 for c in problem.equations.columns])
        known[-1] = 6.0
        free = [k for k, value in enumerate(known) if value == 0.0]
        fitted.append(1.0 / torque_side(problem.equations.factors, free, known, None)[0] / truth)
    for kind, hits in inside.items():
        shares = " ".join(f"{100 * share:.0f}" for share in np.mean(hits, axis=0))
        print(
            f"{arm_name}, {name}, {kind}: {len(hits)} runs, covered {100 * np.mean(hits):.1f} % (joints {shares} %)"
        )
    bias = " ".join(f"{100 * (value - 1):+.1f}" for value in np.mean(fitted, axis=0))
    print(f"{arm_name}, {name}: a fit of torques is off by {bias} %")


def main() -> None:
    """Print coverage."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=40)
    parser.add_argument("--arm", choices=tuple(TRUTH), action="append")
    arguments = parser.parse_args()
    for name in arguments.arm or TRUTH:
        run(name, arguments.runs, white, "white noise")
        run(name, arguments.runs, lasting, "AR(1) noise of 20 samples")


if __name__ == "__main__":
    main()
