"""A log map tells how to read a log: its layout, columns, units, sides and signs, by a file or the command line."""

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from msgspec import Meta, field
from msgspec.structs import force_setattr, replace

from ...common import Array, InputError
from ...common.schema import Real, Table, WrongKeyError, at, read_toml

Texts = str | tuple[str, ...]  # one text stands for a list of it
_Count = Annotated[int, Meta(ge=0)]
DELIMITERS = {"comma": ",", "tab": "\t", "semicolon": ";", "space": None}
"""Separators of cells; None stands for any white space."""
QUANTITIES = ("position", "velocity", "torque", "current")  # quantities that are measured of each joint
REFERENCES = {"position_reference": "position", "torque_reference": "torque"}
"""What the controller wanted of each joint, and the quantities it belongs to; ``read_following`` reads it."""
FORMS = {"rotation_vector": 3, "rpy": 3, "quaternion": 4}  # ways to write axes, and their number of columns
LONGEST_NAME = 1000  # letters of a column's name; what looks for numbers and units in longer ones would take hours
COMMAND_LINE = "command line"  # source of a map that no file gives
_TYPED = {"sign": "signs", "joints": "--joints"}  # keys of a map as they are typed
_ANGLE = {"rad": 1.0, "deg": math.pi / 180.0, "rev": 2.0 * math.pi, "m": 1.0, "mm": 1e-3}
CURRENT = {"A": 1.0, "mA": 1e-3, "raw": 1.0, "percent": 0.01}
_UNITS = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "position": _ANGLE,
    "velocity": {f"{unit}/s": factor for unit, factor in _ANGLE.items()} | {"rpm": 2.0 * math.pi / 60.0},
    "torque": {"N·m": 1.0, "mN·m": 1e-3, "N": 1.0, **CURRENT},  # columns called torques may hold something else
    "current": CURRENT,
}
_SPELLINGS = {
    "Nm": "N·m", "N*m": "N·m", "N m": "N·m", "N.m": "N·m", "N-m": "N·m", "mNm": "mN·m", "%": "percent", "µs": "us",
    "sec": "s", "seconds": "s", "msec": "ms", "revolution": "rev", "degree": "deg", "degrees": "deg", "°": "deg",
    "radian": "rad", "radians": "rad", "rad/sec": "rad/s", "deg/sec": "deg/s", "°/s": "deg/s", "amp": "A",
}  # fmt: skip
_Numbers = tuple[Real, ...]
SI = {"position": "rad", "velocity": "rad/s", "torque": "N·m", "current": "A"}
SHORT = {"t": "time", "q": "position", "qd": "velocity", "tau": "torque", "i": "current"}


def factor(quantity: str, unit: str) -> float:
    """Factor from a number in ``unit`` to SI; "percent" gives the ratio to the rated value."""
    known, unit = _UNITS[quantity], _SPELLINGS.get(unit, unit)
    if unit not in known:
        raise InputError(f"unit {unit!r} of {quantity}: give one of {', '.join(known)}")
    return known[unit]


def known_unit(text: str) -> bool:
    """Tell whether a text is a unit of time or of anything that a log holds of a joint."""
    return any(_SPELLINGS.get(text, text) in units for units in _UNITS.values())


def with_unit(name: str) -> tuple[str, str]:
    """A column's name and the unit in brackets behind it, "q1 [deg]"; no unit where there is none that is known."""
    match = re.fullmatch(r"(.*\S)\s*[\[(]\s*([^\])]*?)\s*[\])]", name) if len(name) <= LONGEST_NAME else None
    return (match[1], match[2]) if match and known_unit(match[2]) else (name, "")


def listed(names: Texts) -> tuple[str, ...]:
    """Names of which a single one may stand alone, with ranges written out: "q1..6" is q1 to q6."""
    result: list[str] = []
    for name in (names,) if isinstance(names, str) else names:
        match = re.fullmatch(r"(.*?)(\d+)\.\.(\d+)", name)
        first, last = (int(match[2]), int(match[3])) if match else (0, 0)
        if not first <= last <= first + 1000:
            raise InputError(f"names {name!r}: a range must rise, as in q1..6")
        result += [f"{match[1]}{k}" for k in range(first, last + 1)] if match else [name]
    return tuple(result)


class Layout(Table, frozen=True):
    """The layout of a text file, and what else a reader must know."""

    delimiter: Literal["", "comma", "tab", "semicolon", "space"] = ""  # empty: it is found out
    decimal: Literal["", ".", ","] = ""  # empty: it is found out
    names: Texts = ()  # of the columns in the order of the file, instead of a header line; "q1..6" stands for six
    skip: _Count = field(default=0, name="skip_lines")  # before the header, or the numbers where names are given
    per_row: _Count = field(default=0, name="numbers_per_row")  # of a sample in a file of one number a line
    topic: str = ""  # of a ROS bag; empty where there is only one with joint states
    name: str = ""  # of the file within a log that is a folder

    def __post_init__(self) -> None:
        force_setattr(self, "names", listed(self.names))
        if self.decimal == "," and self.delimiter == "comma":
            raise ValueError("decimal ',' needs a delimiter other than comma")
        if self.per_row and self.per_row != len(self.names):
            raise ValueError(f"numbers_per_row is {self.per_row}, but {len(self.names)} names are given")
        if twice := [name for name in self.names if self.names.count(name) > 1]:
            raise ValueError(f"name {min(twice)!r} is given twice")


class Time(Table, frozen=True):
    """The column of time and its unit ("s", "ms", "us" or "ns"), or the even sampling rate of a log without one.

    Empty: the column is found by its name, the unit by name or steps.
    """

    column: str = ""
    unit: str = ""
    rate: Real | None = field(default=None, name="rate_hz")

    def __post_init__(self) -> None:
        if self.rate is None:
            if self.unit:
                factor("time", self.unit)
        elif self.column or self.unit:
            raise ValueError("give rate_hz, or column and unit")
        elif not 0.0 < self.rate < 1e9:
            raise ValueError(f"rate_hz must be positive, got {self.rate}")


class _Coupling(Table, frozen=True):
    motor: int
    joint: int
    ratio: Real | None = None


class Gears(Table, frozen=True):
    """Gear ratios of the motors, and motors that turn with a joint that is not their own."""

    gear_ratios: tuple[Real, ...]
    coupling: tuple[_Coupling, ...] = ()

    def __post_init__(self) -> None:
        if self.gear_ratios and abs(np.linalg.det(self.matrix())) < 1e-9:
            raise ValueError("gear ratios: a motor does not turn with its joint (ratio 0)")

    def matrix(self) -> Array:
        """G of q_r = G q (8): ratios on the diagonal, couplings beside it, n x n."""
        n, matrix = len(self.gear_ratios), np.diag(self.gear_ratios)
        for number, coupling in enumerate(self.coupling, start=1):
            motor, joint = coupling.motor, coupling.joint
            if not (1 <= motor <= n and 1 <= joint <= n) or motor == joint:
                raise WrongKeyError(f"coupling[{number}]", f"motor {motor} and joint {joint} are no two of {n}")
            matrix[motor - 1, joint - 1] = self.gear_ratios[motor - 1] if coupling.ratio is None else coupling.ratio
        return matrix


class Quantity(Table, frozen=True):
    """One quantity of all joints, measured or wanted by the controller.

    Columns are one name for each joint, or one pattern: "{}" stands for the joint's number, "{0}" for the number
    less one, "{joint}" for its name. Lists hold one entry for each joint.
    """

    columns: Texts = ()  # empty: the standard names q1, qd1, tau1, i1
    unit: Texts = ()  # one for all joints, or one for each; empty for the SI unit
    side: Literal["joint", "motor"] = "joint"  # motor: before the gears
    sign: _Numbers = ()  # 1 or -1, of the column, before anything else
    zero_deg: _Numbers = ()  # added to joint-side positions, one for each joint
    zero_m: _Numbers = ()  # that of sliding joints
    rated: _Numbers = ()  # what 100 percent is, in N·m, N or A on the column's own side

    def __post_init__(self) -> None:
        force_setattr(self, "columns", listed(self.columns))
        force_setattr(self, "unit", tuple(_SPELLINGS.get(unit, unit) for unit in listed(self.unit)))


class ToolColumns(Table, frozen=True):
    """Columns of the tool's position and, perhaps, of its axes, in any fixed frame.

    Forms of axes: "rotation_vector" (Universal Robots), "rpy": roll, pitch, yaw about fixed x, y, z, or
    "quaternion": x, y, z, w.
    """

    columns: Texts  # of x, y, z
    unit: Literal["m", "mm"] = "m"  # of these
    rotation: Texts = ()  # columns of the axes; empty where they are not logged
    form: Literal["rotation_vector", "rpy", "quaternion"] | None = None
    rotation_unit: Literal["rad", "deg"] = "rad"  # of a rotation vector and of rpy

    def __post_init__(self) -> None:
        force_setattr(self, "columns", listed(self.columns))
        force_setattr(self, "rotation", listed(self.rotation))
        turns = len(self.rotation)
        if len(self.columns) != 3:
            raise ValueError(f"pose.columns has {len(self.columns)} names: give those of x, y and z")
        if bool(turns) != bool(self.form):
            raise ValueError(f"pose.rotation and pose.form go together; form is one of {', '.join(FORMS)}")
        if self.form and turns != FORMS[self.form]:
            raise ValueError(f"pose.rotation has {turns} names: a {self.form} has {FORMS[self.form]} columns")
        if self.form == "quaternion" and self.rotation_unit != "rad":
            raise ValueError("pose.rotation_unit: a quaternion has none: remove it")


class LogMap(Table, frozen=True):
    """Columns and units of a log; without arguments the standard CSV in SI units.

    Attributes:
        source: where it came from, for messages.
        joints: names of the joints, base to tip.
        layout: of a text file.
        files: the files of a log that is a folder.
        motor: gears, where anything is on the motor side.
        pose: columns of the tool's pose.
        position, velocity, torque, current: what the log holds; what is absent goes by the standard names.
        position_reference, torque_reference: what the controller wanted; else by standard names.
    """

    source: str = field(default="log map", name="title")
    joints: Texts = ()
    layout: Layout = field(default=Layout(), name="file")
    files: tuple[Layout, ...] = ()
    time: Time = Time()
    motor: Gears | None = None
    pose: ToolColumns | None = None
    position: Quantity = Quantity()
    velocity: Quantity = Quantity()
    torque: Quantity = Quantity()
    current: Quantity = Quantity()
    position_reference: Quantity | None = None
    torque_reference: Quantity | None = None

    def __post_init__(self) -> None:
        force_setattr(self, "joints", listed(self.joints))
        # What contradicts itself, and what no quantity of its kind has.
        for kind in (*QUANTITIES, *REFERENCES):
            stated: Quantity = getattr(self, kind) or Quantity()
            with at(kind):
                if kind in REFERENCES and getattr(self, kind):
                    if not stated.columns:
                        raise WrongKeyError("columns", "name the columns")
                    if stated != Quantity(stated.columns, stated.unit):
                        raise ValueError(
                            "give columns and unit; side, sign and zero are those of the measured quantity"
                        )
                    if "percent" in stated.unit:
                        raise WrongKeyError("unit", "percent needs a rated value: give N·m")
                if any(abs(sign) != 1.0 for sign in stated.sign):
                    raise ValueError("sign must be 1 or -1")
                if stated.rated and "percent" not in stated.unit:
                    raise ValueError("rated goes with the unit percent: what 100 percent is, for each joint")
                if stated.side == "motor" and kind == "current":
                    raise ValueError("a current has no side: remove 'side'; the drive gains include it")
                if (stated.zero_deg or stated.zero_m) and kind != "position":
                    raise ValueError("only positions have a zero")
                for unit in stated.unit:
                    factor(REFERENCES.get(kind, kind), unit)
        if any(self.quantity(kind).side == "motor" for kind in QUANTITIES) and not self.motor:
            raise ValueError("motor side without gear ratios: give [motor] gear_ratios")
        if len(set(self.joints)) != len(self.joints):
            raise ValueError("a joint is named twice")
        for number, part in enumerate(self.files, start=1):
            if not part.name:
                raise WrongKeyError(f"files[{number}].name", "missing: must be a text")

    def quantity(self, kind: str) -> Quantity:
        """Tell how a quantity of ``QUANTITIES`` or of ``REFERENCES`` is read.

        Sign, side and zero of a reference are those of the measured quantity, but a torque's side is the joint's.
        Its units are a position's own, N·m or N for a torque, unless they are given.
        """
        stated: Quantity = getattr(self, kind) or Quantity()
        if kind not in REFERENCES:
            return stated
        measured = self.position if kind == "position_reference" else Quantity(sign=self.torque.sign)
        rated = () if stated.unit else measured.rated
        return replace(measured, columns=stated.columns, unit=stated.unit or measured.unit, rated=rated)

    def check(self, n: int) -> None:
        """Refuse a map for another number of joints."""
        sizes = {"joints": len(self.joints), "gear_ratios": len(self.motor.gear_ratios) if self.motor else 0}
        for kind in (*QUANTITIES, *(kind for kind in REFERENCES if getattr(self, kind))):
            own, name = self.quantity(kind), REFERENCES.get(kind, kind)
            several = len(own.columns) > 1 or "{" not in "".join(own.columns)  # else one pattern for all
            sizes |= {f"{name}.columns": several * len(own.columns), f"{name}.unit": len(own.unit[1:] and own.unit)}
            entries = {"sign": own.sign, "zero": own.zero_deg or own.zero_m, "rated": own.rated}
            sizes |= {f"{name}.{key}": len(given) for key, given in entries.items()}
        for name, size in sizes.items():
            if size not in (0, n):
                typed = self.source == COMMAND_LINE
                where = _TYPED.get(name.rpartition(".")[2], name) if typed else f"{self.source}: {name}"
                raise InputError(f"{where} has {size} entries, the robot {n} joints: give one for each joint")

    def si(self, kind: str, raw: Array) -> Array:
        """Columns of a quantity or reference, rows x n, as joint-side SI values."""
        quantity, kind = self.quantity(kind), REFERENCES.get(kind, kind)
        factors = np.array([factor(kind, unit) for unit in quantity.unit or (SI[kind],)])
        values = raw * (factors * (quantity.sign or 1.0) * (quantity.rated or 1.0))
        if quantity.side == "motor" and self.motor:  # (8) and by duality (9): tau = G' tau_m
            G = self.motor.matrix()
            values = values @ G if kind == "torque" else values @ np.linalg.inv(G).T
        zero = tuple(map(math.radians, quantity.zero_deg)) or quantity.zero_m
        return values + zero if zero else values


def read_log_map(path: str | Path) -> LogMap:
    """Read a log map; docs/logs.md tells its keys.

    Raises:
        InputError: names the file and the key.
    """
    return replace(read_toml(path, LogMap), source=str(path))


def with_flags(
    log_map: LogMap,
    joints: Sequence[str] = (),
    units: Sequence[str] = (),
    signs: Sequence[float] = (),
    topic: str = "",
) -> LogMap:
    """A log map with what the command line says instead.

    Args:
        joints: names, base to tip.
        units: "q=deg", "tau=mN·m", "t=ms", ...; "t=500Hz" where a log has no time but that rate.
        signs: 1 or -1 for each joint, of positions, speeds, torques and currents alike: its sense is turned.
        topic: of a ROS bag.
    """
    option = "--units"
    try:
        for entry in units:
            name, _, unit = entry.partition("=")
            if name not in SHORT or not unit:
                raise InputError(f"--units {entry!r}: give q=, qd=, tau=, i= or t= with a unit, as q=deg")
            rate = re.fullmatch(r"([\d.]+) ?Hz", unit) if name == "t" else None
            before: Time | Quantity = getattr(log_map, SHORT[name])
            changed = Time(rate=float(rate[1])) if rate else replace(before, unit=unit)
            log_map = replace(log_map, **{SHORT[name]: changed})
        option = "signs"
        for kind in QUANTITIES if signs else ():
            if log_map.quantity(kind).sign:
                raise InputError("signs and a sign in the log map: give only one of them")
            log_map = replace(log_map, **{kind: replace(log_map.quantity(kind), sign=tuple(signs))})
        option, layout = "--joints", log_map.layout
        return replace(
            log_map, joints=tuple(joints) or log_map.joints, layout=replace(layout, topic=topic or layout.topic)
        )
    except InputError:
        raise
    except ValueError as error:  # of a key of the map, which nobody typed
        raise InputError(f"{option}: {getattr(error, 'problem', error)}") from None
