"""``dynident export``, ``apply`` and ``record``: a payload into a file or a controller, a recording from it."""

from __future__ import annotations

import math
import signal
import sys
import time
from contextlib import suppress
from dataclasses import field, replace
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from ...common.errors import InputError, printable
from ...common.files import write_text
from .. import live
from ..export import controllers
from ..export.load import ControllerLoad, read_load
from ..extras import extra
from ..numbers import ENTRIES, placed
from . import values
from .entry import CONTROLLER, SETTING, Options, about, note, status, withheld
from .values import FrameWords, NewFile, PayloadResultFile, number, positive_number, word

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


class _Controller(Options, group=CONTROLLER):
    host: Annotated[str, Parameter(metavar="H")]
    """Name or address of the controller."""
    port: values.Port = live.PORT
    """Its port of RTDE (default: 30004)."""


class _Export(Options):
    payload: PayloadResultFile = field(kw_only=False)
    """The --json of 'dynident payload'."""
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

    def __call__(self) -> bool:
        form = controllers.FORMATS[self.to]
        for option, held in (("tool_frame", "tool frame"), ("meters_per_unit", "units")):
            if held not in form.holds:  # it would be ignored
                known = [name for name, other in controllers.FORMATS.items() if held in other.holds]
                self.refuse(option, f"belongs to --to {', '.join(known)}, not to {self.to}")
        load = read_load(self.payload, self.method, self.despite_verdict)
        if load.against and not self.despite_verdict:
            return withheld("written", f"{load.against}; --despite-verdict writes it all the same")
        at_flange = load.in_flange()
        if (pose := self.flange_frame) is not None:
            with about("--flange-frame"):
                at_flange = load.seen_from(pose, f"flange, at {placed(pose)} in {load.frame}")
        if at_flange is None:
            raise InputError(
                f"{load.source}: the payload's frame is {load.frame!r}, not the flange: give --flange-frame, the "
                "flange's pose in it (0 0 0 0 0 0 if it is the same)"
            )
        load = at_flange
        if (pose := self.tool_frame) is not None:
            with about("--tool-frame"):
                load = replace(load.seen_from(pose, f"tool, at {placed(pose)} in the flange"), in_tool_frame=True)
        if self.meters_per_unit is not None:
            load = replace(load, meters_per_unit=self.meters_per_unit)
        text = form.text(load)
        if self.out:
            write_text(self.out, text)
        else:
            print(text, end="")
        return True


class _Record(_Controller):
    """A recording from a controller: whatever ends it, the file holds what was there."""

    maker: Literal["ur"] = field(kw_only=False)
    """Whose controller: ur, a Universal Robots one."""
    seconds: values.Seconds = 30.0
    """How long, in the controller's time [s] (default: 30)."""
    rate: Annotated[float | None, word(positive_number, "HZ")] = None
    """Samples a second (default: as fast as the controller can)."""
    out: Annotated[str, values.Named("file", endings=live.SUFFIXES), Parameter(metavar="F")]
    """File to write: .csv, .csv.gz, .parquet."""

    def __call__(self) -> None:
        if self.out.lower().endswith(".parquet"):  # before anything is recorded that cannot be written
            extra("pyarrow", f"{self.out}: Parquet needs pyarrow: install dynident[logs], or write .csv")
        fault = ""
        with live.Client(self.host, self.port) as client:
            client.start(live.FIELDS, self.rate)
            absent = [name for name in live.FIELDS if name not in (client.layout.names or ())]
            if absent:
                note(f"{client.host}: the controller has no {', '.join(absent)}")
            recorder = live.Recorder(client.rate, self.seconds)
            before = signal.getsignal(signal.SIGTERM)
            with suppress(ValueError):  # told to end it ends as if interrupted; only the first thread gets signals
                signal.signal(signal.SIGTERM, signal.default_int_handler)
            try:
                with status("recording") as progress:
                    while recorder.seconds < recorder.length:
                        new = recorder.add(client.take())
                        words = [f"recording {recorder.seconds:.0f} of {recorder.length:g} s"]
                        if len(new):
                            fastest = abs(new[live.SPEED]).max(axis=0).tolist()
                            moving = ", ".join(str(j + 1) for j, speed in enumerate(fastest) if speed > _MOVING)
                            words.append(f"joint {moving} moves" if moving else "no joint moves")
                            words.append(f"currents to {abs(new[live.CURRENT]).max():.1f} A")
                        words.append(f"moved so far: {', '.join(map(str, recorder.moved)) or 'none'}")
                        if recorder.dropped:
                            words.append(f"{recorder.dropped} samples dropped")
                        progress("; ".join(words))
            except InputError as broken:
                fault = str(broken)
            except KeyboardInterrupt:
                note(f"stopped after {recorder.seconds:.1f} s")
            finally:
                with suppress(ValueError):
                    signal.signal(signal.SIGTERM, before)
        if fault and not recorder.count:
            raise InputError(f"{fault}: nothing was recorded")
        recorder.write(self.out)
        total, usual = recorder.count + recorder.dropped, 1.0 / recorder.step
        lost = f"{recorder.dropped} dropped ({100.0 * recorder.dropped / total:.2g} %)"
        note(f"{self.out}: {recorder.count} samples in {recorder.seconds:.1f} s, {lost}")
        if recorder.repeated:
            note(f"{self.out}: {recorder.repeated} samples came twice and are kept once")
        if not 0.9 < usual / recorder.rate < 1.1:
            note(f"{self.out}: {usual:.0f} samples a second came, {recorder.rate:g} were asked for")
        for moment, stop in recorder.stops:
            note(f"{self.out}: {stop} after {moment:.1f} s")
        if fault:
            raise InputError(f"{fault}; {self.out} holds the {recorder.seconds:.1f} s before")


class _Apply(_Controller):
    """A payload for a controller over the network: nothing is sent before the word is given."""

    payload: PayloadResultFile = field(kw_only=False)
    """The --json of 'dynident payload' or 'weigh'."""
    to: Literal["ur"]
    """Whose controller: ur, a Universal Robots one."""
    yes: bool = False
    """Send it without asking."""
    despite_verdict: bool = False
    """Send it, inertia and all, whatever the verdict."""
    script_port: Annotated[values.Port, SETTING] = live.SCRIPT_PORT
    """Port of scripts of the controller (default: 30002)."""

    def __call__(self) -> bool:
        load = read_load(self.payload, None, self.despite_verdict)
        if not self.despite_verdict and load.verdict == "do_not_use":
            return withheld("sent", load.against)
        if load.beyond_rating:
            raise InputError(f"{load.source}: {load.beyond_rating}: not sent")
        at_flange = load.in_flange()
        if at_flange is None:
            raise InputError(
                f"{self.payload}: the payload's frame is {load.frame!r}, not the flange: nothing was sent"
            )
        load = at_flange.rounded()
        lines = controllers.FORMATS["ur"].text(load).splitlines()
        (line,) = [line for line in lines if line.startswith("set_target_payload(")]
        text = live.program(line)
        if not self.quiet:
            print(f"To {self.host}, beside the program that runs there:\n\n{printable(text)}")
        if not self.yes:
            asked = sys.stdin.isatty()
            if asked:
                print("Send it? yes or no: ", end="", flush=True)
            if not asked or sys.stdin.readline().strip() not in ("yes", "y"):
                note("nothing was sent: answer yes, or give --yes")
                return True
        with live.Client(self.host, self.port) as client:
            client.start(_FIELDS, 25.0)
            if live.MASS not in (client.layout.names or ()):
                raise InputError(f"{client.host}: the controller does not report its payload, so nothing was sent")
            with live.send_program(text, self.host, self.script_port):
                wrong, begin = "nothing", time.monotonic()
                while wrong and time.monotonic() - begin < _PATIENCE:
                    if len(shown := client.take()):
                        wrong = _differing(shown, load)
        if wrong:
            raise InputError(f"{client.host}: sent, but the controller shows {wrong}: is it in remote control?")
        if not self.quiet:
            print("The controller shows this payload now.")
        return True


def _differing(shown: live.Samples, load: ControllerLoad) -> str:
    """Name the numbers of the last sample that are not those that were sent; empty where there are none."""
    sent = {live.MASS: [load.mass], live.CENTRE: load.com.tolist(), live.INERTIA: load.inertia[ENTRIES].tolist()}
    wrong = []
    for name in sent.keys() & {*(shown.dtype.names or ())}:
        numbers, last = sent[name], shown[name][-1].reshape(-1).tolist()
        bound = _CLOSE * (max(map(abs, numbers)) or 1.0)
        if not all(math.isclose(*pair, rel_tol=_CLOSE, abs_tol=bound) for pair in zip(last, numbers, strict=True)):
            there, target = (", ".join(f"{x:.5g}" for x in row) for row in (last, numbers))
            wrong.append(f"{name} {there} instead of {target}")
    return "; ".join(sorted(wrong))
