"""Files that ``dynident design`` writes."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from .. import model, report, trajectories
from ..common.errors import InputError
from ..common.files import write_text
from .design_problem import Request
from .design_report import design_page, limit_drawings, poses_drawing
from .values import names_list, positive_number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.table import Table


_FIGURE_RATE, _REPLAY_RATE = 100.0, 500.0  # Hz


def output_arguments(parser: argparse.ArgumentParser) -> None:
    """Where to write what."""
    group = parser.add_argument_group("files")
    group.add_argument("--csv", metavar="F", help="samples: t, q, qd, qdd")
    group.add_argument("--json", metavar="F", help="the result as JSON")
    group.add_argument("--ros2", metavar="F.yaml", help="JointTrajectory of ROS 2")
    group.add_argument("--joint-names", type=names_list, metavar="A,B,..", help="for --ros2 (default: joint_1, ..)")
    group.add_argument(
        "--val3",
        metavar="DIR",
        help="VAL3 application of via points, best with --segments trapezoid or blend; made if missing",
    )
    group.add_argument("--urscript", metavar="F", help="servoj program")
    group.add_argument(
        "--controller-rate", type=positive_number, metavar="HZ", help="of --urscript: 500 (default) or 125"
    )
    group.add_argument(
        "--sample-rate", type=positive_number, metavar="HZ", help="of --csv, --ros2 and --rehearsal (default: 250)"
    )
    group.add_argument(
        "--plots", metavar="DIR", help="figures as PNG, SVG and PDF, the moving arm as SVG; made if missing"
    )
    group.add_argument("--report", metavar="F.html", help="a report, one self-contained HTML file")


def check_outputs(arguments: argparse.Namespace) -> None:
    """Refuse options that would be ignored.

    Raises:
        InputError: one line.
    """
    for option, needs in (
        ("joint_names", ("ros2",)),
        ("controller_rate", ("urscript",)),
        ("sample_rate", ("csv", "ros2", "rehearsal")),
    ):
        if getattr(arguments, option) and not any(getattr(arguments, other) for other in needs):
            wanted = " or ".join(f"--{other}" for other in needs)
            raise InputError(f"--{option.replace('_', '-')} has no effect without {wanted}")
    if arguments.evaluate:
        for option in ("csv", "ros2", "val3", "urscript"):
            if getattr(arguments, option):
                raise InputError(f"--{option} writes a designed motion: leave it out with --evaluate")


def check_formats(arguments: argparse.Namespace, robot: model.Robot) -> None:
    """Refuse what a format has no place for, before the search.

    Raises:
        InputError: one line.
    """
    if arguments.ros2:
        report.motions.check_joint_names(arguments.joint_names or (), robot.n)
    if arguments.val3:
        report.motions.check_val3(robot, not arguments.fourier, Path(arguments.val3).name)
    if arguments.urscript:
        report.motions.check_urscript(robot, arguments.controller_rate or report.motions.CONTROLLER_RATE)


def write_motion(arguments: argparse.Namespace, design: trajectories.Design) -> None:
    """Write the motion in the formats asked for."""
    problem = design.problem
    write_formats(
        arguments,
        report.motions.WrittenMotion(
            problem.robot, design.plan, problem.bounds, report.motions.design_head(design)
        ),
    )


def write_formats(arguments: argparse.Namespace, written: report.motions.WrittenMotion) -> None:
    """Write a motion with its head in the formats asked for."""
    rate = arguments.sample_rate or 250.0
    if arguments.csv:
        write_text(arguments.csv, report.motions.csv_text(written, rate))
    if arguments.ros2:
        write_text(arguments.ros2, report.motions.ros2_text(written, rate, arguments.joint_names or ()))
    if arguments.urscript:
        write_text(
            arguments.urscript,
            report.motions.urscript_text(written, arguments.controller_rate or report.motions.CONTROLLER_RATE),
        )
    if arguments.val3:
        folder = Path(arguments.val3)
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in report.motions.val3_files(written, folder.name).items():
            write_text(folder / name, text)


def replayed(design: trajectories.Design) -> trajectories.Score:
    """What a controller would make of the via points if its profiles are trapezoidal, as ``--val3`` asks for."""
    problem = design.problem
    written = report.motions.WrittenMotion(problem.robot, design.plan, problem.bounds, ())
    return trajectories.score_motion(problem, report.motions.val3_replay(written).motion(_REPLAY_RATE))


def write_plots(
    folder: Path,
    request: Request,
    score: trajectories.Score,
    design: trajectories.Design | None,
    motion: model.Motion,
) -> None:
    """Write the figures."""
    drawings = limit_drawings(request, score, motion)
    report.figures.save_drawings(folder, drawings if design is None else [*drawings, poses_drawing(design)])
    if design is not None:
        write_text(folder / "arm.svg", report.arm.arm_animation(design.problem.robot, design.plan))


def write_design_report(
    arguments: argparse.Namespace,
    request: Request,
    score: trajectories.Score,
    design: trajectories.Design | None,
    motion: model.Motion,
    told: tuple[Sequence[Table], Sequence[str]],
) -> None:
    """Write the report, if one was asked for; ``told``: tables and lines of the terminal."""
    if arguments.report:
        report.html.write_report(arguments.report, design_page(arguments, request, score, motion, design, told))


def figure_motion(design: trajectories.Design) -> model.Motion:
    """Samples for figures."""
    return design.motion(_FIGURE_RATE)
