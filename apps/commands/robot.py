"""``dynident robot`` and ``codegen``: descriptions, kinematics by a recording, files of simulators, C."""

from __future__ import annotations

import sys
from typing import Annotated, ClassVar, Literal

import numpy as np
from cyclopts import Parameter

from ... import estimation, model
from ...common.errors import InputError, one_line, printable
from ...common.files import write_text
from ...common.schema import present
from .. import export, logs, report, results
from .. import view as views
from . import ANSWERED, DO_NOT_USE
from .entry import Options, command
from .motions import in_si
from .options import FilterOptions, FramedRobotOptions, PageOptions, RobotOptions, ViewOptions, print_lines
from .progress import quiet, status
from .robot_new import check_drawing, draw
from .values import DataFile, NewFile, NewFolder, Positions, Reads, RobotParametersFile


def run_list() -> int:
    """Run ``robot list``: names and titles."""
    for name in model.robot_names():
        print(f"{name:14s}{model.load_robot(name).title}")
    return ANSWERED


@command
def run_show(
    *,
    arm: FramedRobotOptions,
    at: Positions | None = None,
    drawing: NewFile | None = None,
    view: ViewOptions,
) -> int:
    """Run ``robot show``.

    Args:
        at: Positions to draw [deg or m] (default: 0).
        drawing: Write a stick figure: .png, .svg or .pdf.
    """
    check_drawing(drawing)
    robot = arm.load()
    at = at or (0.0,) * robot.n
    if len(at) != robot.n:
        raise InputError(f"--at has {len(at)} numbers, {robot.name} has {robot.n} joints: give one per joint")
    report.print_blocks(report.robot_description(model.stand_in.rehearsed(robot)))
    if drawing:
        draw(robot, drawing, at)
    q = in_si(at, robot)[None]
    still = model.Motion(np.zeros(1), q, np.zeros_like(q), np.zeros_like(q))
    view.write_view(lambda: views.view_of(robot, still))
    return ANSWERED


class _Page(PageOptions):
    """The result as JSON and as a report, which has no figure."""

    plots: Annotated[None, Parameter(parse=False)] = None


@command
def run_check(*, arm: RobotOptions, data: tuple[DataFile, ...], processing: FilterOptions, files: _Page) -> int:
    """Run ``robot check``.

    Args:
        data: Recording without payload.
    """
    setup = processing.setup(arm.load())
    robot = setup.robot
    with status("reading") as progress:
        logged = [logs.read_tool_poses(path, robot, setup.log_map) for path in data]
        poses = [estimation.check_pose(robot, log, progress) for log in logged if log]
        named = {path: logs.named(path, robot, setup.log_map) for path in data if poses}
        recordings = setup.read(
            [path for path in data if not poses or named[path].holds("torque") or named[path].holds("current")]
        )
        readings = estimation.rank_readings(robot, recordings, setup.processing, progress) if recordings else None
    shown = report.readings_report(robot, poses, readings)
    files.give(shown, lambda: report.documents.robot_check_document(robot, poses, readings), setup.in_words())
    return ANSWERED if report.readings_agree(poses, readings) else DO_NOT_USE


class _Bodies(Options):
    """Source of the numbers, and the file to write."""

    belongs: ClassVar = {"into": ("to", ("mjcf", "urdf"))}

    robot_parameters: tuple[RobotParametersFile, ...] = ()
    """The --json of 'dynident identify' (default: the parameters of the robot's own file)."""
    to: Annotated[Literal["mjcf", "usd", "urdf", "sdf"], Parameter(show_choices=False)]
    """mjcf (MuJoCo), usd (Isaac Sim), urdf, sdf (SDFormat: Gazebo, Drake)."""
    out: NewFile
    """File to write."""
    into: Annotated[str | None, Reads("model"), Parameter(metavar="F")] = None
    """mjcf, urdf: a model of your own that gets the numbers, matched by names of joints."""
    despite_verdict: bool = False
    """Write it whatever the verdict."""

    def check(self) -> None:
        """Refuse what the format does not know, and more than one robot."""
        super().check()
        if len(self.robot_parameters) > 1:
            raise InputError("several --robot-parameters: give all recordings to one 'dynident identify'")


@command
def run_export(*, arm: RobotOptions, bodies: _Bodies) -> int:
    """Run ``robot export``."""
    form = export.simulators.FORMATS[bodies.to]
    robot = arm.load()
    against: tuple[str, ...] = ()
    if bodies.robot_parameters:
        (path,) = bodies.robot_parameters
        stored = results.read_stored_robot(path)
        whole = export.stored_whole_robot(robot, stored, path)
        against = tuple(present(stored.reasons_against_use) or ())
    else:
        source = f"the description of {robot.name}, nothing identified"
        whole = estimation.whole_robot(robot, dict(robot.parameters), source)
    against += whole.heavier_than_the_arm()
    if against and not bodies.despite_verdict:
        why = "; ".join(against)
        print(f"dynident: not written: {one_line(why)} (--despite-verdict writes it all the same)", file=sys.stderr)
        return DO_NOT_USE
    notes = export.robot_notes(form, whole)
    if bodies.into is None:
        write_text(bodies.out, form.text(whole))
    else:
        changed = export.into(bodies.to, bodies.into, whole, form.head(form, whole))
        write_text(bodies.out, changed.text)
        notes += changed.notes
    print_lines(f"{bodies.out}: {whole.source}. Prior: {whole.prior}.", *(f"  {line}" for line in notes))
    return ANSWERED


@command
def run_codegen(*, robot: RobotOptions, function: Annotated[str, Parameter(metavar="NAME")], out: NewFolder) -> int:
    """Run ``codegen``.

    Args:
        function: Such as base_regressor.
        out: Folder of the files, made if missing.
    """
    for path in model.generate_code(robot.load(), function, out):
        if not quiet():
            print(printable(str(path)))
    return ANSWERED
