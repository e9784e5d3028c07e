"""What results say of themselves: the screen, the document, the page and the frame of each kind of answer."""

from __future__ import annotations

import json
import sys
from functools import singledispatch
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...common.errors import InputError
from ...common.files import checksum, write_text
from ...common.schema import json_text
from ...common.versions import versions
from ...estimation import Identification, PayloadAnswer
from ...estimation.answers.gains import DriveGains
from ...trajectories import Design
from ..export.controllers import FORMATS, load_of_document
from ..logs.log_check import LogCheck
from .blocks import Page, Screen, Table
from .documents import (
    Look,
    check_document,
    design_document,
    gains_document,
    identification_document,
    payload_document,
)
from .provenance import Provenance, SourceFile, now
from .render.html import blocks_html, page_html
from .render.terminal import screen_text
from .sections.design import design_page, design_screen
from .sections.gains import gains_page, gains_screen
from .sections.log_check import check_page, check_screen
from .sections.payload import payload_page
from .sections.payload_screen import payload_screen
from .sections.robot import robot_page, robot_screen
from .sections.weighing import weigh_page

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_RATE = 100.0  # Hz, of a motion in figures


@singledispatch
def screen_of(answer: object) -> Screen:
    """What the command prints of an answer."""
    raise TypeError(f"{type(answer).__name__} has no screen")


@singledispatch
def document_of(answer: object) -> Any:
    """What the command's ``--json`` writes."""
    raise TypeError(f"{type(answer).__name__} has no document")


@singledispatch
def page_of(answer: object) -> Page:
    """The report of an answer."""
    raise TypeError(f"{type(answer).__name__} has no report")


@singledispatch
def rows_of(answer: object) -> list[dict[str, Any]]:
    """Rows of an answer's data frame, numbers as numbers."""
    raise TypeError(f"{type(answer).__name__} has no data frame")


@screen_of.register
def _(answer: PayloadAnswer) -> Screen:
    return payload_screen(answer)


@screen_of.register
def _(answer: Identification) -> Screen:
    return robot_screen(answer, None)


@screen_of.register
def _(answer: Design) -> Screen:
    title = f"Motion of {answer.problem.robot.title or answer.problem.robot.name}"
    return design_screen(answer.problem, answer.score, title, {}, {})


@screen_of.register
def _(answer: DriveGains) -> Screen:
    return gains_screen(answer)


@screen_of.register
def _(answer: LogCheck) -> Screen:
    return check_screen(answer)


@document_of.register
def _(answer: PayloadAnswer) -> Any:
    return payload_document(answer, answer.processing or answer.problem.robot.processing)


@document_of.register
def _(answer: Identification) -> Any:
    return identification_document(answer, answer.processing or answer.robot.processing, None)


@document_of.register
def _(answer: Design) -> Any:
    return design_document(answer.problem, answer.score, {}, design=answer)


@document_of.register
def _(answer: DriveGains) -> Any:
    return gains_document(answer, answer.source.processing if answer.source else answer.robot.processing)


@document_of.register
def _(answer: LogCheck) -> Any:
    return check_document(answer.robot, [Look(answer.recording.source, answer)])


@page_of.register
def _(answer: PayloadAnswer) -> Page:
    source = answer.problem.source
    recordings = (*(source.unloaded if source else ()), *(source.loaded if source else ()), *answer.held_out)
    provenance, document = _provenance(recordings), document_of(answer)
    if answer.problem.short is not None:
        return weigh_page(answer, document, provenance)
    others = (len(source.loaded) if source else 0) + len(answer.held_out) - len(answer.predictions)
    return payload_page(answer, document, answer.predictions, answer.excitation, provenance, others=max(others, 0))


@page_of.register
def _(answer: Identification) -> Page:
    provenance = _provenance((*answer.recordings, *answer.held_out))
    others = len(answer.held_out or answer.recordings) - len(answer.predictions)
    return robot_page(answer, None, answer.predictions, answer.excitation, provenance, others=others)


@page_of.register
def _(answer: Design) -> Page:
    problem, screen = answer.problem, screen_of(answer)
    return design_page(problem, answer.score, answer.motion(_RATE), answer, screen.blocks, {}, {}, _provenance(()))


@page_of.register
def _(answer: DriveGains) -> Page:
    source = answer.source
    return gains_page(answer, _provenance((*source.unloaded, *source.loaded) if source else ()))


@page_of.register
def _(answer: LogCheck) -> Page:
    return check_page([Look(answer.recording.source, answer)], _provenance((answer.recording,)))


@rows_of.register
def _(answer: PayloadAnswer) -> list[dict[str, Any]]:
    payload = answer.payload
    entries = [("mass", payload.mass)]
    entries += [(f"com {axis}", entry) for axis, entry in payload.com._asdict().items()]
    entries += [
        (f"inertia {at}", entry) for at, entry in zip(payload.inertia._fields, payload.inertia, strict=True)
    ]
    return [{"quantity": name, **entry._asdict()} for name, entry in entries]


@rows_of.register
def _(answer: Identification) -> list[dict[str, Any]]:
    estimate = answer.estimate
    return [
        {
            "parameter": name,
            "value": float(value),
            "sigma": float(sigma),
            "essential": column in answer.essential,
            "grouping": grouping,
        }
        for name, column, value, sigma, grouping in zip(
            answer.base.names,
            answer.base.columns,
            estimate.values,
            estimate.total_sigma,
            answer.base.groupings(),
            strict=True,
        )
    ]


@rows_of.register
def _(answer: Design) -> list[dict[str, Any]]:
    return [{"parameter": name, "sigma": sigma} for name, sigma in answer.learnt.sigma.items()]


@rows_of.register
def _(answer: DriveGains) -> list[dict[str, Any]]:
    columns = zip(answer.values, answer.larger_relative_sigma, answer.identified, answer.rests_on, strict=True)
    return [
        {"motor": motor, "gain": float(gain), "sigma": float(gain * share), "identified": good, "rests on": words}
        for motor, (gain, share, good, words) in enumerate(columns, 1)
    ]


@rows_of.register
def _(answer: LogCheck) -> list[dict[str, Any]]:
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


def summary(answer: object, details: bool) -> str:
    """The screen as text."""
    return screen_text(screen_of(answer), details)


def first_block(answer: object) -> str:
    """What stands above the first table of the screen, and that table, as HTML."""
    first = screen_of(answer).first
    place = next((k for k, block in enumerate(first) if isinstance(block, Table)), len(first))
    return blocks_html(first[: place + 1])


def plain(answer: object) -> dict[str, Any]:
    """The document as plain values."""
    document: dict[str, Any] = json.loads(json_text(document_of(answer)))
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
    rows = rows_of(answer)
    return pandas.DataFrame(rows).set_index(next(iter(rows[0]))) if rows else pandas.DataFrame()


def write_report(answer: object, path: str | Path) -> None:
    """Write the page."""
    write_text(path, page_html(page_of(answer)))


def figure(answer: object, name: str | None) -> Figure:
    """A figure of the page.

    Raises:
        InputError: if there is no such figure.
    """
    drawings = {drawing.name: drawing for drawing in page_of(answer).drawings()}
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
    load = load_of_document(document_of(answer), "answer", None, despite_verdict)
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
