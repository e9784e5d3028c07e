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
from ...estimation.results.payload import PayloadResult, Quantity, array
from ...estimation.results.robot import GainsResult, RobotResult
from ...trajectories import Design
from ..export.controllers import FORMATS
from ..export.load import load_of
from ..logs.log_check import LogCheck
from ..numbers import SIX
from .blocks import Page, Screen, Table
from .documents import JudgedMotion, Look, check_document, design_document
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


def _itself(result: Any) -> Any:
    """A result is its own document."""
    return result


def _payload_page(result: PayloadResult) -> Page:
    made = result.working
    source = made.problem.source
    recordings = (*(source.unloaded if source else ()), *(source.loaded if source else ()), *made.held_out)
    predictions = () if result.short else made.predictions
    others = (len(source.loaded) if source else 0) + len(made.held_out) - len(predictions)
    return payload_page(result, _provenance(recordings), predictions, max(others, 0))


def _payload_rows(result: PayloadResult) -> list[dict[str, Any]]:
    places: dict[str, tuple[str, Quantity, tuple[int, ...]]] = {"mass": ("kg", result.mass, ())}
    places |= {f"com {axis}": ("m", result.com, (k,)) for k, axis in enumerate("xyz")}
    places |= {f"inertia {'xyz'[i]}{'xyz'[j]}": ("kg m^2", result.inertia, (i, j)) for i, j in SIX}
    return [
        {
            "quantity": name,
            "value": float(told.value[at]),
            "low": float(told.low[at]),
            "high": float(told.high[at]),
            "unit": unit,
            "use": told.use,
        }
        for name, (unit, told, at) in places.items()
    ]


def _robot_page(result: RobotResult) -> Page:
    made = result.working
    others = len(made.held_out or made.recordings) - len(made.predictions)
    return robot_page(result, _provenance((*made.recordings, *made.held_out)), others)


def _robot_rows(result: RobotResult) -> list[dict[str, Any]]:
    return [
        {
            "parameter": parameter.name,
            "value": parameter.value,
            "sigma": float(sigma),
            "essential": parameter.essential,
            "grouping": parameter.grouping,
        }
        for parameter, sigma in zip(result.base_parameters, result.estimate.total_sigma, strict=True)
    ]


def _judged(answer: Design) -> JudgedMotion:
    title = f"Motion of {answer.problem.robot.title or answer.problem.robot.name}"
    return JudgedMotion(title, answer.score, answer.motion(_RATE), design=answer)


def _gains_page(result: GainsResult) -> Page:
    source = result.working.source
    return gains_page(result, _provenance((*source.unloaded, *source.loaded) if source else ()))


def _gains_rows(result: GainsResult) -> list[dict[str, Any]]:
    told = result.drive_gains
    columns = zip(told.values, array(told.sigma, 0), told.identified or (), told.rests_on or (), strict=True)
    return [
        {"motor": motor, "gain": float(gain), "sigma": float(sigma), "identified": good, "rests on": words}
        for motor, (gain, sigma, good, words) in enumerate(columns, 1)
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
    PayloadResult: _Shown(payload_screen, _itself, _payload_page, _payload_rows),
    RobotResult: _Shown(robot_screen, _itself, _robot_page, _robot_rows),
    GainsResult: _Shown(gains_screen, _itself, _gains_page, _gains_rows),
    Design: _Shown(
        lambda answer: design_screen(_judged(answer)),
        lambda answer: design_document(_judged(answer)),
        lambda answer: design_page(_judged(answer), _provenance(())),
        lambda answer: [{"parameter": name, "sigma": sigma} for name, sigma in answer.learnt.sigma.items()],
    ),
    LogCheck: _Shown(
        check_screen,
        lambda check: check_document(check.robot, [Look(check.recording.source, check)]),
        lambda check: check_page([Look(check.recording.source, check)], _provenance((check.recording,))),
        _log_rows,
    ),
}


def _shown(answer: object) -> tuple[Any, _Shown]:
    """What is shown of an answer, its result, and how."""
    result = getattr(answer, "result", answer)
    return result, _SHOWN[type(result)]


def summary(answer: object, details: bool) -> str:
    """The screen as text."""
    result, shown = _shown(answer)
    return screen_text(shown.screen(result), details)


def first_block(answer: object) -> str:
    """The first table of the screen and the lines above it, as HTML."""
    result, shown = _shown(answer)
    first = shown.screen(result).first
    place = next((k for k, block in enumerate(first) if isinstance(block, Table)), len(first))
    return blocks_html(first[: place + 1])


def plain(answer: object) -> dict[str, Any]:
    """The document as plain values."""
    result, shown = _shown(answer)
    document: dict[str, Any] = json.loads(json_text(shown.document(result)))
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
    result, shown = _shown(answer)
    rows = shown.rows(result)
    return pandas.DataFrame(rows).set_index(next(iter(rows[0]))) if rows else pandas.DataFrame()


def _page(answer: object) -> Page:
    """The page.

    Raises:
        InputError: of a result that was read from a file, without what a page draws.
    """
    result, shown = _shown(answer)
    if getattr(result, "working", result) is None:
        raise InputError("a result that was read from a file has no recordings to draw: identify again")
    return shown.page(result)


def write_report(answer: object, path: str | Path) -> None:
    """Write the page."""
    write_text(path, page_html(_page(answer)))


def figure(answer: object, name: str | None) -> Figure:
    """A figure of the page.

    Raises:
        InputError: if there is no such figure.
    """
    drawings = {drawing.name: drawing for drawing in _page(answer).drawings()}
    if name is None and drawings:
        return next(iter(drawings.values())).figure
    if name not in drawings:
        raise InputError(f"there is no figure {name!r}: there are {', '.join(drawings) or 'none'}")
    return drawings[name].figure


def export(result: PayloadResult, to: str, despite_verdict: bool) -> str:
    """The payload in a controller's or a simulator's format, at the flange.

    Raises:
        InputError: for a format that there is not, or a payload that must not be used or stands elsewhere.
    """
    if to not in FORMATS:
        raise InputError(f"there is no format {to!r}: there are {', '.join(FORMATS)}")
    load = load_of(result, "answer", None, despite_verdict)
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
