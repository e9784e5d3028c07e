"""``dynident demo``: the paper's experiment on a simulated RX90, from trajectories to the report.

The paper is silent about the arm's spring, the motion between points and the noise: what is assumed stands here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Annotated, Literal

import numpy as np
from cyclopts import Parameter

from ... import estimation, model, trajectories
from ...common.files import made_folder
from ...common.progress import Progress, silent
from ...common.schema import write_json
from ..logs.map import LogMap
from ..report.blocks import Notes
from ..report.figures.canvas import save_figure
from ..report.sections.payload import payload_report
from ..report.sections.robot import robot_section
from .entry import SETTING, command
from .options import PageOptions, Setup
from .progress import status
from .values import Count, NewFolder, Seed, Share

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


def reduced_experiment(experiment: trajectories.Experiment, progress: Progress = silent) -> estimation.LongMotion:
    """The equations of all runs but those of the held-out trajectory."""
    used = [run.recording for run in experiment.runs[:-2]]
    return estimation.payload_problem(
        experiment.robot,
        used[1::2],
        used[::2],
        settings=estimation.Settings(friction_change=0.0, friction=model.PAPER, progress=progress),
    )


@command
def run(
    *,
    out: NewFolder = "demo",
    seed: Seed = 0,
    motions: Annotated[Count, Parameter(name="--trajectories")] = TRAJECTORIES,
    noise: Literal["paper", "slow", "none"] = "paper",
    gain_error: Annotated[Share, SETTING] = 0.0,
    files: PageOptions,
) -> None:
    """Simulate, identify by all four methods, and print the payload beside the truth.

    The report goes into the folder of the results unless another place is named.

    Args:
        out: Folder of the results (default: demo).
        seed: Seed of the trajectories and the noise (default: 0).
        motions: Number of trajectories (default: 18, as in the paper).
        noise: Noise of the paper's robot (default), with a memory of 0.8 s, or none.
        gain_error: Error of the drive gains, such as 0.02 (default: 0).
    """
    folder = made_folder(out)
    with status("simulating") as progress:
        told = partial(progress, "simulating")
        experiment = simulate_paper(paper_robot(), levels(noise, gain_error), seed, motions, told)
    with status("reducing") as progress:
        robot, answer = identified(experiment, progress)
    write_json(folder / "payload.json", answer.result)
    write_json(folder / "robot.json", robot.result)
    files = replace(files, report=files.report or str(folder / "report.html"))
    written = (*(folder / name for name in ("payload.json", "robot.json", "torques.png")), files.report)
    shown = payload_report(answer.result, str(folder / "payload.json"))
    place = ", ".join(f"{1e3 * x:g}" for x in PAYLOAD.com)
    head = (
        f"The paper's experiment on a simulated RX90. The true payload, {PAYLOAD.mass:g} kg at ({place}) mm, is "
        "unknown to the identification."
    )
    first = [Notes([head]), *shown.first, Notes([f"Written: {', '.join(map(str, written))}"])]
    shown = replace(shown, first=first, sections=[*shown.sections, robot_section(robot.result)])
    arm = experiment.robot
    setup = Setup(arm, arm.processing, None, None, LogMap(source="simulated"))
    simulated = {
        "recordings": f"simulated: {len(experiment.runs)} runs, the last trajectory held out",
        "seed": str(experiment.seed),
        "noise": noise,
        "errors of the drive gains": f"{100.0 * experiment.disturbances.gain_error:g} %",
    }
    torques = next(drawing for drawing in shown.drawings() if drawing.name == "worst_joint")
    save_figure(torques.figure, folder / "torques.png")
    files.give(shown, lambda: answer.result, setup.in_words() | simulated)


def identified(
    experiment: trajectories.Experiment, progress: Progress
) -> tuple[estimation.Identification, estimation.PayloadAnswer]:
    """The robot from the runs without payload, and the payload by all methods; the last trajectory is held out."""
    problem = reduced_experiment(experiment, progress)
    *unloaded, last = (run.recording for run in experiment.runs[::2])
    progress("the robot alone")
    settings = estimation.Settings(friction=model.PAPER, progress=progress)
    robot = estimation.identify(experiment.robot, unloaded, settings, [last])
    progress("the payload")
    return robot, estimation.answer_payload(problem, held_out=[last])
