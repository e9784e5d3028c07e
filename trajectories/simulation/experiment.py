"""Simulated experiments: trajectories run without and with payloads, and what the controller writes down."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...common.arrays import Array
from ...common.brief import Brief
from ...model import Recording, Robot
from ...model.dynamics import dry_friction_names
from ...model.motion import Measurement
from ..motions.family import sample_count
from .closed_loop import ClosedLoop, Controller, Task
from .disturbances import Disturbances, draw_friction, draw_robot_errors, record


@dataclass(frozen=True, eq=False, repr=False)
class SimulatedRun(Brief):
    """Simulated run: what was recorded, and what is known of it.

    Attributes:
        exact: the motion and the motor torques without errors of measurement.
        friction: dry friction averaged over the motion, by parameter [N·m or N].
        tracking_error: largest distance from the reference, per joint [rad or m].
    """

    task: Task
    recording: Recording
    exact: Measurement
    friction: dict[str, float]
    tracking_error: Array


@dataclass(frozen=True, eq=False, repr=False)
class Experiment(Brief):
    """Runs of one robot with what disturbs it.

    Attributes:
        robot: the robot; its parameters are the truth, dry friction on average over all times.
        phases, gains: of the ripple and of the drives, as ``draw_robot_errors`` gives them.
        seed: of everything that was drawn.
        runs: in the order of the tasks.
    """

    robot: Robot
    disturbances: Disturbances
    phases: Array
    gains: Array
    seed: int
    runs: tuple[SimulatedRun, ...]

    def again(self, disturbances: Disturbances) -> "Experiment":
        """Record the same runs again with other errors of measurement.

        Raises:
            ValueError: if the robot itself would move otherwise.
        """
        own = self.disturbances
        for name in ("ripple", "waves", "friction", "friction_memory"):
            if getattr(own, name) != getattr(disturbances, name):
                raise ValueError(f"{name} acts on the moving robot: simulate again")
        phases, gains = draw_robot_errors(disturbances, self.seed)
        runs = []
        for k, run in enumerate(self.runs):
            motion, torque = run.exact.motion, run.exact.torque
            recording = record(motion, torque, disturbances, gains, [self.seed, k], run.task.name)
            runs.append(replace(run, recording=recording))
        return replace(self, disturbances=disturbances, phases=phases, gains=gains, runs=tuple(runs))


def run_experiment(
    robot: Robot,
    tasks: Sequence[Task],
    disturbances: Disturbances,
    seed: int = 0,
    controller: Controller | None = None,
    progress: Callable[[float], None] | None = None,
) -> Experiment:
    """Run tasks under the controller and record them, dry friction drawn by the disturbances.

    Args:
        disturbances: what the robot and its recordings suffer from.
        seed: the same seed gives the same recordings.

    Raises:
        InputError: if the robot's parameters are missing, or its controller loses it.
    """
    phases, gains = draw_robot_errors(disturbances, seed)
    loop = ClosedLoop(robot, controller, disturbances, phases)
    counts = [sample_count(task.reference.duration, loop.rate) + 1 for task in tasks]
    frictions = [draw_friction(robot, disturbances, count, loop.rate, [seed, k]) for k, count in enumerate(counts)]
    rubbing = [task._replace(friction=friction) for task, friction in zip(tasks, frictions, strict=True)]
    finished = []
    for k, (task, (exact, reference)) in enumerate(zip(tasks, loop.run(rubbing, progress), strict=True)):
        recording = record(exact.motion, exact.torque, disturbances, gains, [seed, k], task.name)
        mean = frictions[k][: len(exact.motion.t)].mean(axis=0)
        levels = dict(zip(dry_friction_names(robot), mean.tolist(), strict=True))
        distance = np.abs(exact.motion.q - reference).max(axis=0)
        finished.append(SimulatedRun(task, recording, exact, levels, distance))
    return Experiment(robot, disturbances, phases, gains, seed, tuple(finished))


def mean_friction(runs: Sequence[SimulatedRun]) -> dict[str, float]:
    """Average dry friction over the motion of several runs, by parameter [N·m or N]."""
    weights = [len(run.exact.motion.t) for run in runs]
    return {
        name: float(np.average([run.friction[name] for run in runs], weights=weights)) for name in runs[0].friction
    }
