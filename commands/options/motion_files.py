"""Options of the files that commands with motions write, and the writing of motions."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from typing import Any

from ... import model, report
from ...common.files import write_text
from ..values import names_list, positive_number
from .reading import Options

_RATE = 250.0  # Hz, of samples


@dataclass(frozen=True)
class ResultFiles(Options):
    """The result as JSON, figures and report."""

    json: str | None
    plots: str | None
    report: str | None

    @staticmethod
    def add_to(group: Any) -> None:
        """Add them to a group of a command."""
        group.add_argument("--json", metavar="F", help="the result as JSON")
        group.add_argument(
            "--plots", metavar="DIR", help="figures as PNG, SVG and PDF, the moving arm as SVG; made if missing"
        )
        group.add_argument("--report", metavar="F.html", help="a report, one self-contained HTML file")


@dataclass(frozen=True)
class MotionFiles(ResultFiles):
    """Formats of the motion itself, beside the result."""

    csv: str | None
    ros2: str | None
    joint_names: tuple[str, ...] | None
    urscript: str | None
    controller_rate: float | None
    sample_rate: float | None

    @staticmethod
    def declare(parser: argparse.ArgumentParser, sampled: str = "--csv and --ros2") -> Any:
        """Add them to a command; ``sampled``: the options that ``--sample-rate`` is for.

        Returns:
            The group, for options of this command alone.
        """
        group = parser.add_argument_group("files")
        group.add_argument("--csv", metavar="F", help="samples: t, q, qd, qdd")
        group.add_argument("--ros2", metavar="F.yaml", help="JointTrajectory of ROS 2")
        group.add_argument(
            "--joint-names", type=names_list, metavar="A,B,..", help="for --ros2 (default: joint_1, ..)"
        )
        group.add_argument("--urscript", metavar="F", help="servoj program")
        group.add_argument(
            "--controller-rate", type=positive_number, metavar="HZ", help="of --urscript: 500 (default) or 125"
        )
        group.add_argument(
            "--sample-rate", type=positive_number, metavar="HZ", help=f"of {sampled} (default: {_RATE:g})"
        )
        ResultFiles.add_to(group)
        return group

    def check(self, robot: model.Robot, *more_sampled: str) -> None:
        """Refuse options without effect, and what a format has no place for, before the search.

        Args:
            robot: whose motion it is.
            more_sampled: options of this command that ``--sample-rate`` is for too.

        Raises:
            InputError: one line.
        """
        for option, needs in (
            ("joint_names", ("ros2",)),
            ("controller_rate", ("urscript",)),
            ("sample_rate", ("csv", "ros2", *more_sampled)),
        ):
            if not any(self.has(other) for other in needs):
                self.refuse(option, f"has no effect without {' or '.join(f'--{other}' for other in needs)}")
        if self.ros2:
            report.motions.check_joint_names(self.joint_names or (), robot.n)
        if self.urscript:
            report.motions.check_urscript(robot, self.controller_rate or report.motions.CONTROLLER_RATE)

    @property
    def rate(self) -> float:
        """Samples a second [Hz]."""
        return self.sample_rate or _RATE

    def write(self, written: report.motions.WrittenMotion) -> None:
        """Write a motion with its head in the formats asked for."""
        if self.csv:
            write_text(self.csv, report.motions.csv_text(written, self.rate))
        if self.ros2:
            write_text(self.ros2, report.motions.ros2_text(written, self.rate, self.joint_names or ()))
        if self.urscript:
            rate = self.controller_rate or report.motions.CONTROLLER_RATE
            write_text(self.urscript, report.motions.urscript_text(written, rate))
