"""Parts that ``design``, ``near`` and ``score`` share: problem, search, and files of the motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter

from ... import model, trajectories
from ...common.errors import InputError
from ...common.files import write_text
from .. import export
from .entry import FILES, SETTING, options
from .options import ViewedPageOptions
from .options.motions import GoalOptions, LimitOptions
from .progress import note, status
from .values import Names, NewFile, positive_number, word

FIGURE_RATE = 100.0
"""Hz: samples of a motion in figures."""
_RATE = 250.0  # Hz, of samples
_Rate = Annotated[float, word(positive_number, "HZ")]
_REPLAY_RATE = 1000.0  # Hz: at which controllers' own curves are looked at, and at their turns
_ZERO = 1e-9  # SI units: what standard parameters leave where they cancel


def build_request(
    robot: model.Robot,
    shape: trajectories.ViaPointShape | trajectories.FourierShape,
    goal: GoalOptions,
    limits: LimitOptions,
) -> tuple[trajectories.DesignProblem, dict[str, float], dict[str, str]]:
    """Read all files and build the problem.

    Returns:
        The problem; by the names of parameters, values that standard deviations are relative to, and how to call
        them ("ZZ1R").
    """
    limited = limits.of(robot)
    robot, bounds, payload = limited.robot, limited.bounds, limited.payload
    base, values, labels = model.base_parameters(robot), dict(limited.values), dict[str, str]()
    if goal.payload_only:  # relative to the heaviest payload's parameters; a set has none
        values = payload.named(str(robot.n)) if isinstance(payload, model.InertialParameters) else {}
    else:
        labels = dict(zip(base.columns, base.names, strict=True))
        if not values and all(name in robot.parameters for name in base.standard):
            values = dict(zip(base.columns, base.value(robot.parameters).tolist(), strict=True))
    reference = {name: value for name, value in values.items() if abs(value) > _ZERO}
    loads = None
    if np.isfinite(bounds.torque).any():
        loads = limited.loads(payload) if limited.values or payload or limited.margin else None
    elif payload is not None and not goal.payload_only:
        raise InputError("--heaviest-payload counts in torque limits: give --torque-limits")
    if isinstance(shape, trajectories.FourierShape):
        length: float | None = shape.duration
    elif shape.fixed is None:
        length = shape.longest
    else:
        length = sum(shape.fixed) if isinstance(shape.fixed, tuple) else (shape.count - 1) * shape.fixed
    wanted = goal.goal(robot, bounds, reference, length)
    problem = trajectories.build_design(robot, shape, wanted, bounds=bounds, loads=loads, scene=limited.scene)
    return problem, reference, labels


def best_motion(
    problem: trajectories.DesignProblem,
    seed: int,
    starts: int | None,
    words: Callable[[float | None], str] = lambda best: "",
) -> trajectories.Design:
    """The best motion that keeps every limit.

    Args:
        seed: of the random starts.
        starts: number of random starts; None for the criterion's own.
        words: what is said of the best criterion so far; None before there is one.
    """
    with status("building") as progress:

        def show(text: str, best: float | None, evaluations: int) -> None:
            progress(f"{text}, {evaluations} evaluations{words(best)}")

        design = trajectories.solve_design(problem, seed=seed, starts=starts, progress=show)
    if design.missed:
        raise InputError(
            f"the whole run, or its rehearsal, does not keep every limit ({design.missed[0]}): choose other poses, "
            "or another --seed"
        )
    if not design.feasible:
        stopped = "interrupted: " if design.interrupted else ""
        missed = "; ".join(design.score.violations)
        raise InputError(f"{stopped}no motion was found that keeps every limit, the nearest has: {missed}")
    if design.interrupted:
        note("interrupted: this is the best motion so far; it keeps every limit")
    return design


def floor_of(
    problem: trajectories.DesignProblem, score: trajectories.Score, seed: int
) -> trajectories.Floor | None:
    """The floor under a motion's criterion; None if it was interrupted, which costs no motion."""
    try:
        with status("estimating the floor"):
            return trajectories.floor_under(problem, score.value, seed=seed)
    except KeyboardInterrupt:
        note("interrupted: the floor is not known")
        return None


@options(FILES)
class MotionFiles(ViewedPageOptions):
    """Formats of the motion itself, beside the result."""

    samples: Annotated[NewFile | None, Parameter(metavar="F.csv")] = None
    """Samples of the motion: t, q, qd, qdd."""
    ros2: Annotated[NewFile | None, Parameter(metavar="F.yaml")] = None
    """JointTrajectory of ROS 2."""
    joint_names: Annotated[Names | None, SETTING] = None
    """Names of the joints for --ros2 (default: joint_1, ..)."""
    urscript: NewFile | None = None
    """servoj program."""
    controller_rate: Annotated[_Rate | None, SETTING] = None
    """Cycles a second of the controller for --urscript [Hz]: 500 (default) or 125."""
    sample_rate: Annotated[_Rate | None, SETTING] = None
    """Samples a second in files [Hz] (default: 250)."""

    def check(self, robot: model.Robot, *more_sampled: str) -> None:
        """Refuse options without effect, and what a format has no place for, before the search.

        Args:
            more_sampled: options of this command that ``--sample-rate`` is for too.
        """
        for name, needs in (
            ("joint_names", ("ros2",)),
            ("controller_rate", ("urscript",)),
            ("sample_rate", ("samples", "ros2", *more_sampled)),
        ):
            if not any(self.has(need) for need in needs):
                self.refuse(name, f"has no effect without {' or '.join(f'--{need}' for need in needs)}")
        if self.ros2:
            export.check_joint_names(self.joint_names or (), robot.n)
        if self.urscript:
            export.check_urscript(robot, self.servo_rate)

    @property
    def rate(self) -> float:
        """Samples a second [Hz]."""
        return self.sample_rate or _RATE

    @property
    def servo_rate(self) -> float:
        """Cycles of a controller of Universal Robots a second [Hz]."""
        return self.controller_rate or export.CONTROLLER_RATE

    def asked(self, written: export.WrittenMotion) -> dict[str, tuple[str, export.WrittenMotion]]:
        """The formats asked for by name: where each is to be written, and the motion at its rate."""
        sampled = replace(written, rate=self.rate, joint_names=self.joint_names or ())
        files = {
            "csv": (self.samples, sampled),
            "ros2": (self.ros2, sampled),
            "urscript": (self.urscript, replace(written, rate=self.servo_rate)),
        }
        return {name: (path, motion) for name, (path, motion) in files.items() if path}

    def check_replays(
        self, problem: trajectories.DesignProblem, written: export.WrittenMotion, *estimated: str
    ) -> None:
        """Refuse files whose controllers, by their own interpolation, break a limit or touch something.

        Args:
            problem: whose limits count, whole: what a design leaves free of the torques is for this.
            written: the motion.
            estimated: formats whose replay is too rough to refuse a motion for.
        """
        for name, (_, motion) in self.asked(written).items():
            if name in estimated or (replay := export.motions.FORMATS[name].replay) is None:
                continue
            run = replay(motion)
            for limit in trajectories.missed_on_replay(problem, run.plan, _REPLAY_RATE):
                raise InputError(f"as {run.text} the motion does not keep its limits ({limit}): {run.advice}")

    def write(self, written: export.WrittenMotion) -> None:
        """Write a motion with its head in the formats asked for."""
        for name, (path, motion) in self.asked(written).items():
            form = export.motions.FORMATS[name]
            write_text(path, form.text(motion))
            for beside, text in form.beside(motion).items():
                write_text(Path(path).parent / beside, text)
