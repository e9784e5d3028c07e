"""Shows results of every kind: their screen, document, page, figures and data frame."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from itertools import islice
from pathlib import Path
from typing import Any

from ...common import InputError, one_thread
from ...common.files import checksum
from ...common.schema import json_text
from ...estimation.results.payload import PayloadResult
from ...estimation.results.robot import GainsResult, RobotResult
from ...model import Recording
from ...trajectories import Design
from ..export.controllers import FORMATS
from ..export.load import load_of
from ..logs.log_check import LogReport
from ..numbers import SIX
from . import page
from .blocks import Report
from .documents import JudgedMotion, check_document, design_document
from .figures.canvas import Figure
from .sections.check import check_report, log_report
from .sections.motion import design_report
from .sections.payload import payload_report
from .sections.robot import gains_report, robot_report
from .terminal import printed, screen_text


def _payload_rows(result: PayloadResult) -> list[dict[str, Any]]:
    parts: list[tuple[str, str, Any, Any]] = [("mass", "kg", result.mass, ())]
    parts += [(f"com {axis}", "m", result.com, k) for k, axis in enumerate("xyz")]
    parts += [(f"inertia {'xyz'[i]}{'xyz'[j]}", "kg m^2", result.inertia, (i, j)) for i, j in SIX]
    rows = []
    for name, unit, of, at in parts:
        numbers = {key: float(getattr(of, key)[at]) for key in ("value", "low", "high")}
        rows.append({"quantity": name, **numbers, "unit": unit, "use": of.use})
    return rows


def _gains_rows(result: GainsResult) -> list[dict[str, Any]]:
    table, keys = plain(result)["drive_gains"], ("values", "sigma", "identified", "rests_on")
    columns = {"motor": range(1, len(table["values"]) + 1), **{key: table[key] for key in keys if table.get(key)}}
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


_SHOWN: dict[type, tuple[Callable[[Any], Report], Callable[[Any], list[dict[str, Any]]]]] = {
    PayloadResult: (payload_report, _payload_rows),
    RobotResult: (robot_report, lambda result: plain(result)["base_parameters"]),
    GainsResult: (gains_report, _gains_rows),
    JudgedMotion: (
        design_report,
        lambda judged: [{"parameter": name, "sigma": sigma} for name, sigma in judged.learnt.sigma.items()],
    ),
    LogReport: (
        log_report,
        lambda check: [{"joint": j, **facts} for j, facts in enumerate(plain(check)["logs"][0]["joints"], 1)],
    ),
}
"""Report of each kind of result, and the rows of its data frame, named like the document's keys."""


def _result(answer: object) -> Any:
    return JudgedMotion.of(answer) if isinstance(answer, Design) else getattr(answer, "result", answer)


def _report(answer: object) -> Report:
    result = _result(answer)
    return _SHOWN[type(result)][0](result)


@one_thread()
def summary(answer: object, details: bool) -> str:
    """The screen as text."""
    return screen_text(_report(answer), details)


@one_thread()
def first_block(answer: object) -> str:
    """The first screen as HTML, with the first figure where there are recordings to draw."""
    report, result = _report(answer), _result(answer)
    drawings = [] if getattr(result, "working", result) is None else islice(report.drawings(), 1)
    return f'<div style="max-width: 60em">{page.blocks_html([*printed(report.first), *drawings])}</div>'


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
    """The rows as a data frame."""
    try:
        import pandas
    except ModuleNotFoundError:
        raise ImportError("to_frame() needs pandas: pip install pandas; to_dict() does without") from None
    result = _result(answer)
    rows = _SHOWN[type(result)][1](result)
    return pandas.DataFrame(rows).set_index(next(iter(rows[0]))) if rows else pandas.DataFrame()


def _drawn(answer: object) -> Report:
    """The report with its figures, which a result that was read from a file cannot have."""
    result = _result(answer)
    if getattr(result, "working", result) is None:
        raise InputError("a result that was read from a file has no recordings to draw: identify again")
    if isinstance(result, LogReport):
        return check_report([(result, None)])
    return _report(result)


@one_thread()
def write_report(answer: object, path: str | Path) -> None:
    """Write the page, made by the program that runs from the recordings' files."""
    report, result = _drawn(answer), _result(answer)
    recordings: list[Recording] = []
    working: Any = getattr(result, "working", None)
    if isinstance(result, RobotResult):
        recordings = [*working.recordings, *working.held_out]
    elif isinstance(result, PayloadResult | GainsResult):
        source = getattr(working, "problem", working).source
        recordings = [*source.unloaded, *source.loaded] if source else []
        recordings += getattr(working, "held_out", ())
    elif isinstance(result, LogReport):
        recordings = [working[1]]
    paths = dict.fromkeys(recording.source for recording in recordings)
    files = [("recording", name, checksum(name)) for name in paths if Path(name).is_file()]
    page.write_report(path, report, page.Provenance(f"python {sys.argv[0] or '(interactive)'}", files))


@one_thread()
def figure(answer: object, name: str | None) -> Figure:
    """A figure of the page."""
    drawings = {drawing.name: drawing for drawing in _drawn(answer).drawings()}
    name = next(iter(drawings), None) if name is None else name
    if name not in drawings:
        raise InputError(f"there is no figure {name!r}: there are {', '.join(drawings) or 'none'}")
    return drawings[name].figure


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
