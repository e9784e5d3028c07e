"""Coverage of 95 % intervals where drive gains are wrong by random errors, on a simulated robot.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/gain_errors.py [--runs 100] [--robot ur10e|rx90|tx40]

Each run draws an error of every motor's gain (2 %, standard deviation), the same in all of its recordings, and the
noise; where drives are coupled a motor's error is in two joints' torques. The robot is
identified from one recording, stored, and the payload weighed by method 1 from another motion.
Three ways to count the gains' error: once, as it is shared by robot and payload (what dynident does); as if robot
and payload had errors of their own; not at all.
"""

import argparse
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from dynident.estimation import (
    Estimate,
    Gains,
    Identification,
    LongMotion,
    Settings,
    identify,
    payload_estimate,
    payload_problem,
)
from dynident.estimation.payload.methods import METHODS
from dynident.model import InertialParameters, Motion, Processing, Recording, Robot, load_robot
from dynident.trajectories import Simulator, ViaPoints
from numpy.typing import NDArray

Array = NDArray[np.float64]
GAINS = Gains((0.02,))
NOISE = [5.0, 5.0, 3.0, 1.5, 1.5, 1.0]
"""N·m, white."""
BODY = InertialParameters.from_com(6.0, [0.03, 0.12, 0.06], np.diag([0.03, 0.04, 0.02]))
SETTINGS = Processing(decimate=4)


def simulator(robot: Robot) -> Simulator:
    known = {**load_robot("rx90").parameters, **{f"OFF{joint}": 0.3 * joint for joint in range(1, 7)}}
    return Simulator(replace(robot, parameters=known))


def motion(seed: int) -> Motion:
    draw = np.random.default_rng(seed)
    return ViaPoints(draw.uniform(-1.2, 1.2, (40, 6)), draw.uniform(0.6, 1.2, 39)).motion(100.0)


def recorder(source: Simulator, load: InertialParameters | None, seed: int) -> Callable[[int, Array], Recording]:
    """One motion, simulated once; noise and gains by the run."""
    along = motion(seed)
    exact, coupling = source.measure(along, load).torque, source.robot.coupling

    def record(run: int, errors: Array) -> Recording:
        draw = np.random.default_rng([seed, run])
        torque = exact + NOISE * draw.standard_normal(exact.shape)
        motors = (1.0 + errors) * (coupling.motor_torques(torque) if coupling else torque)
        torque = coupling.joint_torques(motors) if coupling else motors
        return Recording(along.t, along.q, torque, along.qd, f"motion {seed}")

    return record


def payload_half_widths(problem: LongMotion, estimate: Estimate) -> dict[str, Array]:
    """Half of each interval of the ten, by how the gains' errors are counted."""
    assert estimate.robust is not None
    assert problem.known is not None
    alone = replace(problem, known=replace(problem.known, gain_sensitivity=np.zeros((len(problem.known.names), 6))))
    J, J_own = (METHODS[1](p).solved(estimate.weights).gain_sensitivity for p in (problem, alone))
    assert J is not None
    assert J_own is not None
    C = GAINS.covariance(6)
    counted = {
        "once, shared": J @ C @ J.T,
        "as if apart": J_own @ C @ J_own.T + (J - J_own) @ C @ (J - J_own).T,
        "not at all": 0.0 * J @ C @ J.T,
    }
    return {
        name: estimate.robust.quantile95 * np.sqrt(np.diag(estimate.robust.covariance + extra))
        for name, extra in counted.items()
    }


def robot_hits(identification: Identification, truth: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Whether intervals with and without the gains' share hold the truth."""
    with_gains, without = identification.estimate.interval95_with_gains, identification.estimate.robust_interval95
    assert with_gains is not None
    assert without is not None
    inside = [(ends[:, 0] <= truth) & (truth <= ends[:, 1]) for ends in (with_gains, without)]
    return inside[0], inside[1]


def main() -> None:
    """Print coverage."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--robot", default="ur10e")
    arguments = parser.parse_args()
    runs, robot = arguments.runs, load_robot(arguments.robot)
    source = simulator(robot)
    bare, loaded = recorder(source, None, 3), recorder(source, BODY, 4)
    hits: dict[str, list[NDArray[np.bool_]]] = {}
    widths: dict[str, list[float]] = {}
    for run in range(runs):
        errors = 0.02 * np.random.default_rng([9, run]).standard_normal(6)
        identification = identify(robot, [bare(run, errors)], Settings(SETTINGS), gains=GAINS)
        truth = identification.base.value(dict(source.robot.parameters))
        for name, hit in zip(
            ("robot, with gains", "robot, gains exact"), robot_hits(identification, truth), strict=True
        ):
            hits.setdefault(name, []).append(hit)
        problem = payload_problem(robot, [loaded(run, errors)], [], identification.estimate, Settings(SETTINGS))
        estimate = payload_estimate(problem, 1).estimate
        for name, half in payload_half_widths(problem, estimate).items():
            hits.setdefault(f"payload, {name}", []).append(np.abs(estimate.values - BODY.vector) <= half)
            widths.setdefault(name, []).append(2.0 * half[9])
    for name, inside in hits.items():
        share = 100.0 * np.mean(inside, axis=0)
        extra = ""
        if name.startswith("payload"):
            mean_width = np.mean(widths[name.removeprefix("payload, ")])
            extra = f"; mass {share[9]:.1f}, its interval {mean_width:.3f} kg"
        print(f"{name}: covered {share.min():.1f} to {share.max():.1f} %, mean {share.mean():.1f}{extra}")


if __name__ == "__main__":
    main()
