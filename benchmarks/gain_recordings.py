"""Coverage where the recordings that drive gains come from are used again, on a simulated UR10e.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/gain_recordings.py [--runs 60]

Gains from a pair with a weight of 6 kg (its scale exact), then a payload of 4 kg by method 4: from recordings of
its own; with the recording without payload that the gains come from; and the weight itself from the very pair. The
intervals take the gains' errors for unrelated to the recordings' noise, which is true of the first only.
"""

import argparse
from collections.abc import Callable

import numpy as np
from dynident.benchmarks.gain_coverage import BODY, NOISE, SETTINGS, TRUTH, simulator
from dynident.estimation import Gains, Settings, answer_gains, answer_payload, identify, payload_problem
from dynident.estimation.gains.known_load import known_mass
from dynident.estimation.gains.problem import gain_problem
from dynident.model import InertialParameters, Recording, load_robot
from dynident.trajectories import Simulator, ViaPoints
from numpy.typing import NDArray

Array = NDArray[np.float64]
OTHER = InertialParameters.from_com(4.0, [-0.05, 0.08, 0.09], np.diag([0.02, 0.025, 0.015]))
TEN = slice(6, 10)
"""First moments and mass."""


def currents(source: Simulator) -> Callable[[InertialParameters | None, tuple[int, ...]], Recording]:
    """One motion, simulated once per body; noise by the seed."""
    draw = np.random.default_rng(3)
    motion = ViaPoints(draw.uniform(-1.2, 1.2, (40, 6)), draw.uniform(0.6, 1.2, 39)).motion(100.0)
    exact: dict[float, Array] = {}

    def record(body: InertialParameters | None, seed: tuple[int, ...]) -> Recording:
        key = body.mass if body is not None else 0.0
        if key not in exact:
            exact[key] = source.measure(motion, body).torque / TRUTH["ur10e"]
        i = exact[key] + NOISE * np.random.default_rng(seed).standard_normal(exact[key].shape)
        return Recording(motion.t, motion.q, i, motion.qd, f"{key:g} kg, {seed}")

    return record


def scaled(recording: Recording, K: Array) -> Recording:
    return Recording(recording.t, recording.q, recording.torque * K, recording.qd, recording.source)


def payload_hits(bare: Recording, heavy: Recording, body: InertialParameters, gains: Gains) -> tuple[Array, float]:
    """Whether the recommended intervals hold first moments and mass, and the mass's width."""
    problem = payload_problem(load_robot("ur10e"), [heavy], [bare], settings=Settings(SETTINGS))
    ends = answer_payload(problem, (4,), gains=gains).recommended.intervals.parameters[TEN]
    truth = body.vector[TEN]
    return np.asarray((ends[:, 0] <= truth) & (truth <= ends[:, 1]), dtype=float), float(ends[3, 1] - ends[3, 0])


def main() -> None:
    """Print coverage."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=60)
    runs = parser.parse_args().runs
    source, robot = simulator(), load_robot("ur10e")
    record = currents(source)
    hits: dict[str, list[Array]] = {}
    widths: dict[str, list[float]] = {}
    for run in range(runs):
        first, weight, fresh = (record(b, (run, k)) for k, b in enumerate((None, BODY, None)))
        second = record(OTHER, (run, 3))
        drive_gains = answer_gains(gain_problem(robot, [first], [weight], Settings(SETTINGS)), known_mass(6.0))
        gains = Gains(identified=drive_gains.larger_relative_covariance.tolist())
        for name, (bare, heavy, body) in {
            "recordings of its own": (fresh, second, OTHER),
            "the gains' recording without payload": (first, second, OTHER),
            "the gains' own pair": (first, weight, BODY),
        }.items():
            torques = scaled(bare, drive_gains.values), scaled(heavy, drive_gains.values)
            inside, width = payload_hits(*torques, body, gains)
            hits.setdefault(f"payload, {name}", []).append(inside)
            widths.setdefault(f"payload, {name}", []).append(width)
        for name, bare in (("a recording of its own", fresh), ("the gains' recording", first)):
            estimate = identify(robot, [scaled(bare, drive_gains.values)], Settings(SETTINGS), gains=gains)
            ends, truth = (
                estimate.estimate.interval95_with_gains,
                estimate.base.value(dict(source.robot.parameters)),
            )
            assert ends is not None
            inside = np.asarray((ends[:, 0] <= truth) & (truth <= ends[:, 1]), dtype=float)
            hits.setdefault(f"robot, {name}", []).append(inside)
    for name, within in hits.items():
        share = 100.0 * np.mean(within, axis=0)
        if name in widths:
            text = " ".join(f"{value:.0f}" for value in share)
            print(f"{name}: MX MY MZ M covered {text} %, mass interval {np.mean(widths[name]):.3f} kg")
        else:
            print(f"{name}: covered {share.min():.0f} to {share.max():.0f} %, mean {share.mean():.1f}")


if __name__ == "__main__":
    main()
