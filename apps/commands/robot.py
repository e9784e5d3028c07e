"""``dynident robot`` and ``codegen``: descriptions, kinematics by a recording, files of simulators, C."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import numpy as np
from cyclopts import Parameter

from ... import estimation, model
from ...common.errors import InputError, printable
from ...common.files import write_text
from ...common.schema import present
from .. import logs, results, view
from ..export import simulators
from ..export.own_model import into
from ..export.robot import robot_notes, stored_whole_robot
from ..report.blocks import Report, print_report
from ..report.documents import robot_check_document
from ..report.figures import save_drawing
from ..report.sections.recordings import readings_agree, readings_report
from ..report.sections.robot import base_description, robot_description
from . import values
from .entry import SETTING, Options, about, note, status, withheld
from .options import PageOptions, RecordingOptions, RobotOptions, ViewOptions, in_si
from .values import NewDrawing, NewFile, Positions, Reads, checked, number, numbers, positive_number, texts, word

TEMPLATE = Path(__file__).with_name("robot_template.toml")
"""A description that loads as it stands, with every key that a robot's file may have."""

_LIMITS = "LOW:HIGH[:SPEED[:ACCELERATION[:TORQUE]]],.."


def run_list() -> None:
    """Run ``robot list``: names and titles."""
    for name in model.robot_names():
        print(f"{name:14s}{model.load_robot(name).title}")


class _Show(ViewOptions, RobotOptions):
    tool_frame: values.ToolFrame | None = None
    at: Positions | None = None
    """Positions to draw [deg or m] (default: 0)."""
    base: bool = False
    """Its base parameters, and what is grouped in each."""
    drawing: NewDrawing | None = None
    """Write a stick figure: .png, .svg or .pdf."""

    def __call__(self) -> None:
        robot = self.load()
        with about("--at"):
            q = in_si(self.at or (0.0,) * robot.n, robot)[None]
        shown = base_description(robot) if self.base else robot_description(model.stand_in.rehearsed(robot))
        print_report(Report("", shown), details=True)
        if self.drawing:
            self.tell(draw(robot, self.drawing, self.at))
        still = model.Motion(np.zeros(1), q, np.zeros_like(q), np.zeros_like(q))
        self.write_view(lambda: view.view_of(robot, still))


def _direction(text: str) -> tuple[float, float, float]:
    """Components of "x", "-y", .. or "a:b:c"."""
    if (axis := text.lstrip("+-")) in ("x", "y", "z"):
        x, y, z = ((-1.0 if text.startswith("-") else 1.0) * (axis == name) + 0.0 for name in "xyz")
    else:
        checked(text, text.count(":") == 2, text, "a direction: x, -y, .. or a:b:c")
        x, y, z = numbers(text.replace(":", ","), 3)
    return x, y, z


def joint_axis(text: str) -> model.JointAxis:
    """A joint by its axis: a direction and a point on it [m], and "slide" where it slides."""
    with about(f"{text!r} is not AXIS,X,Y,Z[,slide]"):
        parts = list(texts(text))
        slides = parts[-1] == "slide"
        direction, *point = parts[:-1] if slides else parts
        x, y, z = numbers(",".join(point), 3)
        return model.JointAxis("prismatic" if slides else "revolute", _direction(direction), (x, y, z))


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


class _New(Options):
    template: bool = False
    """Write a file to fill in, with an example of every key (default: to standard output)."""
    name: str | None = None
    """Short name of the robot."""
    joint: Annotated[tuple[model.JointAxis, ...], word(joint_axis, "AXIS,X,Y,Z[,slide]", None)] = ()
    """Direction of a joint's axis (x, -y, .. or a:b:c) and a point on it [m]; one option per joint."""
    flange: Annotated[model.Pose | None, word(flange, "X,Y,Z,ZAXIS,XAXIS")] = None
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
            for option in _New.__annotations__:
                if option not in ("template", "out", "overwrite"):
                    self.refuse(option, "belongs to a robot by options, --template is a file to fill in")
            return
        if missing := [f"--{name}" for name in ("name", "joint", "flange") if not getattr(self, name)]:
            raise InputError(f"give {', '.join(missing)}, or --template for a file to fill in")

    def __call__(self) -> None:
        robot = None if self.template else self.robot()
        text = model.robot_toml(robot) if robot else TEMPLATE.read_text(encoding="utf-8")
        if robot is None and self.out is None:
            print(text, end="")
            return
        out = Path(self.out or f"{self.name}.toml")
        if out.exists() and not self.overwrite:
            raise InputError(f"{out}: is there already: give another --out, or --overwrite")
        write_text(out, text)
        if robot is None:
            self.tell(f"Written: {out}. Fill it in, then: dynident robot show --robot {out}")
            return
        print_report(Report("", robot_description(robot)), details=True)
        self.tell(
            draw(robot, self.drawing or str(out.with_suffix(".svg")), self.drawn_at),
            f"Written: {out}. Compare the drawing with the data sheet before you use it. What else is known goes "
            "into the file: title, source, joint_names, .. as 'dynident robot new --template' shows them.",
        )
        if model.stand_in.nominal_bodies(robot) is None:
            note(f"to rehearse on it, add the mass of the arm to {out} (mass_kg = ..), or give --arm-mass KG")

    def robot(self) -> model.Robot:
        """The robot that the answers describe."""
        axes, drawn_at = list(self.joint), self.drawn_at or (0.0,) * len(self.joint)
        for option, parts in (("drawn-at", drawn_at), ("--limits", self.limits or axes)):
            if len(parts) != len(axes):
                raise InputError(f"{option} has {len(parts)} parts for {len(axes)} joints: give one per joint")
        for j, bounds in enumerate(self.limits or ()):
            scale = math.pi / 180.0 if axes[j].kind == "revolute" else 1.0
            low, high, speed, acceleration = (scale * bound for bound in bounds[:4])
            with about(f"--limits of joint {j + 1}"):
                axes[j] = replace(axes[j], limits=model.Limits((low, high), speed, acceleration, bounds[4]))
        robot = model.modified_dh(axes, self.flange or model.Pose())
        # Counted so that each joint stands at its part of drawn_at where the frames were taken.
        joints = tuple(
            replace(joint, theta=joint.theta - math.radians(q))
            if joint.revolute
            else replace(joint, r=round(joint.r - q, 12) + 0.0)
            for joint, q in zip(robot.joints, drawn_at, strict=True)
        )
        slow_speed = model.motion.usual_slow_speed([joint.revolute for joint in joints])
        with about():
            return replace(
                robot,
                name=self.name or "",
                joints=joints,
                payload_frame="the flange frame: origin on the flange face, z outwards",
                rated_payload=math.inf if self.rated_payload is None else self.rated_payload,
                mass=self.mass,
                processing=model.Processing(cutoff=10.0, decimate=5, slow_speed=slow_speed),
                title=self.name or "",
            )


def draw(robot: model.Robot, path: str, at: tuple[float, ...] | None) -> str:
    """Write the drawing of a robot at positions in degrees and metres (default: 0), and tell where."""
    at = at or (0.0,) * robot.n
    shown = ", ".join(f"{x:g}" for x in at)
    save_drawing(path, robot, in_si(at, robot).tolist(), f"{robot.title or robot.name} at {shown} (degrees, m)")
    return f"Drawn at {shown}: {path}"


class _RobotCheck(PageOptions, RecordingOptions, without=("equation_rate", "plots", "gain_sigma")):
    data: values.DataFiles
    """Recording without payload."""

    def __call__(self) -> bool:
        setup = self.setup()
        robot = setup.robot
        with status("reading") as progress:
            given = logs.grouped(self.data)
            logged = [logs.read_tool_poses(path, robot, setup.log_map) for path in given]
            poses = [estimation.check_pose(robot, log, progress) for log in logged if log]
            readings, named = None, partial(logs.named, robot=robot, log_map=setup.log_map)
            moved = [path for path in given if not poses or any(map(named(path).holds, ("torque", "current")))]
            if recordings := setup.read(moved):
                readings = estimation.rank_readings(robot, recordings, setup.processing, progress)
        shown = readings_report(robot, poses, readings)
        self.give(shown, lambda: robot_check_document(robot, poses, readings), setup.in_words())
        return readings_agree(poses, readings)


class _RobotExport(RobotOptions):
    rules: ClassVar = {"into": {"to": ("mjcf", "urdf")}}

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

    def __call__(self) -> bool:
        if len(self.robot_parameters) > 1:
            raise InputError("several --robot-parameters: give all recordings to one 'dynident identify'")
        form, robot, against = simulators.FORMATS[self.to], self.load(), list[str]()
        if self.robot_parameters:
            stored = results.read_stored_robot(path := self.robot_parameters[0])
            whole = stored_whole_robot(robot, stored, path)
            against += present(stored.reasons_against_use) or ()
        else:
            source = f"the description of {robot.name}, nothing identified"
            whole = estimation.whole_robot(robot, dict(robot.parameters), source)
        against += whole.heavier_than_the_arm()
        if against and not self.despite_verdict:
            return withheld("written", f"{'; '.join(against)} (--despite-verdict writes it all the same)")
        notes = list(robot_notes(form, whole))
        if self.into is None:
            text = form.text(whole)
        else:
            text, own = into(self.to, self.into, whole, form.head(form, whole))
            notes += own
        write_text(self.out, text)
        self.tell(f"{self.out}: {whole.source}. Prior: {whole.prior}.", *(f"  {line}" for line in notes))
        return True


class _Codegen(RobotOptions):
    function: Annotated[str | None, Parameter(metavar="NAME")] = None
    """What C computes, such as base_regressor."""
    language: Literal["c", "numpy"] = "c"
    """Of the code: c, one function; or numpy, one file of regressor and dynamics."""
    out: values.NewFolder
    """Folder of the files, made if missing."""

    def __call__(self) -> None:
        function, out = self.function, self.out
        if (self.language == "c") != (function is not None):
            known = ", ".join(model.code_names())
            needed = f"give one of {known}" if self.language == "c" else "is for C: leave it out"
            raise InputError(f"--function: {needed}")
        arm = self.load()
        made = [model.generate_numpy(arm, out)] if function is None else model.generate_code(arm, function, out)
        if not self.quiet:
            print(*(printable(str(path)) for path in made), sep="\n")
