"""``dynident simulate``: recordings of a robot whose parameters are known.

Without noise a recording holds the exact motion and motor torques. What an identification then misses (0.3 % of a
payload, up to 2 % of dry friction) comes from its filter, and from dry friction that the simulation takes as
tanh(qd / 0.01 rad/s).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from cyclopts import Parameter

from ... import model, trajectories
from ...common.errors import InputError
from ...common.files import made_folder
from .. import logs
from .. import view as views
from ..recordings import SIMULATED, write_recording, write_truth
from ..report.sections.robot import assumed_notes
from .entry import SETTING, Options, command
from .motions import RehearsedRobotOptions
from .options import ViewOptions, print_lines
from .progress import status
from .values import NewFolder, PayloadFile, Reads, Seed, Share, levels, number, share, where, word

_Trajectory = Annotated[str, Reads("trajectories"), Parameter(metavar="CSV")]

_SHARE = 0.08
_POINTS = 16
_RATE = word(where(number, lambda rate: 20.0 <= rate <= 1e4, "a rate from 20 to 10000 Hz"), "HZ")
_SAG = word(where(number, lambda sag: 0.0 < sag <= 100.0, "above 0 and at most 100 mrad"), "MRAD")


class _Simulate(Options):
    trajectory: tuple[_Trajectory, ...] = ()
    """Motion to run (t,q1..[,qd1..[,qdd1..]]); repeatable (default: one through 16 random points)."""
    payload: PayloadFile | None = None
    """Payload with which each motion is run as well."""
    noise: Annotated[str, Parameter(metavar="LEVEL")] = ""
    """none, a fraction of each joint's torque, assumed (as design assumes), or paper or slow (rx90 only); default:
    paper for rx90, else 0.08."""
    friction: Annotated[dict[str, float] | None, word(levels, "TERM=LEVEL,..")] = None
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


@command
def run(*, arm: RehearsedRobotOptions, request: _Simulate, view: ViewOptions) -> None:
    """Run it."""
    described = arm.load()
    robot = request.rubbing(model.with_stand_in(described))
    payload = model.read_payload(request.payload) if request.payload else None
    references = _references(robot, described, request.trajectory, request.seed)
    disturbances = _disturbances(robot, request.noise, list(references.values()))
    disturbances = replace(disturbances, gain_error=request.gain_error)
    tasks = [trajectories.Task(f"{name}_unloaded", reference) for name, reference in references.items()]
    if payload is not None:
        tasks += [trajectories.Task(f"{name}_loaded", reference, payload) for name, reference in references.items()]
    controller = replace(trajectories.CONTROLLERS[request.controller], rate=request.rate)
    if request.sag is not None:
        if payload is None or controller.integral > 0.0:
            raise InputError("--sag: give --payload, and --controller proportional or gravity: another never sags")
        controller = controller.sagging(robot, payload, list(references.values()), 1e-3 * request.sag)
    with status("simulating") as progress:
        experiment = trajectories.run_experiment(
            robot, tasks, disturbances, request.seed, controller, partial(progress, "simulating")
        )
    folder = made_folder(request.out)
    files = {folder / f"{run.task.name}.csv": run for run in experiment.runs}
    for file, run in files.items():
        write_recording(file, run.recording)
    write_truth(folder / "truth.toml", experiment, controller, [file.name for file in files])
    lines = [
        f"{file}: {run.exact.motion.t[-1]:.1f} s, tracking error at most {1e3 * run.tracking_error.max():.2f} mrad"
        for file, run in files.items()
    ]
    truth = f"{folder / 'truth.toml'}: the true parameters"
    print_lines(*lines, truth, *assumed_notes(experiment.robot, *SIMULATED))

    shown = (np.column_stack([payload.com] * 2), payload) if payload is not None else None  # known exactly
    view.write_view(lambda: views.view_of(robot, experiment.runs[-1].exact.motion, payload=shown))


def _references(
    robot: model.Robot, described: model.Robot, files: Sequence[str], seed: int
) -> dict[str, trajectories.Plan]:
    """Motions by name; those of files need only keep the limits of the description, not assumed ones."""
    motions: dict[str, trajectories.Plan] = {}
    for file in files:
        name = Path(file).name.removesuffix(".gz").removesuffix(".csv")
        if name in motions:
            raise InputError(f"--trajectory: two files are called {name!r}: rename one")
        trajectory = trajectories.SampledTrajectory(*logs.read_trajectory(file, robot), file)
        trajectory.check_limits(described)
        motions[name] = trajectory
    if motions:
        return motions
    try:
        return {"random": trajectories.plan_point_to_point(robot, trajectories.random_points(robot, _POINTS, seed))}
    except ValueError as error:
        raise InputError(f"{error}: give --trajectory") from None


def _disturbances(
    robot: model.Robot, noise: str, references: Sequence[trajectories.Plan]
) -> trajectories.Disturbances:
    """Disturbances of the recordings, by a name or as a share of each joint's root mean square torque."""
    noise = noise or ("paper" if robot.name == "rx90" else str(_SHARE))
    if noise == "none":
        return trajectories.no_disturbances(robot.n)
    if noise == "assumed":
        return trajectories.remembered_disturbances(trajectories.assumed_noise(robot), trajectories.INDEPENDENT)
    if noise in ("paper", "slow"):
        if robot.name != "rx90":
            raise InputError(f"--noise {noise} is the RX90's: give a share of the torque for {robot.name}")
        return trajectories.RX90_DISTURBANCES if noise == "paper" else trajectories.RX90_SLOW_NOISE
    try:
        level = share(noise)
    except ValueError:
        raise InputError(f"--noise {noise!r}: give none, assumed, paper, slow or a share such as 0.08") from None
    simulator, torques = trajectories.Simulator(robot), []
    for reference in references:
        t = np.linspace(0.0, reference.duration, 2000)
        torques.append(simulator.measure(model.Motion(t, *reference.at(t))).torque)
    return trajectories.relative_disturbances(np.sqrt(np.mean(np.concatenate(torques) ** 2, axis=0)), level)
