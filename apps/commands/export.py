"""``dynident export``: a payload in the format of a controller or a simulator."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from ...common.errors import InputError
from ...common.files import write_text
from ..export import controllers
from ..export.load import read_load
from ..numbers import placed
from .entry import SETTING, Options, about, command
from .progress import withheld
from .values import FrameWords, NewFile, PayloadResultFile, number, word

if TYPE_CHECKING:
    Name = str
else:  # the files' names: --help need not load them
    Name = Literal[tuple(controllers.FORMATS)]


class _Export(Options):
    to: Annotated[Name, Parameter(metavar="NAME")]
    """Format to write."""
    out: NewFile | None = None
    """File to write (default: the terminal)."""
    method: Annotated[Literal[1, 2, 3, 4] | None, Parameter(show_choices=False)] = None
    """Method whose estimate is written, 1 to 4 (default: the recommended one)."""
    flange_frame: FrameWords | None = None
    """The flange in the payload's frame: metres and degrees, R = Rz Ry Rx; needed if the payload is not given at
    the flange and the robot's file does not say where that is."""
    tool_frame: FrameWords | None = None
    """abb: write a grip load in this tool frame, given as above relative to the flange, instead of a tool load."""
    meters_per_unit: Annotated[float | None, word(number, "M"), SETTING] = None
    """usd: unit of length of the stage (default: 1)."""
    despite_verdict: bool = False
    """Write everything, whatever the verdict."""


@command
def run(payload: PayloadResultFile, *, request: _Export) -> bool:
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
    if load.against and not request.despite_verdict:
        return withheld("written", f"{load.against}; --despite-verdict writes it all the same")
    at_flange = load.in_flange()
    if (pose := request.flange_frame) is not None:
        with about("--flange-frame"):
            at_flange = load.seen_from(pose, f"flange, at {placed(pose)} in {load.frame}")
    if at_flange is None:
        raise InputError(
            f"{load.source}: the payload's frame is {load.frame!r}, not the flange: give --flange-frame, the "
            "flange's pose in it (0 0 0 0 0 0 if it is the same)"
        )
    load = at_flange
    if (pose := request.tool_frame) is not None:
        with about("--tool-frame"):
            load = replace(load.seen_from(pose, f"tool, at {placed(pose)} in the flange"), in_tool_frame=True)
    if request.meters_per_unit is not None:
        load = replace(load, meters_per_unit=request.meters_per_unit)
    text = form.text(load)
    if request.out:
        write_text(request.out, text)
    else:
        print(text, end="")
    return True
