"""Parts that ``design`` and ``near`` share: the search, and files of the motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ... import model, trajectories
from ...common.errors import InputError
from ...common.files import write_text
from .. import export
from .entry import SETTING
from .options import ViewedPageOptions
from .progress import note, status
from .values import Names, NewFile, positive_number, word

FIGURE_RATE = 100.0
"""Hz: samples of a motion in figures."""
_RATE = 250.0  # Hz, of samples
_Rate = Annotated[float, word(positive_number, "HZ")]
_REPLAY_RATE = 1000.0  # Hz: at which controllers' own curves are looked at, and at their turns


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
