"""``dynident record`` and ``apply``: a recording from the robot itself, and a payload into it; never a motion."""

from __future__ import annotations

import math
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Literal

from cyclopts import Parameter

from ...common.errors import InputError, printable
from .. import live
from ..export import controllers
from ..export.load import ControllerLoad, read_load
from ..extras import extra
from ..numbers import six
from . import values
from .entry import CONTROLLER, SETTING, command
from .progress import note, quiet, status, withheld

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
        with status("recording") as progress, _ended_alike():
            try:
                while not recorder.over:
                    new = recorder.add(client.take())
                    progress(_progress_line(recorder, new))
            except InputError as broken:
                fault = str(broken)
            except KeyboardInterrupt:
                note(f"stopped after {recorder.seconds:.1f} s")
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


@contextmanager
def _ended_alike() -> Iterator[None]:
    """A run that is told to end ends as one that is interrupted: its file is written."""
    if threading.current_thread() is not threading.main_thread():  # nobody sends signals here
        yield
        return
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


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
    payload: values.PayloadResultFile,
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
