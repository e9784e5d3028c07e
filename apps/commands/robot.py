"""``dynident robot``: shipped robots, a new one from a data sheet, what a description says, simulators' files."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ... import estimation, model
from ...common.errors import InputError, one_line
from ...common.files import write_text
from ...common.schema import present
from .. import export, logs, report, results
from .. import view as views
from . import ANSWERED, COMMANDS, DO_NOT_USE, robot_new
from .options import (
    FilterOptions,
    FramedRobotOptions,
    Options,
    PageOptions,
    RobotOptions,
    ViewOptions,
    add_command,
    in_si,
    option,
    print_lines,
)
from .progress import status
from .values import numbers

NAMES = ("mjcf", "usd", "urdf", "sdf")
"""The formats of whole robots, told again here so that ``--help`` need not load them."""
_INTO = ("mjcf", "urdf")
"""Formats whose files can get the numbers."""
_CHECKED = """
Where a log carries the pose of the tool (columns x, y, z and qx, qy, qz, qw, or [pose] of the log map), forward
kinematics must reproduce it: the residual is told with the constant base and tool that fit best. Where it carries
torques or currents, recorded without payload, other orders, senses and zeros of the joints are ranked by what the
robot's model leaves unexplained. The best one is suggested, never applied. Exit status 1 if the pose is not
reproduced within 5 mm and 1 degree, or if another reading does clearly better.
"""


def add_parser(commands: Any) -> None:
    """Arguments of the command and of those below it."""
    parser = commands.add_parser("robot", help=COMMANDS["robot"])
    below = parser.add_subparsers(required=True, metavar="what")
    add_command(below, "list", run_list, help="the shipped robots")
    add_command(below, "show", run_show, help="table, limits and frames of a robot, and a drawing")
    new, question = robot_new.DESCRIPTION, "check order, senses and zeros of the joints by tool poses or torques"
    add_command(below, "new", robot_new.run, help="make a robot's file from a data sheet", description=new)
    add_command(below, "check", run_check, help=question, description=_CHECKED)
    add_command(below, "export", run_export, help="write the whole robot as MJCF, USD, URDF or SDFormat")


def run_list() -> int:
    """Run ``robot list``: names and titles."""
    for name in model.robot_names():
        print(f"{name:14s}{model.load_robot(name).title}")
    return ANSWERED


@dataclass(frozen=True)
class _Drawing(Options):
    """A stick figure of the robot."""

    at: tuple[float, ...] | None = option(
        type=numbers, metavar="Q1,Q2,..", help="positions to draw [deg or m] (default: 0)"
    )
    drawing: str | None = option(writes="file", metavar="F", help="write a stick figure: .png, .svg or .pdf")


def run_show(arm: FramedRobotOptions, drawing: _Drawing, view: ViewOptions) -> int:
    """Run ``robot show``."""
    view.check_view()
    robot_new.check_drawing(drawing.drawing)
    robot = arm.load()
    at = drawing.at or (0.0,) * robot.n
    if len(at) != robot.n:
        raise InputError(f"--at has {len(at)} numbers, {robot.name} has {robot.n} joints: give one per joint")
    report.print_blocks(report.robot_description(model.stand_in.rehearsed(robot)))
    if drawing.drawing:
        robot_new.draw(robot, drawing.drawing, at)
    q = in_si(at, robot)[None]
    still = model.Motion(np.zeros(1), q, np.zeros_like(q), np.zeros_like(q))
    view.write_view(lambda: views.view_of(robot, still))
    return ANSWERED


@dataclass(frozen=True)
class _Data(PageOptions):
    """The recordings, and the result as JSON and as a report, which has no figure."""

    WITHOUT: ClassVar[frozenset[str]] = frozenset({"plots"})

    data: tuple[str, ...] = option(
        reads="without payload", action="append", required=True, metavar="LOG", help="recording without payload"
    )


def run_check(arm: RobotOptions, processing: FilterOptions, files: _Data) -> int:
    """Run ``robot check``."""
    setup = processing.setup(arm.load())
    robot = setup.robot
    with status("reading") as progress:
        logged = [logs.read_tool_poses(path, robot, setup.log_map) for path in files.data]
        poses = [estimation.check_pose(robot, log, progress) for log in logged if log]
        with_torques = [path for path in files.data if not poses or logs.holds_torques(path, robot, setup.log_map)]
        recordings = setup.read(with_torques)
        readings = estimation.rank_readings(robot, recordings, setup.processing, progress) if recordings else None
    files.show(report.readings_screen(poses, readings))
    files.write_json(lambda: report.documents.robot_check_document(robot, poses, readings))
    words = setup.in_words()
    files.write_page(
        lambda: report.readings_page(robot, poses, readings, files.provenance(words, files, arm, processing))
    )
    return ANSWERED if report.readings_agree(poses, readings) else DO_NOT_USE


@dataclass(frozen=True)
class _Bodies(Options):
    """Where the numbers come from, and the file to write."""

    robot_parameters: tuple[str, ...] = option(
        reads="robot's parameters",
        action="append",
        default=[],
        metavar="JSON",
        help="the --json of 'dynident identify' (default: the parameters of the robot's own file)",
    )
    to: str = option(
        required=True, choices=NAMES, help="mjcf (MuJoCo), usd (Isaac Sim), urdf, sdf (SDFormat: Gazebo, Drake)"
    )
    out: str = option(writes="file", required=True, metavar="F", help="file to write")
    into: str | None = option(
        reads="model",
        metavar="F",
        help="mjcf, urdf: a model of your own that gets the numbers, matched by names of joints",
    )
    despite_verdict: bool = option(action="store_true", help="write it whatever the verdict")

    def check(self) -> None:
        """Refuse what the format does not know."""
        if self.to not in _INTO:
            self.refuse("into", f"belongs to {' and '.join(_INTO)}, not to {self.to}")
        if len(self.robot_parameters) > 1:
            raise InputError("several --robot-parameters: give all recordings to one 'dynident identify'")


def run_export(arm: RobotOptions, bodies: _Bodies) -> int:
    """Run ``robot export``."""
    bodies.check()
    form = export.simulators.FORMATS[bodies.to]
    robot = arm.load()
    whole, against = _numbers(bodies, robot)
    against += whole.heavier_than_the_arm()
    if against and not bodies.despite_verdict:
        why = "; ".join(against)
        print(f"dynident: not written: {one_line(why)} (--despite-verdict writes it all the same)", file=sys.stderr)
        return DO_NOT_USE
    notes = form.notes(whole)
    if bodies.into is None:
        write_text(bodies.out, form.text(whole))
    else:
        changed = export.simulators.into(bodies.to, bodies.into, whole, form.head(whole))
        write_text(bodies.out, changed.text)
        notes += changed.notes
    print_lines(f"{bodies.out}: {whole.source}. Prior: {whole.prior}.", *(f"  {line}" for line in notes))
    return ANSWERED


def _numbers(bodies: _Bodies, robot: model.Robot) -> tuple[estimation.WholeRobot, tuple[str, ...]]:
    """The robot with its numbers, and what speaks against using them."""
    if not bodies.robot_parameters:
        source = f"the description of {robot.name}, nothing identified"
        return estimation.whole_robot(robot, dict(robot.parameters), source), ()
    (path,) = bodies.robot_parameters
    stored = results.read_stored_robot(path)
    whole = export.simulators.stored_whole_robot(robot, stored, path)
    return whole, tuple(present(stored.reasons_against_use) or ())
