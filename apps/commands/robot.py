"""``dynident robot`` and ``codegen``: descriptions, kinematics by a recording, files of simulators, C."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np
from cyclopts import Parameter

from ... import estimation, model
from ...common.errors import InputError, printable
from ...common.files import write_text
from ...common.schema import present
from .. import logs, results
from .. import view as views
from ..export import simulators
from ..export.own_model import into
from ..export.robot import robot_notes, stored_whole_robot
from ..report.documents import robot_check_document
from ..report.figures.payload import save_drawing
from ..report.sections.check import readings_agree, readings_report
from ..report.sections.robot import base_description, robot_description
from ..report.terminal import print_blocks
from . import values
from .entry import SETTING, Options, about, command
from .motions import in_si
from .options import FilterOptions, FramedRobotOptions, PageOptions, RobotOptions, ViewOptions, print_lines
from .progress import note, quiet, status, withheld
from .values import NewDrawing, NewFile, Positions, Reads, checked, number, numbers, positive_number, texts, word

if TYPE_CHECKING:
    from ...model import JointAxis, Pose
else:  # --help names options without importing what they become
    JointAxis = Pose = object

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
TEMPLATE = Path(__file__).with_name("robot_template.toml")
"""A description that loads as it stands, with every key that a robot's file may have."""

_Logs = Annotated[values.DataFiles, Parameter(help="Recording without payload.")]
_LIMITS = "LOW:HIGH[:SPEED[:ACCELERATION[:TORQUE]]],.."
_Function = Annotated[str, Parameter(metavar="NAME", help="What C computes, such as base_regressor.")]


def run_list() -> None:
    """Run ``robot list``: names and titles."""
    for name in model.robot_names():
        print(f"{name:14s}{model.load_robot(name).title}")


@command
def run_show(
    *,
    arm: FramedRobotOptions,
    at: Annotated[Positions | None, Parameter(help="Positions to draw [deg or m] (default: 0).")] = None,
    base: Annotated[bool, Parameter(help="Its base parameters, and what is grouped in each.")] = False,
    drawing: Annotated[NewDrawing | None, Parameter(help="Write a stick figure: .png, .svg or .pdf.")] = None,
    view: ViewOptions,
) -> None:
    """Run ``robot show``."""
    robot = arm.load()
    at = at or (0.0,) * robot.n
    with about("--at"):
        q = in_si(at, robot)[None]
    print_blocks(base_description(robot) if base else robot_description(model.stand_in.rehearsed(robot)))
    if drawing:
        draw(robot, drawing, at)
    still = model.Motion(np.zeros(1), q, np.zeros_like(q), np.zeros_like(q))
    view.write_view(lambda: views.view_of(robot, still))


def _direction(text: str) -> tuple[float, float, float]:
    """Components of "x", "-y", .. or "a:b:c"."""
    if (plain := text.lstrip("+-")) in _AXES:
        sign = -1.0 if text.startswith("-") else 1.0
        x, y, z = (sign * component + 0.0 for component in _AXES[plain])
    else:
        checked(text, text.count(":") == 2, text, "a direction: x, -y, .. or a:b:c")
        x, y, z = numbers(text.replace(":", ","), 3)
    return x, y, z


def joint_axis(text: str) -> model.JointAxis:
    """A joint by its axis: a direction and a point on it [m], and "slide" where it slides."""
    try:
        parts = list(texts(text))
        slides = parts[-1] == "slide"
        direction, *point = parts[:-1] if slides else parts
        x, y, z = numbers(",".join(point), 3)
        return model.JointAxis("prismatic" if slides else "revolute", _direction(direction), (x, y, z))
    except ValueError as error:
        raise ValueError(f"{text!r} is not AXIS,X,Y,Z[,slide]: {error}") from None


def flange(text: str) -> model.Pose:
    """The flange by its origin [m], the direction out of it, and its x axis."""
    try:
        *origin, out, side = checked(texts(text), text.count(",") == 4, text, "X,Y,Z,ZAXIS,XAXIS")
        along, across = (np.array(_direction(part)) for part in (out, side))
        along, across = along / np.linalg.norm(along), across / np.linalg.norm(across)
        turned = np.column_stack([across, np.cross(along, across), along])
        return model.Pose.of(turned, np.array(numbers(",".join(origin), 3)))
    except ValueError as error:
        raise ValueError(f"{text!r}: give X,Y,Z,ZAXIS,XAXIS, two directions at right angles ({error})") from None


def joint_limits(text: str) -> tuple[tuple[float, ...], ...]:
    """Limits of each joint, LOW:HIGH[:SPEED[:ACCELERATION[:TORQUE]]]; those left empty or out are infinite."""
    joints = []
    for part in texts(text):
        ends = part.split(":")
        checked(ends, 2 <= len(ends) <= 5, part, f"{_LIMITS.removesuffix(',..')}, such as -170:170:220::300")
        low, high, *rest = [*ends, "", "", ""][:5]
        bounds = (number(low) if low else -math.inf, number(high) if high else math.inf)
        joints.append((*bounds, *(positive_number(bound) if bound else math.inf for bound in rest)))
    return tuple(joints)


class _Sheet(Options):
    template: bool = False
    """Write a file to fill in, with an example of every key (default: to standard output)."""
    name: str | None = None
    """Short name of the robot."""
    joint: Annotated[tuple[JointAxis, ...], word(joint_axis, "AXIS,X,Y,Z[,slide]", None)] = ()
    """Direction of a joint's axis (x, -y, .. or a:b:c) and a point on it [m]; one option per joint."""
    flange: Annotated[Pose | None, word(flange, "X,Y,Z,ZAXIS,XAXIS")] = None
    """Origin of the flange [m], its outward direction, and its x axis."""
    drawn_at: Annotated[Positions | None, SETTING] = None
    """Joint positions of that pose [deg or m]."""
    limits: Annotated[tuple[tuple[float, ...], ...] | None, word(joint_limits, _LIMITS)] = None
    """One part per joint, as far as known [deg or m, per s, N·m or N]: -170:170:220::300."""
    rated_payload: Annotated[float | None, word(number, "KG")] = None
    """Rated payload in the data sheet."""
    mass: Annotated[float | None, word(number, "KG")] = None
    """Mass of the whole arm including its base, if known."""
    out: Annotated[NewFile | None, Parameter(metavar="F.toml")] = None
    """File to write (default: NAME.toml)."""
    drawing: NewDrawing | None = None
    """.svg, .png or .pdf (default: beside the file, .svg)."""
    overwrite: bool = False
    """Replace an existing file."""

    def check(self) -> None:
        """Refuse options beside ``--template``, and a sheet with gaps."""
        super().check()
        if self.template:
            for entry in fields(self):
                if entry.name not in ("template", "out", "overwrite"):
                    self.refuse(entry.name, "belongs to a robot by options, --template is a file to fill in")
            return
        if missing := [f"--{name}" for name in ("name", "joint", "flange") if not getattr(self, name)]:
            raise InputError(f"give {', '.join(missing)}, or --template for a file to fill in")

    def write(self, out: Path, text: str) -> None:
        """Write the file, over another one only where that is wanted."""
        if out.exists() and not self.overwrite:
            raise InputError(f"{out}: is there already: give another --out, or --overwrite")
        write_text(out, text)


@command
def run_new(*, request: _Sheet) -> None:
    """Run ``robot new``."""
    if request.template:
        text = TEMPLATE.read_text(encoding="utf-8")
        if request.out is None:
            print(text, end="")
        else:
            request.write(Path(request.out), text)
            print_lines(f"Written: {request.out}. Fill it in, then: dynident robot show --robot {request.out}")
        return
    robot, drawn_at = new_robot(request)
    out = Path(request.out or f"{robot.name}.toml")
    request.write(out, model.robot_toml(robot))
    print_blocks(robot_description(robot))
    draw(robot, request.drawing or str(out.with_suffix(".svg")), drawn_at)
    print_lines(
        f"Written: {out}. Compare the drawing with the data sheet before you use it. What else is known goes into "
        "the file: title, source, joint_names, .. as 'dynident robot new --template' shows them."
    )
    if not model.stand_in.can_stand_in(robot):
        note(f"to rehearse on it, add the mass of the arm to {out} (mass_kg = ..), or give --arm-mass KG")


def new_robot(sheet: _Sheet) -> tuple[model.Robot, tuple[float, ...]]:
    """The robot that the answers describe, and the positions [deg or m] of the pose they describe it in."""
    axes, name = list(sheet.joint or ()), sheet.name or ""
    drawn_at = sheet.drawn_at or (0.0,) * len(axes)
    for option, parts in (("drawn-at", drawn_at), ("--limits", sheet.limits or axes)):
        if len(parts) != len(axes):
            raise InputError(f"{option} has {len(parts)} parts for {len(axes)} joints: give one per joint")
    for j, bounds in enumerate(sheet.limits or ()):
        scale = math.pi / 180.0 if axes[j].kind == "revolute" else 1.0
        low, high, speed, acceleration = (scale * bound for bound in bounds[:4])
        with about(f"--limits of joint {j + 1}"):
            axes[j] = replace(axes[j], limits=model.Limits((low, high), speed, acceleration, bounds[4]))
    robot = model.modified_dh(axes, sheet.flange or model.Pose())
    # Counted so that each joint stands at its part of drawn_at where the frames were taken.
    joints = [
        replace(joint, theta=joint.theta - math.radians(q))
        if joint.revolute
        else replace(joint, r=round(joint.r - q, 12) + 0.0)
        for joint, q in zip(robot.joints, drawn_at, strict=True)
    ]
    slow_speed = model.motion.usual_slow_speed([axis.kind == "revolute" for axis in axes])
    try:
        robot = replace(
            robot,
            name=name,
            joints=tuple(joints),
            payload_frame="the flange frame: origin on the flange face, z outwards",
            rated_payload=math.inf if sheet.rated_payload is None else sheet.rated_payload,
            mass=sheet.mass,
            processing=model.Processing(cutoff=10.0, decimate=5, slow_speed=slow_speed),
            title=name,
        )
    except ValueError as error:
        raise InputError(str(error)) from None
    return robot, drawn_at


def draw(robot: model.Robot, path: str, at: tuple[float, ...]) -> None:
    """Write the drawing of a robot at positions in degrees and metres, and say so."""
    shown = ", ".join(f"{x:g}" for x in at)
    save_drawing(path, robot, in_si(at, robot).tolist(), f"{robot.title or robot.name} at {shown} (degrees, m)")
    print_lines(f"Drawn at {shown}: {path}")


class _Page(PageOptions):
    """The result as JSON and as a report, which has no figure."""

    plots: Annotated[None, Parameter(parse=False)] = None


@command
def run_check(*, arm: RobotOptions, data: _Logs, processing: FilterOptions, files: _Page) -> bool:
    """Run ``robot check``."""
    setup = processing.setup(arm.load())
    robot = setup.robot
    with status("reading") as progress:
        given = logs.grouped(data)
        logged = [logs.read_tool_poses(path, robot, setup.log_map) for path in given]
        poses = [estimation.check_pose(robot, log, progress) for log in logged if log]
        named = {path: logs.named(path, robot, setup.log_map) for path in given if poses}
        recordings = setup.read(
            [path for path in given if not poses or named[path].holds("torque") or named[path].holds("current")]
        )
        readings = estimation.rank_readings(robot, recordings, setup.processing, progress) if recordings else None
    shown = readings_report(robot, poses, readings)
    files.give(shown, lambda: robot_check_document(robot, poses, readings), setup.in_words())
    return readings_agree(poses, readings)


class _Bodies(Options):
    belongs: ClassVar = {"into": ("to", ("mjcf", "urdf"))}

    robot_parameters: tuple[values.RobotParametersFile, ...] = ()
    """The --json file of 'dynident identify' (default: the parameters in the robot's own file)."""
    to: Annotated[Literal["mjcf", "usd", "urdf", "sdf"], Parameter(show_choices=False)]
    """mjcf (MuJoCo), usd (Isaac Sim), urdf, sdf (SDFormat: Gazebo, Drake)."""
    out: NewFile
    """File to write."""
    into: Annotated[str | None, Reads("model"), Parameter(metavar="F")] = None
    """mjcf, urdf: your own model, which gets the numbers; joints are matched by name."""
    despite_verdict: bool = False
    """Write it, whatever the verdict."""

    def check(self) -> None:
        """Refuse what the format does not know, and more than one robot."""
        super().check()
        if len(self.robot_parameters) > 1:
            raise InputError("several --robot-parameters: give all recordings to one 'dynident identify'")


@command
def run_export(*, arm: RobotOptions, bodies: _Bodies) -> bool:
    """Run ``robot export``."""
    form = simulators.FORMATS[bodies.to]
    robot = arm.load()
    against: tuple[str, ...] = ()
    if bodies.robot_parameters:
        (path,) = bodies.robot_parameters
        stored = results.read_stored_robot(path)
        whole = stored_whole_robot(robot, stored, path)
        against = tuple(present(stored.reasons_against_use) or ())
    else:
        source = f"the description of {robot.name}, nothing identified"
        whole = estimation.whole_robot(robot, dict(robot.parameters), source)
    against += whole.heavier_than_the_arm()
    if against and not bodies.despite_verdict:
        return withheld("written", f"{'; '.join(against)} (--despite-verdict writes it all the same)")
    notes = list(robot_notes(form, whole))
    if bodies.into is None:
        write_text(bodies.out, form.text(whole))
    else:
        text, more = into(bodies.to, bodies.into, whole, form.head(form, whole))
        write_text(bodies.out, text)
        notes += more
    print_lines(f"{bodies.out}: {whole.source}. Prior: {whole.prior}.", *(f"  {line}" for line in notes))
    return True


@command
def run_codegen(
    *,
    robot: RobotOptions,
    function: _Function | None = None,
    language: Literal["c", "numpy"] = "c",
    out: values.NewFolder,
) -> None:
    """Run ``codegen``.

    Args:
        language: Of the code: c, one function; or numpy, one file of regressor and dynamics.
        out: Folder of the files, made if missing.
    """
    if (language == "c") != (function is not None):
        needed = f"give one of {', '.join(model.code_names())}" if language == "c" else "is for C: leave it out"
        raise InputError(f"--function: {needed}")
    arm = robot.load()
    for path in (model.generate_numpy(arm, out),) if function is None else model.generate_code(arm, function, out):
        if not quiet():
            print(printable(str(path)))
