"""``dynident simulate`` and ``demo``: recordings of a robot whose parameters are known, and the paper's experiment.

Without noise a recording holds the exact motion and motor torques. What an identification then misses (0.3 % of a
payload, up to 2 % of dry friction) comes from its filter, and from dry friction that the simulation takes as
tanh(qd / 0.01 rad/s). The paper is silent about the arm's spring, the motion between points and the noise.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from cyclopts import Parameter

from ... import estimation, model, trajectories
from ...common.errors import InputError
from ...common.files import made_folder
from ...common.progress import Progress, silent
from ...common.schema import write_json
from .. import logs, view
from ..recordings import SIMULATED, write_recording, write_truth
from ..report.blocks import Notes
from ..report.figures import save_figure
from ..report.sections.payload import payload_report
from ..report.sections.robot import assumed_notes, robot_section
from . import values
from .entry import SETTING, status
from .options import PageOptions, RobotOptions, Setup, ViewOptions
from .values import Count, NewFolder, PayloadFile, Reads, Seed, Share, number, share, where, word

_SHARE = 0.08
_RATE = word(where(number, lambda rate: 20.0 <= rate <= 1e4, "a rate from 20 to 10000 Hz"), "HZ")
_SAG = word(where(number, lambda sag: 0.0 < sag <= 100.0, "above 0 and at most 100 mrad"), "MRAD")

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


class _Simulate(ViewOptions, RobotOptions):
    arm_mass: values.ArmMass | None = None
    trajectory: tuple[Annotated[str, Reads("trajectories"), Parameter(metavar="CSV")], ...] = ()
    """Motion to run (t,q1..[,qd1..[,qdd1..]]); repeatable (default: one through 16 random points)."""
    payload: PayloadFile | None = None
    """Payload with which each motion is run as well."""
    noise: Annotated[str, Parameter(metavar="LEVEL")] = ""
    """none, a fraction of each joint's torque, assumed (as design assumes), or paper or slow (rx90 only); default:
    paper for rx90, else 0.08."""
    friction: Annotated[dict[str, float] | None, word(values.levels, "TERM=LEVEL,..")] = None
    """More friction, such as FL2=0.06 (load), FR1=20 (root of speed), FB1@0.1=5 (Stribeck); see docs/theory.md."""
    gain_error: Annotated[Share, SETTING] = 0.0
    """Error of the drive gains, such as 0.02 (default: 0)."""
    controller: Literal["integral", "proportional", "gravity"] = "integral"
    """Joint controllers: with integral action (default), without it, or with gravity compensation only."""
    sag: Annotated[float | None, _SAG] = None
    """Make controllers without integral action so soft that the payload pulls the worst joint off its path by this
    much (root mean square; default: stiff)."""
    rate: Annotated[float, _RATE] = 250.0
    """Sampling rate of the recordings (default: 250)."""
    seed: Seed = 0
    """Seed of all random numbers (default: 0)."""
    out: NewFolder
    """Folder for the recordings and truth.toml."""

    def __call__(self) -> None:
        described = self.load()
        robot = self.rubbing(model.with_stand_in(described))
        payload = model.read_payload(self.payload) if self.payload else None
        references: dict[str, trajectories.Plan] = {}
        for file in self.trajectory:  # these need only keep the limits of the description, not assumed ones
            name = Path(file).name.removesuffix(".gz").removesuffix(".csv")
            if name in references:
                raise InputError(f"--trajectory: two files are called {name!r}: rename one")
            trajectory = trajectories.SampledTrajectory(*logs.read_trajectory(file, robot), file)
            trajectory.check_limits(described)
            references[name] = trajectory
        if not references:
            try:
                points = trajectories.random_points(robot, POINTS, self.seed)
                references["random"] = trajectories.plan_point_to_point(robot, points)
            except ValueError as error:
                raise InputError(f"{error}: give --trajectory") from None
        noise = self.noise or ("paper" if robot.name == "rx90" else str(_SHARE))
        disturbances = levels(robot, noise, self.gain_error, list(references.values()))
        loads = {"unloaded": None} | ({"loaded": payload} if payload is not None else {})
        tasks = [
            trajectories.Task(f"{name}_{load}", reference, body)
            for load, body in loads.items()
            for name, reference in references.items()
        ]
        controller = replace(trajectories.CONTROLLERS[self.controller], rate=self.rate)
        if self.sag is not None:
            if payload is None or controller.integral > 0.0:
                needed = "--payload, and --controller proportional or gravity: another never sags"
                raise InputError(f"--sag: give {needed}")
            controller = controller.sagging(robot, payload, list(references.values()), 1e-3 * self.sag)
        with status("simulating") as progress:
            told = partial(progress, "simulating")
            experiment = trajectories.run_experiment(robot, tasks, disturbances, self.seed, controller, told)
        folder = made_folder(self.out)
        lines, names = [], [f"{run.task.name}.csv" for run in experiment.runs]
        for name, run in zip(names, experiment.runs, strict=True):
            write_recording(folder / name, run.recording)
            strayed = f"tracking error at most {1e3 * run.tracking_error.max():.2f} mrad"
            lines.append(f"{folder / name}: {run.exact.motion.t[-1]:.1f} s, {strayed}")
        write_truth(folder / "truth.toml", experiment, controller, names)
        lines.append(f"{folder / 'truth.toml'}: the true parameters")
        self.tell(*lines, *assumed_notes(experiment.robot, *SIMULATED))

        shown = (np.column_stack([payload.com] * 2), payload) if payload is not None else None  # known exactly
        self.write_view(lambda: view.view_of(robot, experiment.runs[-1].exact.motion, payload=shown))

    def rubbing(self, robot: model.Robot) -> model.Robot:
        """The robot with further terms of friction."""
        if not self.friction:
            return robot
        values = {name.partition("@")[0]: level for name, level in self.friction.items()}
        for name, level in values.items():
            if level < 0.0 or (name[:2] == "FL" and level >= 1.0):
                raise InputError(f"--friction: {name}={level:g}: no drive rubs so; FL is below 1")
            if not name[-1].isdigit():
                raise InputError(f"--friction: {name} needs the number of a joint: {name}1={level:g}")
        new = [name for name in self.friction if "@" in name or name not in model.standard_columns(robot)]
        own = robot.drives.friction
        more = [term for term in model.friction_terms(new) if {term, replace(term, joint=0)}.isdisjoint(own)]
        return replace(robot.with_friction((*own, *more)), parameters={**robot.parameters, **values})


def paper_robot() -> model.Robot:
    """The RX90 with the assumed spring."""
    robot = model.load_robot("rx90")
    return replace(robot, drives=replace(robot.drives, spring=ASSUMED_SPRING))


def levels(
    robot: model.Robot, noise: str, gain_error: float = 0.0, motions: Sequence[trajectories.Plan] = ()
) -> trajectories.Disturbances:
    """Disturbances by name: paper, slow, assumed, none; or as a share of each joint's rms torque in ``motions``."""
    if noise == "none":
        named = trajectories.no_disturbances(robot.n)
    elif noise == "assumed":
        named = trajectories.remembered_disturbances(trajectories.assumed_noise(robot), trajectories.INDEPENDENT)
    elif noise in ("paper", "slow"):
        if robot.name != "rx90":
            raise InputError(f"--noise {noise} is the RX90's: give a share of the torque for {robot.name}")
        named = trajectories.RX90_DISTURBANCES if noise == "paper" else trajectories.RX90_SLOW_NOISE
    else:
        try:
            level = share(noise)
        except ValueError:
            known = "none, assumed, paper, slow or a share such as 0.08"
            raise InputError(f"--noise {noise!r}: give {known}") from None
        simulator, torques = trajectories.Simulator(robot), []
        for motion in motions:
            t = np.linspace(0.0, motion.duration, 2000)
            torques.append(simulator.measure(model.Motion(t, *motion.at(t))).torque)
        rms = np.sqrt(np.mean(np.concatenate(torques) ** 2, axis=0))
        named = trajectories.relative_disturbances(rms, level)
    return replace(named, gain_error=gain_error)


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
        loads = ("without", None), ("with", PAYLOAD)
        tasks += [trajectories.Task(f"trajectory {k + 1} {how} payload", motion, load) for how, load in loads]
    return trajectories.run_experiment(robot, tasks, disturbances, seed, progress=progress)


def reduced_experiment(experiment: trajectories.Experiment, progress: Progress = silent) -> estimation.LongMotion:
    """The equations of all runs but those of the held-out trajectory."""
    used = [run.recording for run in experiment.runs[:-2]]
    settings = estimation.Settings(friction_change=0.0, friction=model.PAPER, progress=progress)
    return estimation.payload_problem(experiment.robot, used[1::2], used[::2], settings=settings)


class _Demo(PageOptions):
    """Simulate, identify by all four methods, and print the payload beside the truth."""

    out: NewFolder = "demo"
    """Folder of the results (default: demo)."""
    seed: Seed = 0
    """Seed of the trajectories and the noise (default: 0)."""
    trajectories: Count = TRAJECTORIES
    """Number of trajectories (default: 18, as in the paper)."""
    noise: Literal["paper", "slow", "none"] = "paper"
    """Noise of the paper's robot (default), with a memory of 0.8 s, or none."""
    gain_error: Annotated[Share, SETTING] = 0.0
    """Error of the drive gains, such as 0.02 (default: 0)."""

    def __call__(self) -> None:
        folder = made_folder(self.out)
        with status("simulating") as progress:
            arm, told = paper_robot(), partial(progress, "simulating")
            noise = levels(arm, self.noise, self.gain_error)
            experiment = simulate_paper(arm, noise, self.seed, self.trajectories, told)
        with status("reducing") as progress:
            robot, answer = identified(experiment, progress)
        write_json(folder / "payload.json", answer.result)
        write_json(folder / "robot.json", robot.result)
        files = replace(self, report=self.report or str(folder / "report.html"))
        written = (*(folder / name for name in ("payload.json", "robot.json", "torques.png")), files.report)
        shown = payload_report(answer.result, str(folder / "payload.json"))
        place = ", ".join(f"{1e3 * x:g}" for x in PAYLOAD.com)
        truth = f"The true payload, {PAYLOAD.mass:g} kg at ({place}) mm, is unknown to the identification."
        first = [
            Notes([f"The paper's experiment on a simulated RX90. {truth}"]),
            *shown.first,
            Notes([f"Written: {', '.join(map(str, written))}"]),
        ]
        shown = replace(shown, first=first, sections=[*shown.sections, robot_section(robot.result)])
        setup = Setup(arm, arm.processing, None, None, logs.LogMap(source="simulated"))
        simulated = {
            "recordings": f"simulated: {len(experiment.runs)} runs, the last trajectory held out",
            "seed": str(experiment.seed),
            "noise": self.noise,
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
