"""Units that logs come in: what makes them SI."""

import math

from ...common.errors import InputError

TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
"""Units of time."""
_ANGLE = {"rad": 1.0, "deg": math.pi / 180.0, "rev": 2.0 * math.pi, "m": 1.0, "mm": 1e-3}
_UNITS = {
    "position": _ANGLE,
    "velocity": {f"{unit}/s": factor for unit, factor in _ANGLE.items()} | {"rpm": 2.0 * math.pi / 60.0},
    "torque": {"N·m": 1.0, "mN·m": 1e-3, "N": 1.0, "percent": 0.01},
    "current": {"A": 1.0, "mA": 1e-3, "percent": 0.01},
}
_SPELLINGS = {"Nm": "N·m", "N*m": "N·m", "N m": "N·m", "mNm": "mN·m", "%": "percent", "µs": "us", "revolution":
              "rev", "degree": "deg", "degrees": "deg", "rad/sec": "rad/s", "°": "deg", "°/s": "deg/s"}  # fmt: skip
DEFAULT = {"position": "rad", "velocity": "rad/s", "torque": "N·m", "current": "A"}
"""Unit of each quantity unless told otherwise."""


def factor(quantity: str, unit: str) -> float:
    """What a number in ``unit`` is multiplied by; "percent" gives the share of the rated value.

    Args:
        quantity: "time", "position", "velocity", "torque" or "current".
        unit: of that quantity.

    Raises:
        InputError: lists the units that are known.
    """
    known = TIME if quantity == "time" else _UNITS[quantity]
    unit = _SPELLINGS.get(unit, unit)
    if unit not in known:
        raise InputError(f"unit {unit!r} of {quantity}: give one of {', '.join(known)}")
    return known[unit]


def is_share(unit: str) -> bool:
    """Whether the unit is a share of a rated value."""
    return _SPELLINGS.get(unit, unit) == "percent"
