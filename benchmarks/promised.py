"""Standard deviations that a motion promises, beside those that its simulated recordings show.

The errors are as designs assume them (0.72 % of the torque limits, 10 independent a second), of exponential memory.
Run: OPENBLAS_NUM_THREADS=1 python benchmarks/promised.py [--seeds 2]
"""

import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from dynident import trajectories
from dynident.apps.report.documents import as_recorded, planned
from dynident.apps.results import shown_noise
from dynident.benchmarks.shared import options, show
from dynident.common.arrays import Array
from dynident.common.schema import write_json
from dynident.estimation import Settings, identify, identify_payload
from dynident.estimation.payload.long_motion import frame_change
from dynident.estimation.results.payload import FreeEstimate, numbers
from dynident.model import InertialParameters, load_robot, stand_in
from dynident.model.files.robot_file import robot_names
from dynident.trajectories.simulation import record

BODY = InertialParameters.from_com(2.5, [0.01, 0.03, 0.08], np.diag([0.0125, 0.0132, 0.007]))


class Ratios(NamedTuple):
    """What was shown over what was promised, geometric means over the parameters."""

    robot: float  # standard deviations by the jackknife
    payload: float
    mass: float  # the payload's alone
    error: float  # rms of the payload's errors over what was promised
    noise: float  # of each joint as ``--like`` reads it from the identified robot, at the same rate
    condition: float  # of W as ``identify`` has it


def promised_and_shown(name: str, seed: int) -> Ratios:
    """One random motion of an arm, simulated without and with a payload."""
    robot = stand_in.rehearsed(load_robot(name))
    sigma, rate = trajectories.assumed_noise(robot), trajectories.INDEPENDENT
    errors, arm = trajectories.remembered_disturbances(sigma, rate), trajectories.Simulator(robot)
    plan = trajectories.random_via_points(robot, count=14, seed=seed)
    motion = plan.motion(250.0)
    unloaded, loaded = (
        record(arm.measure(motion, body), errors, np.ones(robot.n), [seed, k])
        for k, body in enumerate((None, BODY))
    )
    of_robot, of_payload = (
        as_recorded(trajectories.build_design(robot, None, goal), planned(robot, motion))
        for goal in (trajectories.Goal(), trajectories.Goal(payload_only=True))
    )
    settings = Settings(friction=robot.drives.friction)
    identified = identify(robot, [unloaded], settings)
    weighed = identify_payload(robot, [loaded], [unloaded], settings=settings)
    method = weighed.recommended.method if weighed.recommended else 3
    free = next(one for one in weighed.estimates if isinstance(one, FreeEstimate) and one.method == method)
    T = np.linalg.inv(frame_change(robot.flange))
    assert of_payload.covariance is not None
    expected = np.sqrt(np.diag(T @ of_payload.covariance @ T.T))
    shown = numbers(free.sigma_robust) / expected
    with tempfile.TemporaryDirectory() as folder:
        write_json(Path(folder) / "robot.json", identified.result)
        seen, seen_rate = shown_noise(Path(folder) / "robot.json")
    promised = np.array([of_robot.sigma[column] for column in identified.estimate.names])
    robust = identified.estimate.sigma_robust
    assert robust is not None
    return Ratios(
        _mean(robust / promised),
        _mean(shown),
        float(shown[-1]),
        float(np.sqrt(np.mean(((free.ten - BODY.vector) / expected) ** 2))),
        _mean(seen * np.sqrt(rate / seen_rate) / sigma),
        identified.problem.condition_numbers()[0] / of_robot.condition_number,
    )


def _mean(ratios: Array) -> float:
    return float(np.exp(np.log(ratios).mean()))


def main() -> None:
    arguments, rows = options(__doc__, seeds=2), []
    for name in robot_names():
        each = np.array([promised_and_shown(name, seed) for seed in range(arguments.seeds)])
        rows.append([name, "0.67 to 1.5", *(f"{x:.2f}" for x in np.exp(np.log(each).mean(axis=0)))])
        print(*rows[-1], flush=True)
    show("Shown over promised", rows, "payload", "mass", "error", "noise", "condition")


if __name__ == "__main__":
    main()
