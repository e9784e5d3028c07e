"""``dynident robot new``: a robot's TOML from a data sheet, with a drawing to lay beside the sheet."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
from cyclopts import Parameter

from ... import model
from ...common.errors import InputError
from ...common.files import write_text
from .. import report
from . import ANSWERED
from .entry import SETTING, command, options
from .options import Options, print_lines
from .progress import note
from .values import NewFile, Positions, checked, number, numbers, positive_number, texts, word, words

if TYPE_CHECKING:
    from ...model import JointAxis, Pose
else:  # --help names options without importing what they become
    JointAxis = Pose = object

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_FORMATS = (".png", ".svg", ".pdf")
TEMPLATE = Path(__file__).with_name("robot_template.toml")
"""A description that loads as it stands, with every key that a robot's file may have."""


def _direction(text: str) -> tuple[float, float, float]:
    """Components of "x", "-y", .. or "a:b:c"."""
    plain = text.lstrip("+-")
    if plain in _AXES:
        sign = -1.0 if text.startswith("-") else 1.0
        x, y, z = (sign * component + 0.0 for component in _AXES[plain])
        return x, y, z
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
    parts = texts(text)
    try:
        checked(text, len(parts) == 5, text, "X,Y,Z,ZAXIS,XAXIS")
        along, across = (np.array(_direction(part)) for part in parts[3:])
        along, across = along / np.linalg.norm(along), across / np.linalg.norm(across)
        turned = np.column_stack([across, np.cross(along, across), along])
        return model.Pose.of(turned, np.array(numbers(",".join(parts[:3]), 3)))
    except ValueError as error:
        raise ValueError(
            f"{text!r}: X,Y,Z,ZAXIS,XAXIS with two directions at right angles is needed ({error})"
        ) from None


def joint_limits(text: str) -> tuple[tuple[float, ...], ...]:
    """Limits of each joint, LOW:HIGH[:SPEED[:ACCELERATION[:TORQUE]]]; those left empty or out are infinite."""
    joints = []
    for part in texts(text):
        ends = part.split(":")
        words = "LOW:HIGH[:SPEED[:ACCELERATION[:TORQUE]]], such as -170:170:220::300"
        checked(ends, 2 <= len(ends) <= 5, part, words)
        low, high, *rest = [*ends, "", "", ""][:5]
        bounds = (number(low) if low else -math.inf, number(high) if high else math.inf)
        joints.append((*bounds, *(positive_number(bound) if bound else math.inf for bound in rest)))
    return tuple(joints)


_LIMITS = "LOW:HIGH[:SPEED[:ACCELERATION[:TORQUE]]],.."


@options()
class _Sheet(Options):
    """Entries of a data sheet."""

    template: bool = False
    """A file to fill in: every key with an example (default: to standard output)."""
    name: str | None = None
    """Short name."""
    joint: Annotated[tuple[JointAxis, ...], words(joint_axis, "AXIS,X,Y,Z[,slide]")] = ()
    """x, -y, .. or a:b:c, and a point [m]; one option per joint."""
    flange: Annotated[Pose | None, word(flange, "X,Y,Z,ZAXIS,XAXIS")] = None
    """Origin [m], direction out of it, its x axis."""
    drawn_at: Annotated[Positions | None, SETTING] = None
    """Joint positions of that pose [deg or m]."""
    limits: Annotated[tuple[tuple[float, ...], ...] | None, word(joint_limits, _LIMITS)] = None
    """One part a joint, as far as they are known [deg or m, per s, N·m or N]: -170:170:220::300."""
    rated_payload: Annotated[float | None, word(number, "KG")] = None
    """Rated payload by the data sheet."""
    mass: Annotated[float | None, word(number, "KG")] = None
    """Mass of the whole arm, its base with it, if known."""
    out: Annotated[NewFile | None, Parameter(metavar="F.toml")] = None
    """File to write (default: NAME.toml)."""
    drawing: NewFile | None = None
    """.svg, .png or .pdf (default: beside the file, .svg)."""
    overwrite: bool = False
    """Replace the file if it is there."""

    def write(self, out: Path, text: str) -> None:
        """Write the file, over another one only where that is wanted."""
        if out.exists() and not self.overwrite:
            raise InputError(f"{out}: is there already: give another --out, or --overwrite")
        write_text(out, text)


@command
def run(*, request: _Sheet) -> int:
    """Run it."""
    if request.template:
        for entry in fields(request):
            if entry.name not in ("template", "out", "overwrite"):
                request.refuse(entry.name, "belongs to a robot by options, --template is a file to fill in")
        if request.out is None:
            print(TEMPLATE.read_text(encoding="utf-8"), end="")
        else:
            request.write(Path(request.out), TEMPLATE.read_text(encoding="utf-8"))
            print_lines(f"Written: {request.out}. Fill it in, then: dynident robot show --robot {request.out}")
        return ANSWERED
    check_drawing(request.drawing)
    if missing := [f"--{name}" for name in ("name", "joint", "flange") if not request.has(name)]:
        raise InputError(f"give {', '.join(missing)}, or --template for a file to fill in")
    robot, drawn_at = new_robot(request)
    out = Path(request.out or f"{robot.name}.toml")
    request.write(out, model.robot_toml(robot))
    report.print_blocks(report.robot_description(robot))
    draw(robot, request.drawing or str(out.with_suffix(".svg")), drawn_at)
    print_lines(
        f"Written: {out}. Compare the drawing with the data sheet before you use it. What else is known goes into "
        "the file: title, source, joint_names, .. as 'dynident robot new --template' shows them."
    )
    if not model.stand_in.can_stand_in(robot):
        note(f"to rehearse on it, add the mass of the arm to {out} (mass_kg = ..), or give --arm-mass KG")
    return ANSWERED


def new_robot(sheet: _Sheet) -> tuple[model.Robot, tuple[float, ...]]:
    """The robot that the answers describe, and the positions [deg or m] of the pose they describe it in."""
    axes, name = list(sheet.joint or ()), sheet.name or ""
    drawn_at = sheet.drawn_at or (0.0,) * len(axes)
    for option_name, values in (("drawn-at", drawn_at), ("--limits", sheet.limits or axes)):
        if len(values) != len(axes):
            raise InputError(f"{option_name} has {len(values)} parts for {len(axes)} joints: give one per joint")
    for j, bounds in enumerate(sheet.limits or ()):
        scale = math.pi / 180.0 if axes[j].kind == "revolute" else 1.0
        low, high, speed, acceleration = (scale * bound for bound in bounds[:4])
        try:
            limits = model.Limits((low, high), speed, acceleration, bounds[4])
        except ValueError as error:
            raise InputError(f"--limits of joint {j + 1}: {error}") from None
        axes[j] = replace(axes[j], limits=limits)
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
            payload_frame="the bare flange: origin on its face, z out of it",
            rated_payload=math.inf if sheet.rated_payload is None else sheet.rated_payload,
            mass=sheet.mass,
            processing=model.Processing(cutoff=10.0, decimate=5, slow_speed=slow_speed),
            title=name,
        )
    except ValueError as error:
        raise InputError(str(error)) from None
    return robot, drawn_at


def check_drawing(path: str | None) -> None:
    """Refuse a drawing in a format that is not known."""
    if path and Path(path).suffix.lower() not in _FORMATS:
        raise InputError(f"--drawing {path!r}: a drawing ends in .png, .svg or .pdf")


def draw(robot: model.Robot, path: str, at: tuple[float, ...]) -> None:
    """Write the drawing of a robot at positions in degrees and metres, and say so."""
    q = [math.radians(x) if joint.revolute else x for x, joint in zip(at, robot.joints, strict=True)]
    shown = ", ".join(f"{x:g}" for x in at)
    report.save_drawing(path, robot, q, f"{robot.title or robot.name} at {shown} (degrees, m)")
    print_lines(f"Drawn at {shown}: {path}")
