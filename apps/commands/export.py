"""``dynident export``: a payload in the format of a controller or a simulator."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from ... import model
from ...common.errors import InputError, one_line
from ...common.files import write_text
from ..export import controllers
from ..export.load import ControllerLoad, read_load
from . import ANSWERED, DO_NOT_USE
from .entry import SETTING, Options, command
from .values import NewFile, PayloadResultFile, number, word, words

if TYPE_CHECKING:
    Name = str
else:  # the files' names: --help need not load them
    Name = Literal[tuple(controllers.FORMATS)]
_FARTHEST = 100.0  # m
_Pose = Annotated[tuple[float, float, float, float, float, float], words(number, "X Y Z RX RY RZ")]


class _Export(Options):
    to: Annotated[Name, Parameter(metavar="NAME")]
    """The format."""
    out: NewFile | None = None
    """File to write; the terminal by default."""
    method: Annotated[Literal[1, 2, 3, 4] | None, Parameter(show_choices=False)] = None
    """1 to 4: whose estimate (default: the recommended, else 3, 4, 1, 2); the constrained one where it is there."""
    flange_frame: _Pose | None = None
    """The controller's flange in the payload's frame: metres and degrees, R = Rz Ry Rx; needed unless that frame is
    the flange, or the robot's file tells where it is."""
    tool_frame: _Pose | None = None
    """abb: the tool in the flange frame, likewise: writes a grip load in the tool frame, not a tool load."""
    meters_per_unit: Annotated[float | None, word(number, "M"), SETTING] = None
    """usd: unit of length of the stage (default: 1)."""
    despite_verdict: bool = False
    """Write it, inertia and all, whatever the verdict."""


@command
def run(payload: PayloadResultFile, *, request: _Export) -> int:
    """Run it.

    Args:
        payload: The --json of 'dynident payload'.
    """
    form = controllers.FORMATS[request.to]
    for option, held in (("tool_frame", "tool frame"), ("meters_per_unit", "units")):
        if held not in form.holds:  # it would be ignored
            known = [name for name, other in controllers.FORMATS.items() if held in other.holds]
            request.refuse(option, f"belongs to --to {', '.join(known)}, not to {form.name}")
    load = read_load(payload, request.method, request.despite_verdict)
    if not request.despite_verdict and (load.verdict == "do_not_use" or load.beyond_rating):
        why = f"the verdict on {load.source} is 'do not use': {'; '.join(load.reasons)}"
        if load.verdict != "do_not_use":
            why = f"{load.source}: {load.beyond_rating}; --despite-verdict writes it all the same"
        print(f"dynident: not written: {one_line(why)}", file=sys.stderr)
        return DO_NOT_USE
    if request.flange_frame is not None:
        load = _seen_from("--flange-frame", load, request.flange_frame, "flange", load.frame)
    elif (at_flange := load.in_flange()) is not None:
        load = at_flange
    else:
        raise InputError(
            f"{load.source}: the payload's frame is {load.frame!r}, not the flange: give --flange-frame, the "
            "flange's pose in it (0 0 0 0 0 0 if it is the same)"
        )
    if request.tool_frame is not None:
        load = _seen_from("--tool-frame", load, request.tool_frame, "tool", "the flange")
        load = replace(load, in_tool_frame=True)
    if request.meters_per_unit is not None:
        load = replace(load, meters_per_unit=request.meters_per_unit)
    text = form.text(load)
    if request.out:
        write_text(request.out, text)
    else:
        print(text, end="")
    return ANSWERED


def _seen_from(option: str, load: ControllerLoad, pose: Sequence[float], name: str, of: str) -> ControllerLoad:
    """The load in a frame that stands at a pose, in metres and degrees, in the present one."""
    place, turn = (", ".join(f"{value:g}" for value in part) for part in (pose[:3], pose[3:]))
    told = f"({place}) m, ({turn}) deg"
    if max(map(abs, pose[:3])) > _FARTHEST:
        raise InputError(f"{option} {told}: metres up to {_FARTHEST:g} and degrees are needed")
    frame = model.Pose.from_rpy(pose[:3], [math.radians(angle) for angle in pose[3:]])
    return load.seen_from(frame.R, frame.p, f"{name}, at {told} in {of}")
