"""What a log holds of each joint and of the tool, in which columns and units, and what makes them SI."""

import math
import re
from collections.abc import Collection, Mapping
from typing import ClassVar, Literal

import numpy as np
from msgspec.structs import force_setattr

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.schema import Real, Table, WrongKeyError
from .table import Texts, listed, spread

QUANTITIES = ("position", "velocity", "torque", "current")
"""What is measured of each joint."""
REFERENCES = {"position_reference": "position", "torque_reference": "torque"}
"""What the controller wanted of each joint, and the quantity it belongs to; read by ``read_following``."""
FORMS = {"rotation_vector": 3, "rpy": 3, "quaternion": 4}
"""How axes are written, and in how many columns."""
_LENGTHS, _ANGLES = ("m", "mm"), ("rad", "deg")
_PLACE, _QUATERNION = ("x", "y", "z"), ("qx", "qy", "qz", "qw")
_ANGLE = {"rad": 1.0, "deg": math.pi / 180.0, "rev": 2.0 * math.pi, "m": 1.0, "mm": 1e-3}
_UNITS = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "position": _ANGLE,
    "velocity": {f"{unit}/s": factor for unit, factor in _ANGLE.items()} | {"rpm": 2.0 * math.pi / 60.0},
    "torque": {"N·m": 1.0, "mN·m": 1e-3, "N": 1.0, "percent": 0.01},
    "current": {"A": 1.0, "mA": 1e-3, "percent": 0.01},
}
_SPELLINGS = {
    "Nm": "N·m", "N*m": "N·m", "N m": "N·m", "N.m": "N·m", "N-m": "N·m", "mNm": "mN·m", "%": "percent", "µs": "us",
    "sec": "s", "seconds": "s", "msec": "ms", "revolution": "rev", "degree": "deg", "degrees": "deg", "°": "deg",
    "radian": "rad", "radians": "rad", "rad/sec": "rad/s", "deg/sec": "deg/s", "°/s": "deg/s", "amp": "A",
}  # fmt: skip
_Numbers = tuple[Real, ...]
SI = {"position": "rad", "velocity": "rad/s", "torque": "N·m", "current": "A"}


class Quantity(Table, frozen=True):
    """One measured quantity of all joints.

    Attributes:
        columns: one name for each joint, or one pattern: "{}" stands for the joint's number, "{0}" for the number
            less one, "{joint}" for its name. Empty: the standard names q1, qd1, tau1, i1.
        unit: one for all joints, or one for each; empty for the SI unit.
        side: "motor": before the gears.
        sign: 1 or -1 for each joint; of the column, before anything else.
        zero_deg, zero_m: added to joint-side positions, one for each joint.
        rated: what 100 percent is, in N·m, N or A on the column's own side, one for each joint.
    """

    columns: Texts = ()
    unit: Texts = ()
    side: Literal["joint", "motor"] = "joint"
    sign: _Numbers = ()
    zero_deg: _Numbers = ()
    zero_m: _Numbers = ()
    rated: _Numbers = ()

    def __post_init__(self) -> None:
        """Refuse what contradicts itself."""
        force_setattr(self, "columns", spread(self.columns))
        force_setattr(self, "unit", listed(self.unit))
        if self.side not in ("joint", "motor"):
            raise ValueError(f"side {self.side!r}: give 'joint' or 'motor'")
        if any(abs(sign) != 1.0 for sign in self.sign):
            raise ValueError("sign must be 1 or -1")
        if any(map(is_share, self.unit)) != bool(self.rated):
            raise ValueError("rated goes with the unit percent: what 100 percent is, for each joint")

    def check_kind(self, kind: str) -> None:
        """Refuse what no quantity of this kind has."""
        if self.side == "motor" and kind == "current":
            raise ValueError("a current has no side: leave 'side' out, drive gains tell its torque")
        if self.zero and kind != "position":
            raise ValueError("only positions have a zero")
        for unit in self.unit:
            factor(kind, unit)

    @property
    def zero(self) -> tuple[float, ...]:
        """What is added to joint-side positions [rad or m], one for each joint."""
        return tuple(map(math.radians, self.zero_deg)) or self.zero_m

    def factors(self, kind: str, n: int) -> Array:
        """What each column is multiplied by, shape (n,)."""
        factors = np.array([factor(kind, unit) for unit in self.unit or (SI[kind],)]) * np.ones(n)
        for values in (self.sign, self.rated):
            if values:
                factors = factors * values
        return factors

    def check(self, kind: str, n: int, source: str) -> None:
        """Refuse lists that are not as long as the robot has joints."""
        lists = {"unit": self.unit[1:] and self.unit, "sign": self.sign, "zero": self.zero, "rated": self.rated}
        lists["columns"] = self.columns if len(self.columns) > 1 or "{" not in "".join(self.columns) else ()
        for name, values in lists.items():
            if values and len(values) != n:
                raise InputError(
                    f"{source}: {kind}.{name} has {len(values)} entries, the robot {n} joints: give one for "
                    "each joint"
                )


class Reference(Table, frozen=True):
    """Columns and units of what the controller wanted of each joint."""

    advice: ClassVar[Mapping[str, str]] = {"columns": "name the columns"}

    columns: Texts
    unit: Texts = ()

    def check_kind(self, kind: str) -> None:
        """Refuse what no reference of this kind has."""
        if not self.columns:
            raise WrongKeyError("columns", "name the columns")
        for unit in listed(self.unit):
            if is_share(unit):
                raise WrongKeyError("unit", "percent of what is not said: give N·m")
            factor(REFERENCES[kind], unit)


class ToolColumns(Table, frozen=True):
    """Columns of the tool's position and, perhaps, of its axes, in any fixed frame.

    Attributes:
        columns: of x, y, z.
        unit: of these, "m" or "mm".
        rotation: columns of the axes; empty where they are not logged.
        form: of ``FORMS``: "rotation_vector" (Universal Robots), "rpy": roll, pitch, yaw about fixed x, y, z, or
            "quaternion": x, y, z, w.
        rotation_unit: "rad" or "deg", of a rotation vector and of rpy.
    """

    columns: Texts
    unit: str = "m"
    rotation: Texts = ()
    form: str = ""
    rotation_unit: str = "rad"

    def __post_init__(self) -> None:
        """Refuse what contradicts itself."""
        force_setattr(self, "columns", spread(self.columns))
        force_setattr(self, "rotation", spread(self.rotation))
        if len(self.columns) != 3:
            raise ValueError(f"pose.columns has {len(self.columns)} names: give those of x, y and z")
        for name, unit, known in (("unit", self.unit, _LENGTHS), ("rotation_unit", self.rotation_unit, _ANGLES)):
            if unit not in known:
                raise ValueError(f"pose.{name} {unit!r}: give one of {', '.join(known)}")
        if bool(self.rotation) != bool(self.form):
            raise ValueError(f"pose.rotation and pose.form go together; form is one of {', '.join(FORMS)}")
        if self.form and self.form not in FORMS:
            raise ValueError(f"pose.form {self.form!r}: give one of {', '.join(FORMS)}")
        if self.form and len(self.rotation) != FORMS[self.form]:
            raise ValueError(
                f"pose.rotation has {len(self.rotation)} names: a {self.form} has {FORMS[self.form]} columns"
            )
        if self.form == "quaternion" and self.rotation_unit != "rad":
            raise ValueError("pose.rotation_unit: a quaternion has none, leave it out")

    @property
    def all(self) -> tuple[str, ...]:
        """Every column."""
        return (*self.columns, *self.rotation)


def standard_pose(names: Collection[str]) -> ToolColumns | None:
    """What a log without a map holds: x, y, z [m], perhaps with a quaternion qx, qy, qz, qw; None without them."""
    if not set(_PLACE) <= set(names):
        return None
    if set(_QUATERNION) <= set(names):
        return ToolColumns(_PLACE, "m", _QUATERNION, "quaternion")
    return ToolColumns(_PLACE)


def factor(quantity: str, unit: str) -> float:
    """What a number in ``unit`` is multiplied by; "percent" gives the share of the rated value.

    Args:
        quantity: "time", "position", "velocity", "torque" or "current".
        unit: of that quantity.

    Raises:
        InputError: lists the units that are known.
    """
    known, unit = _UNITS[quantity], _SPELLINGS.get(unit, unit)
    if unit not in known:
        raise InputError(f"unit {unit!r} of {quantity}: give one of {', '.join(known)}")
    return known[unit]


def known_unit(text: str) -> bool:
    """Whether a text is a unit of time or of anything that a log holds of a joint."""
    return any(_SPELLINGS.get(text, text) in units for units in _UNITS.values())


def with_unit(name: str) -> tuple[str, str]:
    """A column's name and the unit in brackets behind it, "q1 [deg]"; no unit where there is none that is known."""
    match = re.fullmatch(r"(.*\S)\s*[\[(]\s*([^\])]*?)\s*[\])]", name)
    return (match[1], match[2]) if match and known_unit(match[2]) else (name, "")


def is_share(unit: str) -> bool:
    """Whether the unit is a share of a rated value."""
    return _SPELLINGS.get(unit, unit) == "percent"
