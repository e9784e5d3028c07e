"""Shows results of every kind: their screen, document, page, figures and data frame."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from itertools import islice
from pathlib import Path
from typing import Any

from ...common import InputError, one_thread
from ...common.files import checksum, write_text
from ...common.schema import json_text
from ...estimation.results.payload import PayloadResult
from ...estimation.results.robot import GainsResult, RobotResult
from ...model import Recording
from ...trajectories import Design
from ..export.controllers import FORMATS
from ..export.load import load_of
from ..logs.log_check import LogReport
from ..numbers import SIX
from .blocks import Report, blocks_html, leaves, page_html, screen_lines
from .documents import JudgedMotion, check_document, design_document
from .figures import Figure
from .sections.motion import design_report
from .sections.payload import payload_report
from .sections.recordings import check_report, log_report
from .sections.robot import gains_report, robot_report

_REPORTS: dict[type, Callable[[Any], Report]] = {
    PayloadResult: payload_report,
    RobotResult: robot_report,
    GainsResult: gains_report,
    JudgedMotion: design_report,
    LogReport: log_report,
}


def _result(answer: object) -> Any:
    return JudgedMotion.of(answer) if isinstance(answer, Design) else getattr(answer, "result", answer)


def _report(answer: object, drawn: bool = False) -> Report:
    """Make the report; ``drawn``: with its figures, which a result that was read from a file cannot have."""
    result = _result(answer)
    if drawn and getattr(result, "working", result) is None:
        raise InputError("a result that was read from a file has no recordings to draw: identify again")
    if drawn and isinstance(result, LogReport):
        return check_report([(result, None)])
    return _REPORTS[type(result)](result)


@one_thread()
def summary(answer: object, details: bool) -> str:
    """The screen as text."""
    return "\n".join(screen_lines(_report(answer), details)).rstrip("\n")


@one_thread()
def first_block(answer: object) -> str:
    """The first screen as HTML, with the first figure where there are recordings to draw."""
    report, result = _report(answer), _result(answer)
    drawings = [] if getattr(result, "working", result) is None else islice(report.drawings(), 1)
    return f'<div style="max-width: 60em">{blocks_html([*leaves(report.first), *drawings])}</div>'


def plain(answer: object) -> dict[str, Any]:
    """The document as plain values."""
    document = result = _result(answer)
    if isinstance(result, JudgedMotion):
        document = design_document(result)
    elif isinstance(result, LogReport):
        document = check_document(result.working[0], [(result, None)])
    values: dict[str, Any] = json.loads(json_text(document))
    return values


@one_thread()
def frame(answer: object) -> Any:
    """The first screen's table as a data frame, its columns named like the document's keys."""
    try:
        import pandas
    except ModuleNotFoundError:
        raise ImportError("to_frame() needs pandas: pip install pandas; to_dict() does without") from None
    rows: list[dict[str, Any]] = []
    match result := _result(answer):
        case PayloadResult():
            parts: list[tuple[str, str, Any, Any]] = [("mass", "kg", result.mass, ())]
            parts += [(f"com {axis}", "m", result.com, k) for k, axis in enumerate("xyz")]
            parts += [(f"inertia {'xyz'[i]}{'xyz'[j]}", "kg m^2", result.inertia, (i, j)) for i, j in SIX]
            for name, unit, of, at in parts:
                numbers = {key: float(getattr(of, key)[at]) for key in ("value", "low", "high")}
                rows.append({"quantity": name, **numbers, "unit": unit, "use": of.use})
        case RobotResult():
            rows = plain(result)["base_parameters"]
        case GainsResult():
            table, keys = plain(result)["drive_gains"], ("values", "sigma", "identified", "rests_on")
            columns = {key: table[key] for key in keys if table.get(key)}
            for motor, row in enumerate(zip(*columns.values(), strict=True), 1):
                rows.append({"motor": motor, **dict(zip(columns, row, strict=True))})
        case JudgedMotion():
            rows = [{"parameter": name, "sigma": sigma} for name, sigma in result.learnt.sigma.items()]
        case LogReport():
            rows = [{"joint": j, **facts} for j, facts in enumerate(plain(result)["logs"][0]["joints"], 1)]
    return pandas.DataFrame(rows).set_index(next(iter(rows[0]))) if rows else pandas.DataFrame()


@one_thread()
def write_report(answer: object, path: str | Path) -> None:
    """Write the page, made by the program that runs from the recordings' files."""
    report, result = _report(answer, drawn=True), _result(answer)
    working: Any = getattr(result, "working", None)
    source = getattr(working, "source", None) or getattr(getattr(working, "problem", None), "source", None)
    recordings: list[Recording] = [working[1]] if isinstance(result, LogReport) else []
    for of, kind in ((source, "unloaded"), (source, "loaded"), (working, "recordings"), (working, "held_out")):
        recordings += getattr(of, kind, ())
    paths = dict.fromkeys(recording.source for recording in recordings)
    files = [("recording", name, checksum(name)) for name in paths if Path(name).is_file()]
    write_text(path, page_html(report, f"python {sys.argv[0] or '(interactive)'}", files))


@one_thread()
def figure(answer: object, name: str | None) -> Figure:
    """A figure of the page."""
    names = list[str]()
    for drawing in _report(answer, drawn=True).drawings():  # which draws no further than asked for
        if name in (None, drawing.name):
            return drawing.figure
        names.append(drawing.name)
    raise InputError(f"there is no figure {name!r}: there are {', '.join(names) or 'none'}")


def export(result: PayloadResult, to: str, despite_verdict: bool) -> str:
    """The payload at the flange in a controller's or a simulator's format, unless it must not be used."""
    if to not in FORMATS:
        raise InputError(f"there is no format {to!r}: there are {', '.join(FORMATS)}")
    load = load_of(result, "answer", None, despite_verdict)
    if load.against and not despite_verdict:
        raise InputError(f"not to be used: {load.against}; despite_verdict=True writes it all the same")
    at_flange = load.in_flange()
    if at_flange is None:
        raise InputError(f"the payload's frame is {load.frame!r}, not the flange: identify it there (with_tool)")
    return FORMATS[to].text(at_flange)
