"""Options of the files that hold a motion, and the writing of them."""

from __future__ import annotations

from dataclasses import dataclass

from .... import model, trajectories
from ....common.errors import InputError
from ....common.files import write_text
from ... import export
from ..values import names_list, positive_number
from .outputs import PageOptions
from .reading import option

_RATE = 250.0  # Hz, of samples
_REPLAY_RATE = 1000.0  # Hz: at which controllers' own curves are looked at, and at their turns


@dataclass(frozen=True)
class MotionFiles(PageOptions):
    """Formats of the motion itself, beside the result."""

    samples: str | None = option(writes="file", metavar="F.csv", help="samples of the motion: t, q, qd, qdd")
    ros2: str | None = option(writes="file", metavar="F.yaml", help="JointTrajectory of ROS 2")
    joint_names: tuple[str, ...] | None = option(
        type=names_list, metavar="A,B,..", help="for --ros2 (default: joint_1, ..)"
    )
    urscript: str | None = option(writes="file", metavar="F", help="servoj program")
    controller_rate: float | None = option(
        type=positive_number, metavar="HZ", help="of --urscript: 500 (default) or 125"
    )
    sample_rate: float | None = option(
        type=positive_number, metavar="HZ", help=f"of the samples in files (default: {_RATE:g})"
    )

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
            export.motions.check_joint_names(self.joint_names or (), robot.n)
        if self.urscript:
            export.motions.check_urscript(robot, self.controller_rate or export.motions.CONTROLLER_RATE)

    @property
    def rate(self) -> float:
        """Samples a second [Hz]."""
        return self.sample_rate or _RATE

    def check_replays(
        self, problem: trajectories.DesignProblem, written: export.motions.WrittenMotion, val3: bool = False
    ) -> None:
        """Refuse files whose controllers, by their own interpolation, break a limit or touch something.

        Args:
            problem: whose limits count, whole: what a design leaves free of the torques is for this.
            written: the motion.
            val3: whether VAL3's own moves count too.

        Raises:
            InputError: says which, and by how much.
        """
        rates = export.motions.Rates(
            self.rate if self.ros2 else None,
            (self.controller_rate or export.motions.CONTROLLER_RATE) if self.urscript else None,
        )
        for replay in export.motions.controller_replays(written, rates, val3):
            for limit in trajectories.missed_on_replay(problem, replay.plan, _REPLAY_RATE):
                raise InputError(
                    f"as {replay.words} the motion does not keep its limits ({limit}): {replay.advice}"
                )

    def write(self, written: export.motions.WrittenMotion) -> None:
        """Write a motion with its head in the formats asked for."""
        if self.samples:
            write_text(self.samples, export.motions.csv_text(written, self.rate))
        if self.ros2:
            write_text(self.ros2, export.motions.ros2_text(written, self.rate, self.joint_names or ()))
        if self.urscript:
            rate = self.controller_rate or export.motions.CONTROLLER_RATE
            write_text(self.urscript, export.motions.urscript_text(written, rate))
