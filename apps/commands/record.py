"""``dynident record``: a recording from the robot itself, over the network."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Literal

from ...common.errors import InputError
from .. import live
from . import ANSWERED
from .entry import command
from .options import HostOptions
from .progress import note, status
from .values import NewFile, Seconds, positive_number, word

_SECONDS = 30.0
_MOVING = 0.03
"""rad/s: a joint that is faster moves."""


@command
def run(
    maker: Literal["ur"],
    *,
    seconds: Seconds | None = None,
    rate: Annotated[float | None, word(positive_number, "HZ")] = None,
    out: NewFile,
    controller: HostOptions,
) -> int:
    """Run it: whatever ends the recording, the file holds what was there.

    Args:
        maker: Whose controller: ur, a Universal Robots one.
        seconds: How long, in the controller's time [s] (default: 30).
        rate: Samples a second (default: as fast as the controller can).
        out: File to write: .csv, .csv.gz, .parquet.
    """
    if not controller.host:
        raise InputError("give --host, the controller's name or address")
    live.check_name(out)
    with controller.client() as client:
        client.start(live.FIELDS, rate)
        absent = [field for field in live.FIELDS if field not in (client.layout.names or ())]
        if absent:
            note(f"{client.host}: the controller has no {', '.join(absent)}")
        recorder = live.Recorder(client.rate, seconds or _SECONDS)
        fault = _recorded(client, recorder)
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
    for time, stop in recorder.stops:
        note(f"{out}: {stop} after {time:.1f} s")
    if fault:
        raise InputError(f"{fault}; {out} holds the {recorder.seconds:.1f} s before")
    return ANSWERED


def _recorded(client: live.Client, recorder: live.Recorder) -> str:
    """Record until the time is over, the user has enough, or it cannot go on: then why."""
    with status("recording") as progress, _ended_alike():
        try:
            while not recorder.over:
                new = recorder.add(client.take())
                progress(progress_line(recorder, new))
        except live.LinkError as fault:
            return str(fault)
        except KeyboardInterrupt:
            note(f"stopped after {recorder.seconds:.1f} s")
    return ""


@contextmanager
def _ended_alike() -> Iterator[None]:
    """A run that is told to end ends as one that is interrupted: its file is written."""
    before = signal.getsignal(signal.SIGTERM)
    try:
        signal.signal(signal.SIGTERM, signal.default_int_handler)
    except ValueError:  # not the main thread: nobody sends signals here
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def progress_line(recorder: live.Recorder, new: live.Samples) -> str:
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
