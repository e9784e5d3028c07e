"""``dynident export``, ``apply`` and ``record``: a payload into a file or a controller, a recording from it."""

from __future__ import annotations

import math
import signal
import sys
import time
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from ...common.errors import InputError, printable
from ...common.files import write_text
from .. import live
from ..export import controllers
from ..export.load import ControllerLoad, read_load
from ..extras import extra
from ..numbers import placed, six
from . import values
from .entry import CONTROLLER, SETTING, Options, about, command
from .progress import note, quiet, status, withheld
from .values import FrameWords, NewFile, PayloadResultFile, number, word

if TYPE_CHECKING:
    Name = str
else:  # the files' names: --help need not load them
    Name = Literal[tuple(controllers.FORMATS)]

_MOVING = 0.03
"""rad/s: a joint that is faster moves."""
_PATIENCE = 2.0
"""s: by then the controller shows the payload that it was given."""
_CLOSE = 2e-6
"""Share by which numbers that are read back may differ: some controllers hold them in single precision."""
_FIELDS = (live.TIME, live.MASS, live.CENTRE, live.INERTIA)
_Rate = Annotated[float, values.word(values.positive_number, "HZ")]
_Host = Annotated[str, Parameter(metavar="H", group=CONTROLLER)]
_Port = Annotated[values.Port, Parameter(group=CONTROLLER)]


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


@command
def run_record(
    maker: Literal["ur"],
    *,
    seconds: values.Seconds = 30.0,
    rate: _Rate | None = None,
    out: Annotated[str, values.Named("file", endings=live.SUFFIXES), Parameter(metavar="F")],
    host: _Host,
    port: _Port = live.PORT,
) -> None:
    """Run ``record``: whatever ends the recording, the file holds what was there.

    Args:
        maker: Whose controller: ur, a Universal Robots one.
        seconds: How long, in the controller's time [s] (default: 30).
        rate: Samples a second (default: as fast as the controller can).
        out: File to write: .csv, .csv.gz, .parquet.
        host: Name or address of the controller.
        port: Its port of RTDE (default: 30004).
    """
    if out.lower().endswith(".parquet"):  # before anything is recorded that cannot be written
        extra("pyarrow", f"{out}: Parquet needs pyarrow: install dynident[logs], or write .csv")
    fault = ""
    with live.Client(host, port) as client:
        client.start(live.FIELDS, rate)
        absent = [field for field in live.FIELDS if field not in (client.layout.names or ())]
        if absent:
            note(f"{client.host}: the controller has no {', '.join(absent)}")
        recorder = live.Recorder(client.rate, seconds)
        before = signal.getsignal(signal.SIGTERM)
        with suppress(ValueError):  # told to end it ends as if interrupted; only the first thread gets signals
            signal.signal(signal.SIGTERM, signal.default_int_handler)
        try:
            with status("recording") as progress:
                while not recorder.over:
                    new = recorder.add(client.take())
                    progress(_progress_line(recorder, new))
        except InputError as broken:
            fault = str(broken)
        except KeyboardInterrupt:
            note(f"stopped after {recorder.seconds:.1f} s")
        finally:
            with suppress(ValueError):
                signal.signal(signal.SIGTERM, before)
    if fault and not recorder.count:
        raise InputError(f"{fault}: nothing was recorded")
    recorder.write(out)
    total, usual = recorder.count + recorder.dropped, 1.0 / recorder.step
    lost = f"{recorder.dropped} dropped ({100.0 * recorder.dropped / total:.2g} %)"
    note(f"{out}: {recorder.count} samples in {recorder.seconds:.1f} s, {lost}")
    if recorder.repeated:
        note(f"{out}: {recorder.repeated} samples came twice and are kept once")
    if not 0.9 < usual / recorder.rate < 1.1:
        note(f"{out}: {usual:.0f} samples a second came, {recorder.rate:g} were asked for")
    for moment, stop in recorder.stops:
        note(f"{out}: {stop} after {moment:.1f} s")
    if fault:
        raise InputError(f"{fault}; {out} holds the {recorder.seconds:.1f} s before")


def _progress_line(recorder: live.Recorder, new: live.Samples) -> str:
    """Tell time, joints that move, size of the currents, and what is wrong."""
    words = [f"recording {recorder.seconds:.0f} of {recorder.length:g} s"]
    if len(new):
        fastest = abs(new[live.SPEED]).max(axis=0).tolist()
        moving = ", ".join(str(j + 1) for j, speed in enumerate(fastest) if speed > _MOVING)
        words.append(f"joint {moving} moves" if moving else "no joint moves")
        words.append(f"currents to {abs(new[live.CURRENT]).max():.1f} A")
    words.append(f"moved so far: {', '.join(map(str, recorder.moved)) or 'none'}")
    if recorder.dropped:
        words.append(f"{recorder.dropped} samples dropped")
    return "; ".join(words)


@command
def run_apply(
    payload: PayloadResultFile,
    *,
    to: Literal["ur"],
    yes: bool = False,
    despite_verdict: bool = False,
    host: _Host,
    port: _Port = live.PORT,
    script_port: Annotated[values.Port, SETTING] = live.SCRIPT_PORT,
) -> bool:
    """Run ``apply``: nothing is sent before the word is given.

    Args:
        payload: The --json of 'dynident payload' or 'weigh'.
        to: Whose controller: ur, a Universal Robots one.
        yes: Send it without asking.
        despite_verdict: Send it, inertia and all, whatever the verdict.
        host: Name or address of the controller.
        port: Its port of RTDE (default: 30004).
        script_port: Port of scripts of the controller (default: 30002).
    """
    load = read_load(payload, None, despite_verdict)
    if not despite_verdict and load.verdict == "do_not_use":
        return withheld("sent", load.against)
    if load.beyond_rating:
        raise InputError(f"{load.source}: {load.beyond_rating}: not sent")
    at_flange = load.in_flange()
    if at_flange is None:
        raise InputError(f"{payload}: the payload's frame is {load.frame!r}, not the flange: nothing was sent")
    load = at_flange.rounded()
    lines = controllers.FORMATS["ur"].text(load).splitlines()
    (line,) = [line for line in lines if line.startswith("set_target_payload(")]
    text = live.program(line)
    if not quiet():
        print(f"To {host}, beside the program that runs there:\n\n{printable(text)}")
    if not yes:
        asked = sys.stdin.isatty()
        if asked:
            print("Send it? yes or no: ", end="", flush=True)
        if not asked or sys.stdin.readline().strip() not in ("yes", "y"):
            note("nothing was sent: answer yes, or give --yes")
            return True
    with live.Client(host, port) as client:
        client.start(_FIELDS, 25.0)
        if live.MASS not in (client.layout.names or ()):
            raise InputError(f"{client.host}: the controller does not report its payload, so nothing was sent")
        with live.send_program(text, host, script_port):
            wrong, begin = "nothing", time.monotonic()
            while wrong and time.monotonic() - begin < _PATIENCE:
                if len(shown := client.take()):
                    wrong = _differing(shown, load)
    if wrong:
        raise InputError(f"{client.host}: sent, but the controller shows {wrong}: is it in remote control?")
    if not quiet():
        print("The controller shows this payload now.")
    return True


def _differing(shown: live.Samples, load: ControllerLoad) -> str:
    """Name the numbers of the last sample that are not those that were sent; empty where there are none."""
    sent = {live.MASS: [load.mass], live.CENTRE: load.com.tolist(), live.INERTIA: six(load.inertia).tolist()}
    wrong = []
    for field in sent.keys() & {*(shown.dtype.names or ())}:
        numbers, last = sent[field], shown[field][-1].reshape(-1).tolist()
        bound = _CLOSE * (max(map(abs, numbers)) or 1.0)
        if not all(math.isclose(*pair, rel_tol=_CLOSE, abs_tol=bound) for pair in zip(last, numbers, strict=True)):
            there, target = (", ".join(f"{x:.5g}" for x in row) for row in (last, numbers))
            wrong.append(f"{field} {there} instead of {target}")
    return "; ".join(sorted(wrong))
