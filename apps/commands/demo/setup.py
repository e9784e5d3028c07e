"""The paper's experiment as it is simulated: robot, payload, motion, and what is assumed where it is silent."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .... import estimation, model, trajectories
from ....common.progress import Progress, silent

TRAJECTORIES = 18
"""For identification, as in the paper; one more is held out."""
POINTS = 16
"""Per trajectory: start, end, and about 14 intermediate points, as in the paper."""
SPEED, ACCELERATION, BLEND = 0.42, 0.5, 0.2
"""Shares of the limits, and of a ramp that passes into the next: 63,000 equations, condition number near 58."""

PAYLOAD = model.InertialParameters(np.array([0.161, 0, 0, 0.161, 0, 0.035, 0, 0, 1.003, 7.025]))
"""The paper's payload: its a priori values (CATIA, weighed mass)."""
ASSUMED_SPRING = model.Spring(joint=2, stiffness=6000.0, length=0.15, arms=(0.08, 0.35), zero=np.pi / 2)
"""The manufacturer's law is not public: a spring that takes off about 60 % of the gravity torque of the bare arm.

As in the paper it is a known torque: the simulation applies it, identification moves it to the left-hand side.
"""


def paper_robot() -> model.Robot:
    """The RX90 with the assumed spring."""
    robot = model.load_robot("rx90")
    return replace(robot, drives=replace(robot.drives, spring=ASSUMED_SPRING))


def levels(noise: str, gain_error: float = 0.0) -> trajectories.Disturbances:
    """Disturbances by name: paper, slow or none."""
    named = {
        "paper": trajectories.RX90_DISTURBANCES,
        "slow": trajectories.RX90_SLOW_NOISE,
        "none": trajectories.no_disturbances(6),
    }
    return replace(named[noise], gain_error=gain_error)


def simulate_paper(
    robot: model.Robot,
    disturbances: trajectories.Disturbances,
    seed: int,
    motions: int = TRAJECTORIES,
    progress: Callable[[float], None] | None = None,
) -> trajectories.Experiment:
    """Run each trajectory without and then with the payload, the held-out one last."""
    tasks = []
    for k in range(motions + 1):
        points = trajectories.random_points(robot, POINTS, seed=1000 * seed + k)
        motion = trajectories.plan_point_to_point(robot, points, SPEED, ACCELERATION, BLEND)
        tasks.append(trajectories.Task(f"trajectory {k + 1} without payload", motion))
        tasks.append(trajectories.Task(f"trajectory {k + 1} with payload", motion, PAYLOAD))
    return trajectories.run_experiment(robot, tasks, disturbances, seed, progress=progress)


def reduced_experiment(
    experiment: trajectories.Experiment, progress: Progress = silent
) -> estimation.PayloadProblem:
    """The equations of all runs but those of the held-out trajectory."""
    used = [run.recording for run in experiment.runs[:-2]]
    return estimation.payload_problem(
        experiment.robot, used[1::2], used[::2], progress=progress, robust=True, friction_change=0.0
    )
