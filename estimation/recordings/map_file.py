"""Reads a log map from TOML."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from msgspec import Meta

from ...common.schema import Real, Table, WrongKeyError, at, naming, read_toml
from .map import FilePart, LogMap
from .quantity import QUANTITIES, REFERENCES, Quantity, ToolColumns, factor, is_share
from .table import Layout, spread

_Texts = str | tuple[str, ...]
_Numbers = tuple[Real, ...]
_Count = Annotated[int, Meta(ge=0)]


class _Layout(Table, frozen=True):
    delimiter: str = ""
    decimal: str = "."
    names: _Texts = ()
    skip_lines: _Count = 0
    numbers_per_row: _Count = 0
    topic: str = ""

    def layout(self) -> Layout:
        names = spread(_listed(self.names))
        return Layout(self.delimiter, self.decimal, names, self.skip_lines, self.numbers_per_row, self.topic)


class _File(_Layout, frozen=True, kw_only=True):
    name: str


class _Time(Table, frozen=True):
    column: str | None = None
    unit: str | None = None
    rate_hz: Real | None = None


class _Coupling(Table, frozen=True):
    motor: int
    joint: int
    ratio: Real | None = None


class _Motor(Table, frozen=True):
    gear_ratios: _Numbers
    coupling: tuple[_Coupling, ...] = ()

    def gears(self) -> tuple[tuple[float, ...], ...]:
        """G of qm = G q: ratios on the diagonal, couplings beside it."""
        n = len(self.gear_ratios)
        rows = [[ratio if j == k else 0.0 for k in range(n)] for j, ratio in enumerate(self.gear_ratios)]
        for number, coupling in enumerate(self.coupling, start=1):
            motor, joint = coupling.motor, coupling.joint
            if not (1 <= motor <= n and 1 <= joint <= n) or motor == joint:
                raise WrongKeyError(f"coupling[{number}]", f"motor {motor} and joint {joint} are no two of {n}")
            ratio = self.gear_ratios[motor - 1] if coupling.ratio is None else coupling.ratio
            rows[motor - 1][joint - 1] = ratio
        return tuple(map(tuple, rows))


class _Pose(Table, frozen=True):
    columns: _Texts
    unit: str = "m"
    rotation: _Texts = ()
    form: str = ""
    rotation_unit: str = "rad"

    def columns_of_tool(self) -> ToolColumns:
        columns, rotation = (spread(_listed(names)) for names in (self.columns, self.rotation))
        return ToolColumns(columns, self.unit, rotation, self.form, self.rotation_unit)


class _Quantity(Table, frozen=True):
    columns: _Texts = ()
    unit: _Texts = ()
    side: Literal["joint", "motor"] = "joint"
    sign: _Numbers = ()
    zero_deg: _Numbers = ()
    zero_m: _Numbers = ()
    rated: _Numbers = ()

    def of_kind(self, kind: str) -> Quantity:
        zero = tuple(map(math.radians, self.zero_deg)) or self.zero_m
        columns, unit = spread(_listed(self.columns)), _listed(self.unit)
        return Quantity(kind, columns, unit, self.side, self.sign, zero, self.rated)


class _Reference(Table, frozen=True):
    advice: ClassVar[Mapping[str, str]] = {"columns": "name the columns"}

    columns: _Texts
    unit: _Texts = ()

    def of_kind(self, kind: str) -> tuple[str, tuple[str, ...], tuple[str, ...]]:
        columns, units = spread(_listed(self.columns)), _listed(self.unit)
        if not columns:
            raise WrongKeyError("columns", "name the columns")
        for unit in units:
            if is_share(unit):
                raise WrongKeyError("unit", "percent of what is not said: give N·m")
            factor(REFERENCES[kind], unit)
        return kind, columns, units


class MapTable(Table, frozen=True):
    """How a log is laid out, and what its columns hold."""

    title: str = ""
    joints: _Texts = ()
    file: _Layout = _Layout()
    files: tuple[_File, ...] = ()
    time: _Time = _Time()
    motor: _Motor | None = None
    pose: _Pose | None = None
    position: _Quantity | None = None
    velocity: _Quantity | None = None
    torque: _Quantity | None = None
    current: _Quantity | None = None
    position_reference: _Reference | None = None
    torque_reference: _Reference | None = None


def read_log_map(path: str | Path) -> LogMap:
    """Read a log map; docs/logs.md tells its keys.

    Raises:
        InputError: names the file and the key.
    """
    table = read_toml(path, MapTable)
    with naming(path):
        return _log_map(str(path), table)


def _log_map(source: str, table: MapTable) -> LogMap:
    time = table.time
    if time.rate_hz is not None and (time.column, time.unit) != (None, None):
        raise WrongKeyError("time", "give rate_hz, or column and unit")
    with at("file"):
        layout = table.file.layout()
    files = []
    for number, part in enumerate(table.files, start=1):
        with at(f"files[{number}]"):
            files.append(FilePart(part.name, part.layout()))
    with at("motor"):
        gears = table.motor.gears() if table.motor else ()
    with at("pose"):
        pose = table.pose.columns_of_tool() if table.pose else None
    return LogMap(
        source=source,
        layout=layout,
        files=tuple(files),
        time=(time.column or "t") if time.rate_hz is None else "",
        time_unit=time.unit or "s",
        rate=time.rate_hz,
        quantities=tuple(_of_kinds(table, QUANTITIES)),
        joints=_listed(table.joints),
        gears=gears,
        pose=pose,
        references=tuple(_of_kinds(table, REFERENCES)),
    )


def _of_kinds(table: MapTable, kinds: Iterable[str]) -> Iterator[Any]:
    """Quantities or references of the tables that are there."""
    for kind in kinds:
        if entry := getattr(table, kind):
            with at(kind):
                read = entry.of_kind(kind)
            yield read


def _listed(names: str | Sequence[str]) -> tuple[str, ...]:
    return (names,) if isinstance(names, str) else tuple(names)
