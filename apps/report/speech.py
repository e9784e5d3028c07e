"""Shows results of every kind: their screen, document, page, figures and data frame."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ...common.errors import InputError
from ...common.files import checksum
from ...common.schema import json_text
from ...common.versions import versions
from ...estimation.results.payload import PayloadResult, Quantity, array
from ...estimation.results.robot import GainsResult, RobotResult
from ...model import Recording
from ...trajectories import Design
from ..export.controllers import FORMATS, load_of
from ..logs.log_check import LogCheck
from ..numbers import SIX
from . import page
from .blocks import OnPage, Report
from .documents import JudgedMotion, Look, check_document, design_document
from .provenance import Provenance, SourceFile, now
from .sections.check import check_report, log_report
from .sections.gains import gains_report
from .sections.motion import design_report
from .sections.payload import payload_report
from .sections.robot import robot_report
from .terminal import screen_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_RATE = 100.0  # Hz, of a motion in figures


class _Shown(NamedTuple):
    """Functions that show one kind of result.

    ``rows``: of its data frame, numbers as numbers; ``recordings``: that a page names as its files.
    """

    report: Callable[[Any], Report]
    document: Callable[[Any], Any]
    rows: Callable[[Any], list[dict[str, Any]]]
    recordings: Callable[[Any], Iterable[Recording]]


def _itself(result: Any) -> Any:
    """A result is its own document."""
    return result


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


def _pair_of(result: PayloadResult | GainsResult) -> Iterable[Recording]:
    made = result.working
    source = made.problem.source if isinstance(result, PayloadResult) else made.source
    held_out = made.held_out if isinstance(result, PayloadResult) else ()
    return (*source.unloaded, *source.loaded, *held_out) if source else held_out


def _check_look(check: LogCheck) -> list[Look]:
    return [Look(check.recording.source, check)]


_SHOWN: dict[type, _Shown] = {
    PayloadResult: _Shown(payload_report, _itself, _payload_rows, _pair_of),
    RobotResult: _Shown(
        robot_report,
        _itself,
        _robot_rows,
        lambda result: (*result.working.recordings, *result.working.held_out),
    ),
    GainsResult: _Shown(gains_report, _itself, _gains_rows, _pair_of),
    Design: _Shown(
        lambda answer: design_report(_judged(answer)),
        lambda answer: design_document(_judged(answer)),
        lambda answer: [{"parameter": name, "sigma": sigma} for name, sigma in answer.learnt.sigma.items()],
        lambda answer: (),
    ),
    LogCheck: _Shown(
        log_report,
        lambda check: check_document(check.robot, _check_look(check)),
        _log_rows,
        lambda check: (check.recording,),
    ),
}


def _shown(answer: object) -> tuple[Any, _Shown]:
    """What is shown of an answer, its result, and how."""
    result = getattr(answer, "result", answer)
    return result, _SHOWN[type(result)]


def summary(answer: object, details: bool) -> str:
    """The screen as text."""
    result, shown = _shown(answer)
    return screen_text(shown.report(result), details)


def first_block(answer: object) -> str:
    """The first screen as HTML."""
    result, shown = _shown(answer)
    return page.blocks_html([block for block in shown.report(result).first if not isinstance(block, OnPage)])


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


def _drawn(answer: object) -> tuple[Report, Provenance]:
    """The report with its figures, and what it was made from: the program that ran, the recordings' files.

    Raises:
        InputError: of a result that was read from a file, without what a page draws.
    """
    result, shown = _shown(answer)
    if getattr(result, "working", result) is None:
        raise InputError("a result that was read from a file has no recordings to draw: identify again")
    made = check_report(_check_look(result)) if isinstance(result, LogCheck) else shown.report(result)
    paths = dict.fromkeys(recording.source for recording in shown.recordings(result))
    files = tuple(SourceFile("recording", path, checksum(path)) for path in paths if Path(path).is_file())
    return made, Provenance(f"python {sys.argv[0] or '(interactive)'}", now(), files, versions())


def write_report(answer: object, path: str | Path) -> None:
    """Write the page."""
    page.write_report(path, *_drawn(answer))


def figure(answer: object, name: str | None) -> Figure:
    """A figure of the page.

    Raises:
        InputError: if there is no such figure.
    """
    drawings = {drawing.name: drawing for drawing in _drawn(answer)[0].drawings()}
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
