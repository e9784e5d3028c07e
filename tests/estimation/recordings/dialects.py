"""Writes one log as every recorder's columns and in every dialect of text."""

import gzip
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from dynident.apps.logs.columns import KNOWN, Known
from dynident.model import Robot

UNITS = {"time": "s", "position": "rad", "velocity": "rad/s", "torque": "Nm", "current": "A"}


class Sheet(NamedTuple):
    """Names, units and numbers of a table."""

    names: list[str]
    units: list[str]
    rows: np.ndarray


def sheet_of(known: Known, robot: Robot, signals: Mapping[str, np.ndarray]) -> Sheet:
    """The signals as a recorder calls them, with currents where it knows of no torque."""
    joints = robot.joint_names[0] if known.by_name else ()
    layout = replace(known, prefixes=("/robot/",))
    load = "torque" if "torque" in known.columns else "current"
    time = known.time[0] if known.time else "__time" if "*" in known.columns["position"][0] else "timestamp"
    names, units = [time], [known.time_unit or "s"]
    columns = [signals["t"] * (1000.0 if known.time_unit == "ms" else 1.0)]
    for kind in ("position", "velocity", load):
        names += layout.expanded(known.columns[kind][0], joints, robot.n)
        units += [UNITS[kind]] * robot.n
        columns += list(signals[kind if kind in signals else "torque"].T)
    return Sheet(names, units, np.column_stack(columns))


def _lines(sheet: Sheet, delimiter: str = ",", decimal: str = ".", quote: str = "") -> list[str]:
    header = delimiter.join(f"{quote}{name}{quote}" for name in sheet.names)
    rows = [[repr(float(value)).replace(".", decimal) for value in row] for row in sheet.rows]
    return [header, *(delimiter.join(f"{quote}{cell}{quote}" for cell in row) for row in rows)]


def _text(lines: list[str], encoding: str = "utf-8", end: str = "\n") -> bytes:
    return (end.join(lines) + end).encode(encoding)


def _with_units(sheet: Sheet) -> bytes:
    header, *rows = _lines(sheet)
    return _text([header, ",".join(sheet.units), *rows])


def _in_brackets(sheet: Sheet) -> bytes:
    return _text(
        _lines(sheet._replace(names=[f"{n} [{u}]" for n, u in zip(sheet.names, sheet.units, strict=True)]))
    )


def _with_remarks(sheet: Sheet) -> bytes:
    lines = _lines(sheet)
    return _text(["# recorded on a Monday", "#", *lines[:30], "# a pause", "", *lines[30:]])


def _cut(sheet: Sheet) -> bytes:
    lines = _lines(sheet)
    return _text(lines) + lines[-1][: len(lines[-1]) // 2].encode()


def _repeated(sheet: Sheet) -> bytes:
    lines = _lines(sheet)
    return _text([*lines[:20], lines[19], lines[19], *lines[20:]])


DIALECTS: dict[str, tuple[Callable[[Sheet], bytes], str]] = {
    "semicolons": (lambda s: _text(_lines(s, ";")), "semicolons"),
    "tabs": (lambda s: _text(_lines(s, "\t")), "tabs"),
    "blanks": (lambda s: _text(_lines(s, " ")), "blanks"),
    "bars": (lambda s: _text(_lines(s, "|")), "bars"),
    "commas and blanks": (lambda s: _text(_lines(s, ", ")), ""),
    "decimal commas": (lambda s: _text(_lines(s, ";", ",")), "decimal commas"),
    "decimal commas, tabs": (lambda s: _text(_lines(s, "\t", ",")), "decimal commas"),
    "decimal commas, quoted": (lambda s: _text(_lines(s, ";", ",", '"')), "decimal commas"),
    "quoted": (lambda s: _text(_lines(s, quote='"')), ""),
    "sep=": (lambda s: _text(["sep=,", *_lines(s)]), "commas"),
    "sep=;": (lambda s: _text(["sep=;", *_lines(s, ";")]), "semicolons"),
    "byte order mark": (lambda s: _text(_lines(s), "utf-8-sig"), "byte order mark"),
    "utf-16": (lambda s: _text(_lines(s), "utf-16"), "UTF-16"),
    "utf-16 without a mark": (lambda s: _text(_lines(s), "utf-16-le"), "UTF-16"),
    "latin-1": (lambda s: _text(["# Prüfstand", *_lines(s)], "latin-1"), "Latin-1"),
    "a row of units": (_with_units, "a row of units"),
    "units in brackets": (_in_brackets, ""),
    "remarks": (_with_remarks, "remarks"),
    "header as a remark": (lambda s: _text([f"# {' '.join(s.names)}", *_lines(s, " ")[1:]]), "remarks"),
    "windows": (lambda s: _text(_lines(s), end="\r\n"), ""),
    "old mac": (lambda s: _text(_lines(s), end="\r"), ""),
    "a last delimiter": (lambda s: _text([f"{line}," for line in _lines(s)]), ""),
    "no last line end": (lambda s: _text(_lines(s))[:-1], ""),
    "gzip": (lambda s: gzip.compress(_text(_lines(s))), ""),
    "the last row cut": (_cut, "cut off: left out"),
    "rows repeated": (_repeated, "2 rows repeat the time"),
}
"""Text of each dialect, and what the notes say of it."""
LAYOUTS = {known.title: known for known in KNOWN}
