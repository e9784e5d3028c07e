"""The paper's experiment as it is simulated: robot, motion, and what is assumed where the paper is silent."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..model import InertialParameters, Robot, Spring, load_robot
from ..trajectories import Disturbances, Experiment, Task, plan_point_to_point, run_experiment
from ..trajectories.motions import random_points
from ..trajectories.simulation import no_disturbances

TRAJECTORIES = 18
"""For identification, as in the paper; one more is held out."""
POINTS = 16
"""Per trajectory: start, end, and about 14 intermediate points, as in the paper."""
SPEED, ACCELERATION, BLEND = 0.42, 0.5, 0.2
"""Shares of the limits, and of a ramp that passes into the next: 63,000 equations, condition number near 58."""

ASSUMED_SPRING = Spring(joint=2, stiffness=6000.0, length=0.15, arms=(0.08, 0.35), zero=np.pi / 2)
"""The manufacturer's law is not public: a spring that takes off about 60 % of the gravity torque of the bare arm.

As in the paper it is a known torque: the simulation applies it, identification moves it to the left-hand side.
"""


def paper_robot() -> Robot:
    """The RX90 with the assumed spring."""
    robot = load_robot("rx90")
    return replace(robot, drives=replace(robot.drives, spring=ASSUMED_SPRING))


def levels(noise: str, gain_error: float = 0.0) -> Disturbances:
    """Disturbances by name: paper, slow or none."""
    from ..trajectories.simulation import RX90_DISTURBANCES, RX90_SLOW_NOISE

    named = {"paper": RX90_DISTURBANCES, "slow": RX90_SLOW_NOISE, "none": no_disturbances(6)}
    return replace(named[noise], gain_error=gain_error)


def simulate_paper(
    robot: Robot,
    payload: InertialParameters,
    disturbances: Disturbances,
    seed: int,
    trajectories: int = TRAJECTORIES,
    progress: Callable[[float], None] | None = None,
) -> Experiment:
    """Run each trajectory without and then with the payload, the held-out one last."""
    tasks = []
    for k in range(trajectories + 1):
        points = random_points(robot, POINTS, seed=1000 * seed + k)
        motion = plan_point_to_point(robot, points, SPEED, ACCELERATION, BLEND)
        tasks.append(Task(f"trajectory {k + 1} without payload", motion))
        tasks.append(Task(f"trajectory {k + 1} with payload", motion, payload))
    return run_experiment(robot, tasks, disturbances, seed, progress=progress)
