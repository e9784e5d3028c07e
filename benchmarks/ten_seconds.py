"""Ten seconds of load and a stored robot: how often the intervals of ``payload`` and ``weigh`` hold the mass.

Run: python benchmarks/ten_seconds.py [--runs 100]. First the real UR10e's loaded recording in pieces of 10 s that
begin every 5 s, with robots stored from either of its recordings without payload (found through the environment
variable DYNIDENT_DATA; left out where it is not set); then invented UR10es whose frictions under load are others by
6 %, with a torque noise that remembers 0.2 s.
"""

import argparse
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from dynident.apps.logs.read import read_recording
from dynident.benchmarks import invented
from dynident.common.arrays import Array
from dynident.estimation import Estimate, Gains, identify, payload_estimate, payload_problem
from dynident.estimation.diagnosis.joints import disagreement
from dynident.estimation.payload.by_joints import payload_by_joints
from dynident.estimation.payload.result import constrain_payload, widened
from dynident.estimation.payload.weighing import known_robot_weighing
from dynident.model import InertialParameters, Motion, Recording, Robot, load_robot
from dynident.trajectories import Simulator, random_via_points
from rich.progress import track
from scipy.signal import lfilter

GAINS, MASS = (11.976, 11.976, 9.839, 10.763, 10.757, 10.680), 2.805
BODY = InertialParameters.from_com(5.0, [0.01, -0.02, 0.1], np.diag([0.03, 0.03, 0.02]))
LENGTH, STEP, DAY, NOISE, MEMORY = 10.0, 5.0, 0.06, 0.02, 20.0
JOG = 3.0
"""s: before that the real arm jogs to the start for 0.8 s, and rests."""


class Piece(NamedTuple):
    """Ten seconds with payload, the robot's parameters, and the mass that hangs there [kg]."""

    robot: Robot
    known: Estimate
    loaded: Recording
    mass: float


def real(folder: Path) -> dict[str, list[Piece]]:
    """Pieces of the real recording, by the recording that the robot was stored from."""
    robot = load_robot("ur10e")
    loaded = read_recording(folder / "loaded_2.805kg.csv.gz", robot, GAINS)
    assert loaded.qd is not None
    moving = loaded.t[np.abs(loaded.qd).max(axis=1) > 5e-3]
    moving = moving[moving > JOG]
    pieces = {}
    for name in ("unloaded", "validation_unloaded"):
        bare = read_recording(folder / f"{name}.csv.gz", robot, GAINS)
        known = identify(robot, [bare]).estimate
        starts = np.arange(moving[0], moving[-1] - LENGTH, STEP)
        pieces[name] = [Piece(robot, known, cut(loaded, float(start)), MASS) for start in starts]
    return pieces


def cut(recording: Recording, start: float) -> Recording:
    """Ten seconds from ``start`` on."""
    keep = (recording.t >= start) & (recording.t < start + LENGTH)
    qd = recording.qd[keep] if recording.qd is not None else None
    return replace(recording, t=recording.t[keep], q=recording.q[keep], torque=recording.torque[keep], qd=qd)


def simulated(runs: int) -> Iterator[Piece]:
    """A robot stored from 25 s, ten seconds of another motion with payload on another day."""
    robot = invented.robot("ur10e")
    for seed in range(runs):
        draw = np.random.default_rng([seed, 11])
        first, second = (random_via_points(robot, 12, 2 * seed + k).motion(100.0) for k in range(2))
        changed = {
            name: value * (1.0 + DAY * float(draw.standard_normal()))
            for name, value in robot.parameters.items()
            if name.startswith(("FS", "FV"))
        }
        heavy = replace(robot, parameters={**robot.parameters, **changed})
        known = identify(robot, [_noisy(robot, first, None, draw)]).estimate
        yield Piece(robot, known, cut(_noisy(heavy, second, BODY, draw), 5.0), BODY.mass)


def _noisy(robot: Robot, motion: Motion, load: InertialParameters | None, draw: np.random.Generator) -> Recording:
    exact = Simulator(robot).record(motion, load)
    phi = float(np.exp(-1.0 / MEMORY))
    steps = np.sqrt(1.0 - phi**2) * draw.standard_normal(exact.torque.shape)
    noise = lfilter([1.0], [1.0, -phi], steps, axis=0)
    return replace(exact, torque=exact.torque + NOISE * np.sqrt(np.mean(exact.torque**2, axis=0)) * noise)


def weighed(piece: Piece, short: bool, gains: Gains | None) -> tuple[float, float, float]:
    """Mass and its interval over the true one, less 1; of ``weigh`` where ``short``."""
    robot, known, loaded, mass = piece
    make = known_robot_weighing if short else payload_problem
    problem = make(robot, [loaded], known=known)
    estimate = payload_estimate(problem, 1)
    covariance = gains.covariance(robot.n) if gains is not None else np.zeros((robot.n, robot.n))
    factor = disagreement(payload_by_joints(problem, estimate.estimate.weights), covariance, few=short)
    payload = constrain_payload(widened(estimate, factor), gains=gains)
    low, high = payload.intervals.parameters[9]
    return payload.mass / mass - 1.0, low / mass - 1.0, high / mass - 1.0


def told(name: str, rows: Array) -> str:
    """Counts of a series: error, low and high ends of intervals, pieces x 3."""
    error, low, high = rows.T
    return (
        f"{name}: {int(np.sum((low <= 0.0) & (high >= 0.0)))} of {len(rows)} hold, rms error "
        f"{100 * np.sqrt(np.mean(error**2)):.1f} %, half width {50 * np.median(high - low):.1f} % (median)"
    )


def main() -> None:
    """Print the counts."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=100)
    arguments = parser.parse_args()
    sets: dict[str, list[Piece]] = {}
    if "DYNIDENT_DATA" in os.environ:
        sets = real(Path(os.environ["DYNIDENT_DATA"]) / "ur10e")
    else:
        print("real pieces left out: DYNIDENT_DATA is not set")
    sets["simulated"] = list(simulated(arguments.runs))
    for name, pieces in sets.items():
        for short in (False, True):
            for gains in (None, Gains((0.02,) * 6)) if name != "simulated" else (None,):
                words = f"{name}, {'weigh' if short else 'payload'}{', gains to 2 %' if gains else ''}"
                rows = np.array([weighed(piece, short, gains) for piece in track(pieces, words, transient=True)])
                print(told(words, rows))
                if name != "simulated":
                    print(
                        "  error, half width [%]:",
                        ", ".join(f"{100 * e:+.1f} ±{50 * (h - lo):.1f}" for e, lo, h in rows),
                    )


if __name__ == "__main__":
    main()
