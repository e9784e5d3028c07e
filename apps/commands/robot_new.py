"""``dynident robot new``: a robot's TOML from a data sheet, with a drawing to lay beside the sheet."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ... import model
from ...common.errors import InputError
from ...common.files import write_text
from .. import report
from . import ANSWERED
from .dialogue import ask
from .options import Options, option, print_lines
from .progress import note
from .robot_show import check_drawing, draw
from .values import number, numbers, positive_number, texts

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
DESCRIPTION = """
Take any pose in which the data sheet draws the arm. x, y, z are those of the base: z up along the mounting, x to
the front. For every joint, base to tip, give the direction of its axis (by the right-hand rule: thumb along it, the
fingers turn the way the sheet counts positive) and any point on the axis; then the flange. What is not given as
an option is asked for.
"""
"""What its help says."""


@dataclass(frozen=True)
class _Sheet(Options):
    """What a data sheet says; what must be known and is not given is asked for."""

    name: str | None = option(help="short name")
    title: str | None = option(help="full name")
    joint: tuple[str, ...] | None = option(
        action="append",
        metavar="AXIS,X,Y,Z[,slide]",
        help="x, -y, .. or a:b:c, and a point [m]; one option per joint, --joint=-y,.. for a leading minus",
    )
    flange: str | None = option(metavar="X,Y,Z,ZAXIS,XAXIS", help="origin [m], direction out of it, its x axis")
    drawn_at: tuple[float, ...] | None = option(
        type=numbers, metavar="Q1,..", help="joint positions of that pose [deg or m]"
    )
    limits: str | None = option(metavar="LOW:HIGH,..", help="positions, one pair a joint [deg or m]")
    speeds: tuple[float, ...] | None = option(type=numbers, metavar="V1,..", help="largest speeds [deg/s or m/s]")
    torques: tuple[float, ...] | None = option(
        type=numbers, metavar="T1,..", help="largest torques [N·m or N], if known"
    )
    accelerations: tuple[float, ...] | None = option(
        type=numbers, metavar="A1,..", help="largest accelerations [deg/s² or m/s²], if known"
    )
    rated_payload: float | None = option(type=number, metavar="KG", help="by the data sheet")
    mass: float | None = option(type=number, metavar="KG", help="of the whole arm, its base with it, if known")
    joint_names: tuple[str, ...] | None = option(
        type=texts, metavar="A,B,..", help="of the joints in your logs, base to tip"
    )
    side: str = option(choices=("motor", "link"), default="motor", help="where torque is measured")
    source: str = option(default="", help="where the numbers come from")
    out: str | None = option(writes="file", metavar="F.toml", help="file to write (default: NAME.toml)")
    drawing: str | None = option(
        writes="file", metavar="F", help=".svg, .png or .pdf (default: beside the file, .svg)"
    )
    overwrite: bool = option(action="store_true", help="replace the file if it is there")


def run(request: _Sheet) -> int:
    """Run it."""
    check_drawing(request.drawing)
    sheet = asked(request)
    robot, drawn_at = new_robot(sheet)
    out = Path(sheet.out or f"{robot.name}.toml")
    if out.exists() and not sheet.overwrite:
        raise InputError(f"{out}: is there already: give another --out, or --overwrite")
    write_text(out, model.files.robot_toml(robot, sheet.source))
    report.print_blocks(report.robot_description(robot))
    draw(robot, sheet.drawing or str(out.with_suffix(".svg")), drawn_at)
    print_lines(f"Written: {out}. Compare the drawing with the data sheet before you use it.")
    if not model.stand_in.can_stand_in(robot):
        note(f"to rehearse on it, add the mass of the arm to {out} (mass_kg = ..), or give --arm-mass KG")
    return ANSWERED


def asked(sheet: _Sheet) -> _Sheet:
    """The sheet with answers to what it leaves out.

    Raises:
        InputError: without a terminal to ask on; names what is missing.
    """
    missing = [name for name in ("name", "joint", "flange") if not getattr(sheet, name)]
    if not missing:
        return sheet
    if not sys.stdin.isatty():
        options = ", ".join(f"--{name}" for name in missing)
        raise InputError(f"give {options}, or run it in a terminal to be asked")
    print(" ".join(DESCRIPTION.split()))
    name = sheet.name or ask("Short name", str)
    joint = sheet.joint or _asked_joints()
    flange = sheet.flange or ask(
        "Flange: x,y,z [m], direction out of it, its x axis (0.9,0,1.2,x,-z)", _checked(_flange)
    )
    sheet = replace(sheet, name=name, joint=joint, flange=flange)
    for field, question in _OPTIONAL.items():
        if getattr(sheet, field) is None:
            answer = ask(question, partial(_read, sheet, field), optional=True)
            sheet = replace(sheet, **{field: answer})
    return sheet


_OPTIONAL = {
    "drawn_at": "Joint positions of that pose [deg or m], all zero if not given",
    "limits": "Position limits, low:high of each joint [deg or m]",
    "speeds": "Largest speeds [deg/s or m/s]",
    "accelerations": "Largest accelerations [deg/s² or m/s²]",
    "torques": "Largest torques [N·m or N]",
    "rated_payload": "Rated payload [kg]",
    "mass": "Mass of the arm, base and all [kg]",
    "joint_names": "Names of the joints in your logs, base to tip",
}
"""Questions whose answers may stay unknown, by option."""


def _read(sheet: _Sheet, field: str, text: str) -> Any:
    """An answer as its option holds it; a robot is built with it, so that what does not fit is told at once."""
    reads: dict[str, Callable[[str], Any]] = {
        "limits": str,
        "rated_payload": positive_number,
        "mass": positive_number,
        "joint_names": texts,
    }
    value = reads.get(field, numbers)(text)
    new_robot(replace(sheet, **{field: value}))
    return value


def _asked_joints() -> tuple[str, ...]:
    joints: list[str] = []
    while True:
        question = f"Joint {len(joints) + 1}: axis,x,y,z [m]{' (empty: no more joints)' if joints else ''}"
        text = ask(question, _checked(_axis), optional=bool(joints))
        if text is None:
            return tuple(joints)
        joints.append(text)


def _checked(read: Callable[[str], Any]) -> Callable[[str], str]:
    """Reads a text as it is, if ``read`` can make something of it."""

    def checked(text: str) -> str:
        read(text)
        return text

    return checked


def new_robot(sheet: _Sheet) -> tuple[model.Robot, tuple[float, ...]]:
    """The robot that the answers describe, and the positions [deg or m] of the pose they describe it in.

    Raises:
        InputError: names the option that does not fit.
    """
    axes = [_axis(text) for text in sheet.joint or ()]
    flange, name = _flange(sheet.flange or ""), sheet.name or ""
    drawn_at = _counted("--drawn-at", sheet.drawn_at, len(axes)) or (0.0,) * len(axes)
    axes = _limited(axes, sheet)
    frames = model.files.modified_dh(axes, flange)
    x, y, z = (frames.base.R[:, 2] * -9.81 + 0.0).tolist()
    try:
        robot = model.Robot(
            name=name,
            joints=tuple(map(_shifted, frames.joints, drawn_at)),
            gravity=(x, y, z),
            drives=model.Drives.on_link_side() if sheet.side == "link" else model.Drives(),
            payload_frame="the bare flange: origin on its face, z out of it",
            flange=frames.flange,
            base=frames.base,
            rated_payload=math.inf if sheet.rated_payload is None else sheet.rated_payload,
            mass=sheet.mass,
            joint_names=(sheet.joint_names,) if sheet.joint_names else (),
            processing=_processing(axes),
            title=sheet.title or name,
        )
    except ValueError as error:
        raise InputError(str(error)) from None
    return robot, drawn_at


def _processing(axes: list[model.files.JointAxis]) -> model.Processing:
    slow_speed = model.motion.usual_slow_speed([axis.kind == "revolute" for axis in axes])
    return model.Processing(cutoff=10.0, decimate=5, slow_speed=slow_speed)


def _shifted(joint: Any, q: float) -> Any:
    """The joint counted so that it stands at ``q`` [deg or m] where the frames were taken."""
    if joint.revolute:
        return replace(joint, theta=joint.theta - math.radians(q))
    return replace(joint, r=round(joint.r - q, 12) + 0.0)


def _limited(axes: list[model.files.JointAxis], sheet: _Sheet) -> list[model.files.JointAxis]:
    """The axes with the limits that were given."""
    n = len(axes)
    speeds = _counted("--speeds", sheet.speeds, n) or (math.inf,) * n
    accelerations = _counted("--accelerations", sheet.accelerations, n) or (math.inf,) * n
    torques = _counted("--torques", sheet.torques, n) or (math.inf,) * n
    pairs = sheet.limits.split(",") if sheet.limits else None
    if pairs and len(pairs) != n:
        raise InputError(f"--limits has {len(pairs)} pairs for {n} joints: give low:high for each")
    limited = []
    for j, axis in enumerate(axes):
        scale = math.pi / 180.0 if axis.kind == "revolute" else 1.0
        position = (-math.inf, math.inf)
        try:
            if pairs:
                low, high = (scale * _real(end) for end in _parts(pairs[j], ":", 2))
                position = (low, high)
            limits = model.Limits(position, scale * speeds[j], scale * accelerations[j], torques[j])
        except ValueError as error:
            raise InputError(f"limits of joint {j + 1}, low:high: {error}") from None
        limited.append(replace(axis, limits=limits))
    return limited


def _counted(option: str, values: tuple[float, ...] | None, n: int) -> tuple[float, ...] | None:

    if values is not None and len(values) != n:
        raise InputError(f"{option} has {len(values)} numbers for {n} joints: give one per joint")
    return values


def _axis(text: str) -> model.files.JointAxis:

    slides = text.replace(" ", "").endswith(",slide")
    try:
        axis, *origin = _parts(text, ",", 4 + slides)[:4]
        x, y, z = map(_real, origin)
        point = (x, y, z)
        return model.files.JointAxis("prismatic" if slides else "revolute", _direction(axis), point)
    except ValueError as error:
        raise InputError(f"--joint {text!r}: AXIS,X,Y,Z[,slide] is needed ({error})") from None


def _flange(text: str) -> model.Pose:

    try:
        *origin, out, side = _parts(text, ",", 5)
        x, y, z = map(_real, origin)
        along, across = np.array(_direction(out)), np.array(_direction(side))
        along, across = along / np.linalg.norm(along), across / np.linalg.norm(across)
        return model.Pose.of(np.column_stack([across, np.cross(along, across), along]), np.array([x, y, z]))
    except ValueError as error:
        raise InputError(
            f"--flange {text!r}: X,Y,Z,ZAXIS,XAXIS with two directions at right angles is needed ({error})"
        ) from None


def _direction(text: str) -> tuple[float, float, float]:
    """ "x", "-y", .. or three components "a:b:c"."""
    plain = text.lstrip("+-")
    if plain in _AXES:
        a, b, c = _AXES[plain]
        sign = -1.0 if text.startswith("-") else 1.0
        return sign * a + 0.0, sign * b + 0.0, sign * c + 0.0
    if ":" not in text:
        raise ValueError(f"{text!r} is no direction: x, -y, .. or a:b:c")
    a, b, c = map(_real, _parts(text, ":", 3))
    return a, b, c


def _parts(text: str, mark: str, count: int) -> list[str]:
    """So many words with a mark between them."""
    words = [word.strip() for word in text.split(mark)]
    if len(words) != count:
        raise ValueError(f"{count} parts with {mark!r} between them, not {len(words)}")
    return words


def _real(word: str) -> float:
    try:
        return number(word)
    except argparse.ArgumentTypeError as error:
        raise ValueError(str(error)) from None
