"""Shows results of every kind: their screen, document, page, figures and data frame."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ...common.errors import InputError
from ...common.files import checksum, write_text
from ...common.schema import json_text
from ...common.versions import versions
from ...estimation import Identification, LongMotion, PayloadAnswer
from ...estimation.answers.gains import DriveGains
from ...trajectories import Design
from ..export.controllers import FORMATS, load_of_document
from ..logs.log_check import LogCheck
from ..results import StoredPayload
from .blocks import Page, Screen, Table
from .documents import (
    Look,
    check_document,
    design_document,
    gains_document,
    identification_document,
    payload_document,
)
from .html import blocks_html, page_html
from .provenance import Provenance, SourceFile, now
from .sections.check import check_page, check_screen
from .sections.gains import gains_page, gains_screen
from .sections.motion import design_page, design_screen
from .sections.payload import payload_page, payload_screen
from .sections.robot import robot_page, robot_screen
from .terminal import screen_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_RATE = 100.0  # Hz, of a motion in figures


class _Shown(NamedTuple):
    """Functions that show one kind of result.

    ``rows``: of its data frame, numbers as numbers.
    """

    screen: Callable[[Any], Screen]
    document: Callable[[Any], Any]
    page: Callable[[Any], Page]
    rows: Callable[[Any], list[dict[str, Any]]]


def _payload_document(answer: PayloadAnswer) -> StoredPayload:
    return payload_document(answer, answer.problem.source.processing)


def _payload_page(answer: PayloadAnswer) -> Page:
    source = answer.problem.source
    recordings = (*source.unloaded, *source.loaded, *answer.held_out)
    predictions = answer.predictions if isinstance(answer.problem, LongMotion) else ()
    others = len(source.loaded) + len(answer.held_out) - len(predictions)
    return payload_page(answer, _payload_document(answer), _provenance(recordings), predictions, max(others, 0))


def _payload_rows(answer: PayloadAnswer) -> list[dict[str, Any]]:
    payload = answer.payload
    entries = [("mass", payload.mass)]
    entries += [(f"com {axis}", entry) for axis, entry in payload.com._asdict().items()]
    entries += [(f"inertia {at}", entry) for at, entry in payload.inertia._asdict().items()]
    return [{"quantity": name, **entry._asdict()} for name, entry in entries]


def _robot_page(answer: Identification) -> Page:
    others = len(answer.held_out or answer.recordings) - len(answer.predictions)
    provenance = _provenance((*answer.recordings, *answer.held_out))
    return robot_page(answer, None, provenance, others)


def _robot_rows(answer: Identification) -> list[dict[str, Any]]:
    base, estimate = answer.base, answer.estimate
    return [
        {
            "parameter": name,
            "value": float(estimate.values[k]),
            "sigma": float(estimate.total_sigma[k]),
            "essential": base.columns[k] in answer.essential,
            "grouping": grouping,
        }
        for k, (name, grouping) in enumerate(zip(base.names, base.groupings(), strict=True))
    ]


def _design_screen(answer: Design) -> Screen:
    title = f"Motion of {answer.problem.robot.title or answer.problem.robot.name}"
    return design_screen(answer.problem, answer.score, title, {}, {})


def _design_page(answer: Design) -> Page:
    motion, screen = answer.motion(_RATE), _design_screen(answer).blocks
    return design_page(answer.problem, answer.score, motion, answer, screen, {}, {}, _provenance(()))


def _gains_rows(answer: DriveGains) -> list[dict[str, Any]]:
    columns = zip(answer.values, answer.larger_relative_sigma, answer.identified, answer.rests_on, strict=True)
    return [
        {"motor": motor, "gain": float(gain), "sigma": float(gain * share), "identified": good, "rests on": words}
        for motor, (gain, share, good, words) in enumerate(columns, 1)
    ]


def _log_rows(answer: LogCheck) -> list[dict[str, Any]]:
    return [
        {
            "joint": number,
            "moves": facts.moves,
            "from": facts.position[0],
            "to": facts.position[1],
            "speed": facts.speed,
            "torque from": facts.torque[0],
            "torque to": facts.torque[1],
        }
        for number, facts in enumerate(answer.joints, 1)
    ]


_SHOWN: dict[type, _Shown] = {
    PayloadAnswer: _Shown(payload_screen, _payload_document, _payload_page, _payload_rows),
    Identification: _Shown(
        lambda answer: robot_screen(answer, None),
        lambda answer: identification_document(answer, answer.processing or answer.robot.processing, None),
        _robot_page,
        _robot_rows,
    ),
    Design: _Shown(
        _design_screen,
        lambda answer: design_document(answer.problem, answer.score, {}, design=answer),
        _design_page,
        lambda answer: [{"parameter": name, "sigma": sigma} for name, sigma in answer.learnt.sigma.items()],
    ),
    DriveGains: _Shown(
        gains_screen,
        lambda gains: gains_document(gains, gains.source.processing if gains.source else gains.robot.processing),
        lambda gains: gains_page(
            gains, _provenance((*gains.source.unloaded, *gains.source.loaded) if gains.source else ())
        ),
        _gains_rows,
    ),
    LogCheck: _Shown(
        check_screen,
        lambda check: check_document(check.robot, [Look(check.recording.source, check)]),
        lambda check: check_page([Look(check.recording.source, check)], _provenance((check.recording,))),
        _log_rows,
    ),
}


def summary(answer: object, details: bool) -> str:
    """The screen as text."""
    return screen_text(_SHOWN[type(answer)].screen(answer), details)


def first_block(answer: object) -> str:
    """The first table of the screen and the lines above it, as HTML."""
    first = _SHOWN[type(answer)].screen(answer).first
    place = next((k for k, block in enumerate(first) if isinstance(block, Table)), len(first))
    return blocks_html(first[: place + 1])


def plain(answer: object) -> dict[str, Any]:
    """The document as plain values."""
    document: dict[str, Any] = json.loads(json_text(_SHOWN[type(answer)].document(answer)))
    return document


def frame(answer: object) -> Any:
    """The rows as a data frame.

    Raises:
        ImportError: without pandas.
    """
    try:
        import pandas
    except ModuleNotFoundError:
        raise ImportError("to_frame() needs pandas: pip install pandas; to_dict() does without") from None
    rows = _SHOWN[type(answer)].rows(answer)
    return pandas.DataFrame(rows).set_index(next(iter(rows[0]))) if rows else pandas.DataFrame()


def write_report(answer: object, path: str | Path) -> None:
    """Write the page."""
    write_text(path, page_html(_SHOWN[type(answer)].page(answer)))


def figure(answer: object, name: str | None) -> Figure:
    """A figure of the page.

    Raises:
        InputError: if there is no such figure.
    """
    drawings = {drawing.name: drawing for drawing in _SHOWN[type(answer)].page(answer).drawings()}
    if name is None and drawings:
        return next(iter(drawings.values())).figure
    if name not in drawings:
        raise InputError(f"there is no figure {name!r}: there are {', '.join(drawings) or 'none'}")
    return drawings[name].figure


def export(answer: PayloadAnswer, to: str, despite_verdict: bool) -> str:
    """The payload in a controller's or a simulator's format, at the flange.

    Raises:
        InputError: for a format that there is not, or a payload that must not be used or stands elsewhere.
    """
    if to not in FORMATS:
        raise InputError(f"there is no format {to!r}: there are {', '.join(FORMATS)}")
    load = load_of_document(_payload_document(answer), "answer", None, despite_verdict)
    if not despite_verdict and (load.verdict == "do_not_use" or load.beyond_rating):
        against = "; ".join(load.reasons) or load.beyond_rating
        raise InputError(f"not to be used: {against}; despite_verdict=True writes it all the same")
    at_flange = load.in_flange()
    if at_flange is None:
        raise InputError(f"the payload's frame is {load.frame!r}, not the flange: identify it there (with_tool)")
    return FORMATS[to].text(at_flange)


def _provenance(recordings: Any) -> Provenance:
    """A report from Python: the program that ran, and the files of the recordings."""
    paths = dict.fromkeys(recording.source for recording in recordings)
    files = tuple(SourceFile("recording", path, checksum(path)) for path in paths if Path(path).is_file())
    return Provenance(f"python {sys.argv[0] or '(interactive)'}", now(), files, versions())
