"""``dynident weigh --live`` and ``--replay``: the payload while the robot works, and when it is changed."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Generator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Protocol

import numpy as np

from ... import estimation, model
from ...common.errors import InputError
from .. import live, report, results
from . import ANSWERED
from .options import (
    GainOptions,
    HostOptions,
    Options,
    PageOptions,
    PairOptions,
    ResultOptions,
    RobotOptions,
    Setup,
    option,
)
from .progress import note, quiet, status
from .values import mass

if TYPE_CHECKING:
    from ...estimation.payload import Change, LiveWeighing, Told, Weighed

_CHUNK = 10
"""Samples of a log that are replayed at once."""
_SHOWS_GAINS = 5.0
"""s of motion by which the share of the drive gains is known."""
_OF_LOGS = ("log_map", "joints", "units", "signs", "topic")


@dataclass(frozen=True)
class LiveOptions(Options):
    """A stream in the place of recordings."""

    GROUP: ClassVar[str] = "while the robot works"
    ABOUT: ClassVar[str] = "needs --robot-parameters; the last 20 s of motion count"

    live: str | None = option(either="stream", choices=("ur",), help="read from the controller at --host")
    replay: str | None = option(
        either="stream", reads="replayed", metavar="LOG", help="read a log as if it came now"
    )
    until: float | None = option(type=mass, metavar="50g", help="stop when the mass is known to this, 95 %%")
    watch: str | None = option(writes="file", metavar="F.jsonl", help="append a line of JSON for each change")

    @property
    def asked(self) -> bool:
        """Whether a stream was asked for."""
        return bool(self.live or self.replay)


class _Weigh(Protocol):
    """What the command's own options say of a stream."""

    @property
    def robot_parameters(self) -> str | None: ...

    @property
    def change(self) -> float: ...


def weigh_live(
    arm: RobotOptions,
    request: _Weigh,
    drives: GainOptions,
    processing: PairOptions,
    files: PageOptions,
    stream: LiveOptions,
    controller: HostOptions,
) -> int:
    """Weigh what comes until it ends, is known well enough, or the user has enough."""
    if not request.robot_parameters:
        raise InputError("--live and --replay need --robot-parameters, the --json of 'dynident identify'")
    stored = results.read_stored_robot(request.robot_parameters)
    setup = processing.setup(arm.load(), stored)
    gains = drives.errors(setup, (), (), stored)
    if stream.live:
        for name in _OF_LOGS:
            if getattr(processing, name) not in ((), ""):
                processing.refuse(name, "is of logs: a controller tells what it sends")
        if not controller.host:
            raise InputError("give --host, the controller's name or address")
        samples = _from_controller(controller, setup)
    else:
        for name in ("host", "port"):
            controller.refuse(name, "belongs to --live")
        samples = _from_log(stream.replay or "", setup)
    window = estimation.payload.MovingWindow(
        setup.robot, stored.estimate, setup.processing, friction_change=request.change, gains=gains
    )
    weighing = estimation.payload.LiveWeighing(window)
    fault = _follow(weighing, samples, stream, note if not quiet() else lambda _: None)
    if weighing.latest is None:
        raise InputError(fault or "no joint moves: nothing can be weighed")
    _show(weighing, files, setup.robot)
    if fault:
        raise InputError(fault)
    return ANSWERED


def _follow(
    weighing: LiveWeighing,
    samples: Generator[model.Recording, None, None],
    stream: LiveOptions,
    tell: Callable[[str], None],
) -> str:
    """Weigh until it is enough; why the stream ended, if that was a fault."""
    window = weighing.window
    with status("weighing") as progress:
        try:
            for recording in samples:
                for news in weighing.feed(recording):
                    if news.change is not None:
                        tell(change_line(news))
                        if stream.watch:
                            _append(stream.watch, _line(news))
                    progress(f"{news.time:.0f} s: {state_line(news.weighed, stream.until)}")
                    if stream.until is not None:
                        if news.weighed.half_width <= stream.until:
                            return ""
                        if out_of_reach(news.weighed, stream.until):
                            return beyond_gains(news.weighed, stream.until, window.gains, window.robot.n)
        except live.LinkError as fault:
            return str(fault)
        except KeyboardInterrupt:
            tell("stopped")
        finally:
            samples.close()
    return ""


def out_of_reach(weighed: Weighed, until: float) -> bool:
    """Whether errors of the drive gains alone forbid an interval; the first seconds do not show yet how far."""
    return weighed.seconds >= _SHOWS_GAINS and weighed.by_gains > until


def beyond_gains(weighed: Weighed, until: float, gains: estimation.Gains | None, joints: int) -> str:
    """Why no motion is long enough."""
    sigma = float(np.sqrt(np.diag(gains.covariance(joints)).max())) if gains is not None else 0.0
    return (
        f"--until {1e3 * until:g}g is out of reach: gains of {100.0 * sigma:.2g} % allow "
        f"±{weighed.by_gains:.2f} kg at best for {weighed.mass:.1f} kg: ask for more, or identify them by "
        "'dynident gains'"
    )


def _append(path: str, line: str) -> None:
    """One line more, at once: whoever watches the file sees whole lines.

    Raises:
        InputError: if the file cannot be written.
    """
    try:
        with Path(path).open("a", encoding="utf-8") as file:
            file.write(f"{line}\n")
    except OSError as error:
        raise InputError(f"--watch {path}: cannot be written: {error.strerror or error}") from None


def _from_log(path: str, setup: Setup) -> Generator[model.Recording, None, None]:
    """A log, a few samples at a time."""
    for recording in setup.read([path]):
        for start in range(0, len(recording.t), _CHUNK):
            part = slice(start, start + _CHUNK)
            qd = recording.qd[part] if recording.qd is not None else None
            yield model.Recording(recording.t[part], recording.q[part], recording.torque[part], qd, path)


def _from_controller(controller: HostOptions, setup: Setup) -> Generator[model.Recording, None, None]:
    """Samples of a controller as they come.

    Raises:
        LinkError: when they end.
        InputError: if torques cannot be had.
    """
    with controller.client() as client, client.stream() as stream:
        recorder = live.Recorder(stream.recipe, stream.rate, keep=False)
        field_of_torque = live.CURRENT if setup.gains is not None else live.TORQUE
        if field_of_torque not in stream.recipe.fields:
            raise InputError(f"{client.host}: the controller sends no torques: give --drive-gains")
        factors = np.array(setup.gains if setup.gains is not None else [1.0])
        while True:
            new = recorder.add(stream.take())
            if len(new):
                t, q, qd, load = (
                    np.array(new.of(name)) for name in (live.TIME, live.POSITION, live.SPEED, field_of_torque)
                )
                yield model.Recording(t[:, 0], q, load * factors, qd, client.host)


def state_line(weighed: Weighed, until: float | None) -> str:
    """What is known now, and how long it takes to know enough."""
    if weighed.hidden:
        return weighed.hidden
    line = f"{weighed.mass:.3f} kg ± {weighed.half_width:.3f} by {weighed.seconds:.0f} s of motion"
    if until is not None and weighed.half_width > until:
        more = weighed.seconds * ((weighed.half_width / until) ** 2 - 1.0)
        state = (
            f"{math.ceil(more)} s more"
            if weighed.seconds + more <= 20.0
            else "not within 20 s: move faster, farther"
        )
        line += f"; {state} for {1e3 * until:g} g"
    return line


def _line(news: Told) -> str:
    """A change as one line of JSON."""
    assert news.change is not None
    document = report.documents.change_document(news.change, news.time)
    return json.dumps(json.loads(report.documents.json_text(document)))


def change_line(news: Told) -> str:
    """A change in words."""
    assert news.change is not None
    return f"{news.change.time:.1f} s: payload changed by {_step(news.change)}, told at {news.time:.1f} s"


def _step(change: Change) -> str:
    return f"{change.mass:+.2f} kg ({change.low:+.2f} to {change.high:+.2f})"


def _show(weighing: LiveWeighing, files: ResultOptions, robot: model.Robot) -> None:
    """The last window, on the screen and as JSON."""
    assert weighing.latest is not None
    last = weighing.latest.weighed
    lines = [f"Payload in {robot.payload_frame}, by the last {last.seconds:.0f} s of motion"]
    if last.hidden:
        lines.append(f"mass {last.hidden}")
    else:
        lines.append(f"mass {last.mass:.3f} kg, 95 % from {last.low:.3f} to {last.high:.3f}")
        centre = (
            f"{axis} {1e3 * x:.0f} ± {2e3 * s:.0f}" if math.isfinite(s) else f"{axis} not visible"
            for axis, x, s in zip("xyz", last.com.tolist(), last.com_sigma.tolist(), strict=True)
        )
        lines.append(f"centre of mass [mm]: {', '.join(centre)}")
    lines.append(f"{len(weighing.changes)} changes of payload")
    if files.details:
        lines += [
            f"  {c.time:.1f} s: {c.mass:+.2f} kg ({c.low:+.2f} to {c.high:+.2f})" for c, _ in weighing.changes
        ]
    files.show(report.Screen([report.Remarks(lines)]))
    documents = [report.documents.change_document(change, at) for change, at in weighing.changes]
    files.write_json(lambda: report.documents.live_document(robot.name, robot.payload_frame, last, documents))
