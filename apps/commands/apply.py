"""``dynident apply``: a payload into the controller, beside the program that runs there; never a motion."""

from __future__ import annotations

import math
import sys
import time
from typing import TYPE_CHECKING, Annotated, Literal

from ...common.errors import InputError, one_line, printable
from .. import export, live
from . import ANSWERED, DO_NOT_USE
from .entry import SETTING, command
from .options import HostOptions
from .progress import note, quiet
from .values import PayloadResultFile, Port

if TYPE_CHECKING:
    from ..export.load import ControllerLoad

_PATIENCE = 2.0
"""s: by then the controller shows the payload that it was given."""
_CLOSE = 2e-6
"""Share by which numbers that are read back may differ: some controllers hold them in single precision."""
_FIELDS = (live.TIME, live.MASS, live.CENTRE, live.INERTIA)


@command
def run(
    payload: PayloadResultFile,
    *,
    to: Literal["ur"],
    yes: bool = False,
    despite_verdict: bool = False,
    controller: HostOptions,
    script_port: Annotated[Port | None, SETTING] = None,
) -> int:
    """Run it: nothing is sent before the word is given.

    Args:
        payload: The --json of 'dynident payload' or 'weigh'.
        to: Whose controller: ur, a Universal Robots one.
        yes: Send it without asking.
        despite_verdict: Send it, inertia and all, whatever the verdict.
        script_port: Port of scripts of the controller (default: 30002).
    """
    load = export.read_load(payload, None, despite_verdict)
    if not despite_verdict and load.verdict == "do_not_use":
        why = f"the verdict on {load.source} is 'do not use': {'; '.join(load.reasons)}"
        print(one_line(f"dynident: not sent: {why}"), file=sys.stderr)
        return DO_NOT_USE
    if load.beyond_rating:
        raise InputError(f"{load.source}: {load.beyond_rating}: not sent")
    at_flange = load.in_flange()
    if at_flange is None:
        raise InputError(f"{payload}: the payload's frame is {load.frame!r}, not the flange: nothing was sent")
    load = at_flange.rounded()
    if not controller.host:
        raise InputError("give --host, the controller's name or address")
    lines = export.controllers.FORMATS["ur"].text(load).splitlines()
    (line,) = [line for line in lines if line.startswith("set_target_payload(")]
    text = live.program(line)
    if not quiet():
        print(f"To {controller.host}, beside the program that runs there:\n\n{printable(text)}")
    if not yes:
        asked = sys.stdin.isatty()
        if asked:
            print("Send it? yes or no: ", end="", flush=True)
        if not asked or sys.stdin.readline().strip() not in ("yes", "y"):
            note("nothing was sent: answer yes, or give --yes")
            return ANSWERED
    _apply(controller, script_port or live.SCRIPT_PORT, load, text)
    if not quiet():
        print("The controller shows this payload now.")
    return ANSWERED


def _apply(controller: HostOptions, port: int, load: ControllerLoad, text: str) -> None:
    """Send the program and see that the controller holds what was sent."""
    with controller.client() as client:
        client.start(_FIELDS, 25.0)
        if live.MASS not in (client.layout.names or ()):
            raise InputError(f"{client.host}: the controller does not tell its payload: nothing was sent")
        with live.send_program(text, controller.host or "", port):
            wrong, begin = "nothing", time.monotonic()
            while time.monotonic() - begin < _PATIENCE:
                if len(shown := client.take()) and not (wrong := _differing(shown, load)):
                    return
    raise InputError(
        f"{client.host}: the payload was sent, but the controller shows {wrong}: is it in remote control?"
    )


def _differing(shown: live.Samples, load: ControllerLoad) -> str:
    """Name the numbers of the last sample that are not those that were sent; empty where there are none."""
    inertia = [float(load.inertia[at]) for at in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    sent = {live.MASS: [load.mass], live.CENTRE: load.com.tolist(), live.INERTIA: inertia}
    wrong = []
    for field, values in sent.items():
        if field not in (shown.dtype.names or ()):
            continue
        last, size = shown[field][-1].reshape(-1).tolist(), max(map(abs, values)) or 1.0
        if not all(
            math.isclose(a, b, rel_tol=_CLOSE, abs_tol=_CLOSE * size) for a, b in zip(last, values, strict=True)
        ):
            there, target = (", ".join(f"{x:.5g}" for x in numbers) for numbers in (last, values))
            wrong.append(f"{field} {there} instead of {target}")
    return "; ".join(wrong)
