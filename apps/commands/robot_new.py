"""``dynident robot new``: a robot's TOML from a data sheet, with a drawing to lay beside the sheet."""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from ... import model
from ...common.errors import InputError
from ...common.files import write_text
from .. import report
from . import ANSWERED
from .options import Options, option, print_lines
from .progress import note
from .robot_show import check_drawing, draw
from .values import number, numbers, texts

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
DESCRIPTION = """
Take any pose in which the data sheet draws the arm. x, y, z are those of the base: z up along the mounting, x to
the front. For every joint, base to tip, give the direction of its axis (by the right-hand rule: thumb along it, the
fingers turn the way the sheet counts positive) and any point on the axis; then the flange. Where the modified DH
table is known, --template gives its file to fill in.
"""
"""What its help says."""
TEMPLATE = """\
# A robot: replace the example's values; what is not known may be left out. Lengths in m, angles in degrees.
name = "my_arm"
title = "Maker's name of the arm"
source = "where the numbers come from"
rated_payload_kg = 5
# The whole arm with its base: only rehearsals (simulate, design, near) use it.
mass_kg = 30
# Names of the joints in your logs, base to tip.
joint_names = [["joint_1", "joint_2", "joint_3"]]
payload_frame = "the bare flange: origin on its face, z out of it"
# In the base's frame; z up: an arm on the floor.
gravity = [0, 0, -9.81]

# The frame of the payload in the last joint's frame.
[flange]
xyz = [0, 0, 0]
rpy_deg = [0, 0, 0]

# Frame 0, in which joint 1 turns, in the robot's base.
[base]
xyz = [0, 0, 0]
rpy_deg = [0, 0, 0]

# Joints from base to tip, modified DH (Khalil, Craig): from frame j-1 turn by alpha about x and go d along it, then
# turn by theta about z, which is the joint's axis, and go r along it. theta is its angle where the arm counts zero.
[[joints]]
alpha_deg = 0
r = 0.4
position_deg = [-170, 170]
speed_deg_s = 220
acceleration_deg_s2 = 900
# Largest torque, N·m: of every joint, or of none.
torque = 300

[[joints]]
alpha_deg = -90
d = 0.05
theta_deg = -90
position_deg = [-90, 120]
speed_deg_s = 200
torque = 300

# A joint that slides; r is where it stands when the arm counts zero.
[[joints]]
kind = "prismatic"
alpha_deg = -90
r = 0.1
position_m = [0, 0.5]
speed_m_s = 0.8
acceleration_m_s2 = 4
torque = 500

# Where torque is measured: "motor" (currents too) or "link" (sensors behind the gears).
[drives]
side = "motor"
# Two coupled drives, as wrists have:
# coupling = { joints = [2, 3] }

# How recordings are treated: low-pass of positions and torques, and every k-th row is kept.
[processing]
cutoff_hz = 10
decimate = 5

# Bodies and drives of a robot whose parameters are known (XX1 to M1, IA1, FV1, FS1, ..), for simulation:
# [parameters]
# M1 = 10
"""
"""A description that loads as it stands."""


@dataclass(frozen=True)
class _Sheet(Options):
    """What a data sheet says."""

    template: bool = option(
        action="store_true", help="a file to fill in: every key with an example (default: to standard output)"
    )
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
    side: str | None = option(choices=("motor", "link"), help="where torque is measured (default: motor)")
    source: str | None = option(help="where the numbers come from")
    out: str | None = option(writes="file", metavar="F.toml", help="file to write (default: NAME.toml)")
    drawing: str | None = option(
        writes="file", metavar="F", help=".svg, .png or .pdf (default: beside the file, .svg)"
    )
    overwrite: bool = option(action="store_true", help="replace the file if it is there")


def run(request: _Sheet) -> int:
    """Run it."""
    if request.template:
        return _write_template(request)
    check_drawing(request.drawing)
    if missing := [f"--{name}" for name in ("name", "joint", "flange") if not request.has(name)]:
        raise InputError(f"give {', '.join(missing)}, or --template for a file to fill in")
    robot, drawn_at = new_robot(request)
    out = Path(request.out or f"{robot.name}.toml")
    _write(request, out, model.robot_toml(robot, request.source or ""))
    report.print_blocks(report.robot_description(robot))
    draw(robot, request.drawing or str(out.with_suffix(".svg")), drawn_at)
    print_lines(f"Written: {out}. Compare the drawing with the data sheet before you use it.")
    if not model.stand_in.can_stand_in(robot):
        note(f"to rehearse on it, add the mass of the arm to {out} (mass_kg = ..), or give --arm-mass KG")
    return ANSWERED


def _write(request: _Sheet, out: Path, text: str) -> None:
    """Write the file, over another one only where that is wanted."""
    if out.exists() and not request.overwrite:
        raise InputError(f"{out}: is there already: give another --out, or --overwrite")
    write_text(out, text)


def _write_template(request: _Sheet) -> int:
    """The file to fill in; what options say of the robot is said in it."""
    for entry in fields(request):
        if entry.name not in ("template", "out", "overwrite"):
            request.refuse(entry.name, "belongs to a robot by options, --template is a file to fill in")
    if request.out is None:
        print(TEMPLATE, end="")
    else:
        _write(request, Path(request.out), TEMPLATE)
        print_lines(f"Written: {request.out}. Fill it in, then: dynident robot show --robot {request.out}")
    return ANSWERED


def new_robot(sheet: _Sheet) -> tuple[model.Robot, tuple[float, ...]]:
    """The robot that the answers describe, and the positions [deg or m] of the pose they describe it in.

    Raises:
        InputError: names the option that does not fit.
    """
    axes = [_axis(text) for text in sheet.joint or ()]
    flange, name = _flange(sheet.flange or ""), sheet.name or ""
    drawn_at = _counted("--drawn-at", sheet.drawn_at, len(axes)) or (0.0,) * len(axes)
    axes = _limited(axes, sheet)
    frames = model.modified_dh(axes, flange)
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


def _processing(axes: list[model.JointAxis]) -> model.Processing:
    slow_speed = model.motion.usual_slow_speed([axis.kind == "revolute" for axis in axes])
    return model.Processing(cutoff=10.0, decimate=5, slow_speed=slow_speed)


def _shifted(joint: Any, q: float) -> Any:
    """The joint counted so that it stands at ``q`` [deg or m] where the frames were taken."""
    if joint.revolute:
        return replace(joint, theta=joint.theta - math.radians(q))
    return replace(joint, r=round(joint.r - q, 12) + 0.0)


def _limited(axes: list[model.JointAxis], sheet: _Sheet) -> list[model.JointAxis]:
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


def _axis(text: str) -> model.JointAxis:

    slides = text.replace(" ", "").endswith(",slide")
    try:
        axis, *origin = _parts(text, ",", 4 + slides)[:4]
        x, y, z = map(_real, origin)
        point = (x, y, z)
        return model.JointAxis("prismatic" if slides else "revolute", _direction(axis), point)
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
