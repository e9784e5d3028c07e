"""Reads a log map from TOML."""

import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...common.errors import InputError
from .layout import Layout, spread
from .mapping import QUANTITIES, REFERENCES, FilePart, LogMap, Quantity
from .pose_columns import ToolColumns
from .units import factor, is_share

_LAYOUT = ("delimiter", "decimal", "names", "skip_lines", "numbers_per_row", "topic")
_QUANTITY = ("columns", "unit", "side", "sign", "zero_deg", "zero_m", "rated")
_KEYS = {
    "": ("title", "joints", "file", "files", "time", "motor", "pose", *QUANTITIES, *REFERENCES),
    "file": _LAYOUT,
    "files": ("name", *_LAYOUT),
    "time": ("column", "unit", "rate_hz"),
    "motor": ("gear_ratios", "coupling"),
    "coupling": ("motor", "joint", "ratio"),
    "pose": ("columns", "unit", "rotation", "form", "rotation_unit"),
}
_KEYS |= dict.fromkeys(QUANTITIES, _QUANTITY) | dict.fromkeys(REFERENCES, ("columns", "unit"))


def read_log_map(path: str | Path) -> LogMap:
    """Read a log map; docs/logs.md tells its keys.

    Raises:
        InputError: names the file and the key.
    """
    try:
        data = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"{path}: not valid TOML: {error}") from None
    try:
        return _log_map(str(path), data)
    except ValueError as error:
        text = str(error)
        raise InputError(text if text.startswith(str(path)) else f"{path}: {text}") from None


def _log_map(source: str, data: Mapping[str, Any]) -> LogMap:
    _known(data, "")
    time = _table(data, "time")
    if "rate_hz" in time and len(time) > 1:
        raise ValueError("key 'time': give rate_hz, or column and unit")
    files = data.get("files", [])
    if not isinstance(files, list):
        raise ValueError("key 'files': give [[files]] tables")
    return LogMap(
        source=source,
        layout=_layout(_table(data, "file")),
        files=tuple(FilePart(_text(part, "name"), _layout(_checked(part, "files"))) for part in files),
        time="" if "rate_hz" in time else _text(time, "column", "t"),
        time_unit=_text(time, "unit", "s"),
        rate=_number(time, "rate_hz") if "rate_hz" in time else None,
        quantities=tuple(_quantity(kind, _table(data, kind)) for kind in QUANTITIES if kind in data),
        joints=_texts(data, "joints"),
        gears=_gears(_table(data, "motor")),
        pose=_pose(_table(data, "pose")) if "pose" in data else None,
        references=tuple(_reference(kind, _table(data, kind)) for kind in REFERENCES if kind in data),
    )


def _pose(table: Mapping[str, Any]) -> ToolColumns:
    return ToolColumns(
        columns=spread(_texts(table, "columns")),
        unit=_text(table, "unit", "m"),
        rotation=spread(_texts(table, "rotation")),
        form=_text(table, "form", ""),
        rotation_unit=_text(table, "rotation_unit", "rad"),
    )


def _layout(table: Mapping[str, Any]) -> Layout:
    return Layout(
        delimiter=_text(table, "delimiter", ""),
        decimal=_text(table, "decimal", "."),
        names=spread(_texts(table, "names")),
        skip=_whole(table, "skip_lines", 0),
        per_row=_whole(table, "numbers_per_row", 0),
        topic=_text(table, "topic", ""),
    )


def _quantity(kind: str, table: Mapping[str, Any]) -> Quantity:
    zero = tuple(math.radians(value) for value in _numbers(table, "zero_deg")) or _numbers(table, "zero_m")
    return Quantity(
        kind,
        columns=spread(_texts(table, "columns")),
        unit=_texts(table, "unit"),
        side=_text(table, "side", "joint"),  # type checked by Quantity
        sign=_numbers(table, "sign"),
        zero=zero,
        rated=_numbers(table, "rated"),
    )


def _reference(kind: str, table: Mapping[str, Any]) -> tuple[str, tuple[str, ...], tuple[str, ...]]:
    columns, units = spread(_texts(table, "columns")), _texts(table, "unit")
    if not columns:
        raise ValueError(f"key '{kind}.columns': name the columns")
    for unit in units:
        if is_share(unit):
            raise ValueError(f"key '{kind}.unit': percent of what is not said: give N·m")
        factor(REFERENCES[kind], unit)
    return kind, columns, units


def _gears(table: Mapping[str, Any]) -> tuple[tuple[float, ...], ...]:
    """G of qm = G q: ratios on the diagonal, couplings beside it."""
    if not table:
        return ()
    ratios = _numbers(table, "gear_ratios")
    rows = [[ratio if j == k else 0.0 for k in range(len(ratios))] for j, ratio in enumerate(ratios)]
    couplings = table.get("coupling", [])
    if not isinstance(couplings, list):
        raise ValueError("key 'motor.coupling': give a list of tables with motor and joint")
    for entry in couplings:
        coupling = _checked(entry, "coupling")
        motor, joint = _whole(coupling, "motor"), _whole(coupling, "joint")
        if not (1 <= motor <= len(ratios) and 1 <= joint <= len(ratios)) or motor == joint:
            raise ValueError(f"key 'motor.coupling': motor {motor} and joint {joint} are no two of {len(ratios)}")
        rows[motor - 1][joint - 1] = _number(coupling, "ratio", ratios[motor - 1])
    return tuple(map(tuple, rows))


def _known(table: Mapping[str, Any], name: str) -> None:
    for key in table:
        if key not in _KEYS[name]:
            where = f"{name}.{key}" if name else key
            raise ValueError(f"key {where!r}: unknown; known here: {', '.join(_KEYS[name])}")


def _checked(table: Any, name: str) -> Mapping[str, Any]:
    if not isinstance(table, dict):
        raise ValueError(f"key {name!r}: must be a table")
    _known(table, name)
    return table


def _table(data: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    return _checked(data.get(key, {}), key)


def _text(table: Mapping[str, Any], key: str, default: str | None = None) -> Any:
    value = table.get(key, default)
    if not isinstance(value, str):
        raise ValueError(f"key {key!r}: must be given as text")
    return value


def _texts(table: Mapping[str, Any], key: str) -> tuple[str, ...]:
    value = table.get(key, [])
    values = [value] if isinstance(value, str) else value
    if not isinstance(values, list) or not all(isinstance(entry, str) for entry in values):
        raise ValueError(f"key {key!r}: must be text or a list of texts")
    return tuple(values)


def _number(table: Mapping[str, Any], key: str, default: float | None = None) -> float:
    value = table.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"key {key!r}: must be a finite number")
    return float(value)


def _numbers(table: Mapping[str, Any], key: str) -> tuple[float, ...]:
    values = table.get(key, [])
    if not isinstance(values, list):
        raise ValueError(f"key {key!r}: must be a list of numbers, one for each joint")
    return tuple(_number({key: value}, key) for value in values)


def _whole(table: Mapping[str, Any], key: str, default: int | None = None) -> int:
    value = _number(table, key, default)
    if value != int(value) or value < 0:
        raise ValueError(f"key {key!r}: must be a whole number of at least 0")
    return int(value)
