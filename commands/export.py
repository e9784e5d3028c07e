"""``dynident export``: a payload in the format of a controller or a simulator."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import report
from ..common.errors import InputError
from ..common.files import write_text
from . import COMMANDS
from .arguments import ANSWERED, DO_NOT_USE, check_target

if TYPE_CHECKING:
    from collections.abc import Sequence


NAMES = (
    "abb", "kuka", "ur", "franka", "franka-desk", "fanuc", "yaskawa", "staubli", "opcua",
    "urdf", "sdf", "mjcf", "usd", "drake", "pinocchio",
)  # fmt: skip
"""The formats, told again here so that ``--help`` need not load them."""
_POSE = ("X", "Y", "Z", "RX", "RY", "RZ")


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser("export", help=COMMANDS["export"])
    parser.add_argument("payload", metavar="PAYLOAD.json", help="the --json of 'dynident payload'")
    parser.add_argument("--to", required=True, choices=NAMES, metavar="NAME", help=", ".join(NAMES))
    parser.add_argument("--out", metavar="F", help="file to write; the terminal by default")
    parser.add_argument(
        "--method",
        type=int,
        choices=(1, 2, 3, 4),
        help="whose estimate (default: the recommended, else 4, 3, 1, 2); the constrained one where it is there",
    )
    pose = "metres and degrees, R = Rz Ry Rx"
    parser.add_argument(
        "--flange-frame",
        type=float,
        nargs=6,
        metavar=_POSE,
        help=f"the controller's flange in the payload's frame ({pose}); needed unless that frame is the flange",
    )
    parser.add_argument(
        "--tool-frame",
        type=float,
        nargs=6,
        metavar=_POSE,
        help=f"abb: the tool in the flange frame ({pose}): writes a grip load in the tool frame, not a tool load",
    )
    parser.add_argument(
        "--meters-per-unit", type=float, metavar="M", help="usd: unit of length of the stage (default: 1)"
    )
    parser.add_argument(
        "--despite-verdict", action="store_true", help="write it, inertia and all, whatever the verdict"
    )
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run it."""
    check_target("out", arguments.out)
    form = report.controllers.FORMATS[arguments.to]
    _check_options(form, arguments)
    load = report.controllers.read_load(arguments.payload, arguments.method, arguments.despite_verdict)
    if load.verdict == "do_not_use" and not arguments.despite_verdict:
        reasons = "; ".join(load.reasons)
        print(f"dynident: not written: the verdict on {load.source} is 'do not use': {reasons}", file=sys.stderr)
        return DO_NOT_USE
    load = _placed(load, arguments)
    text = form.text(load)
    if form.comment is None and not form.head_inside:
        for line in form.head(load):
            print(f"dynident: note: {line}", file=sys.stderr)
    if arguments.out:
        write_text(arguments.out, text)
    else:
        print(text, end="")
    return ANSWERED


def _check_options(form: report.controllers.ControllerFormat, arguments: argparse.Namespace) -> None:
    """An option that the format does not know would be ignored."""
    for option, given, known in (
        (
            "--tool-frame",
            arguments.tool_frame,
            [f.name for f in report.controllers.FORMATS.values() if f.in_tool_frame],
        ),
        (
            "--meters-per-unit",
            arguments.meters_per_unit,
            [f.name for f in report.controllers.FORMATS.values() if f.own_units],
        ),
    ):
        if given is not None and form.name not in known:
            raise InputError(f"{option} belongs to --to {', '.join(known)}, not to {form.name}")


def _placed(
    load: report.controllers.ControllerLoad, arguments: argparse.Namespace
) -> report.controllers.ControllerLoad:
    """The load in the frame and the units that were asked for."""
    if arguments.flange_frame is not None:
        load = _seen_from(
            load, arguments.flange_frame, f"flange, at {_told(arguments.flange_frame)} in {load.frame}"
        )
    elif not report.controllers.payload_file.is_flange(load.frame):
        raise InputError(
            f"{arguments.payload}: the payload's frame is {load.frame!r}, not the flange: give --flange-frame, the "
            "flange's pose in it (0 0 0 0 0 0 if it is the same)"
        )
    if arguments.tool_frame is not None:
        told = f"tool, at {_told(arguments.tool_frame)} in the flange"
        load = replace(_seen_from(load, arguments.tool_frame, told), in_tool_frame=True)
    if arguments.meters_per_unit is not None:
        load = replace(load, meters_per_unit=arguments.meters_per_unit)
    return load


def _seen_from(
    load: report.controllers.ControllerLoad, pose: Sequence[float], frame: str
) -> report.controllers.ControllerLoad:

    if not np.isfinite(pose).all():
        raise InputError(f"a frame of {_told(pose)}: six finite numbers are needed")
    rx, ry, rz = np.radians(pose[3:])
    return load.seen_from(
        report.controllers.rotation.matrix(report.controllers.rotation.Angles(rz, ry, rx)),
        np.array(pose[:3]),
        frame,
    )


def _told(pose: Sequence[float]) -> str:
    place, turn = (", ".join(f"{value:g}" for value in part) for part in (pose[:3], pose[3:]))
    return f"({place}) m, ({turn}) deg"
