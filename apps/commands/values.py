"""Values as they are written on the command line."""

from __future__ import annotations

import argparse
import math
from typing import TypeVar

from ... import estimation, model

_LEAST, _MOST = 1e-12, 1e9
"""Size of a number that is not 0: no length, time, mass or torque of an arm lies outside, and no sum of squares
overflows within."""
_COUNTS = 1_000_000
"""Points, arms, days or processes at most: more fill the memory before anything is told."""
_Value = TypeVar("_Value")


def checked(value: _Value, good: bool, text: str, words: str) -> _Value:
    """The value of a text, refused unless it is good; ``words``: what the text should be."""
    if not good:
        raise argparse.ArgumentTypeError(f"{text!r} is not {words}")
    return value


def method(text: str) -> str:
    """A method's number, from its number or its name."""
    names = {name: str(number) for number, name in estimation.METHOD_NAMES.items()}
    known = text in (*names, *names.values(), "all")
    return checked(names.get(text, text), known, text, f"one of {', '.join(names)}, 1 to 4, all")


def fraction(text: str) -> float:
    """A percentage, "10%" or "10", as a fraction."""
    try:
        return number(text.strip().removesuffix("%")) / 100.0
    except argparse.ArgumentTypeError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a percentage such as 10%") from None


def whole(text: str) -> int:
    """A whole number of at least 0."""
    if not text.isdecimal() or len(text) > 9:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number of at least 0")
    return int(text)


def positive(text: str) -> int:
    """A whole number of at least 1, such as a count."""
    count = whole(text)
    return checked(count, 1 <= count <= _COUNTS, text, f"a whole number from 1 to {_COUNTS}")


def port_number(text: str) -> int:
    """A port of TCP."""
    port = whole(text)
    return checked(port, 0 < port < 65536, text, "a port from 1 to 65535")


def number(text: str) -> float:
    """Any number that an arm may have."""
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None
    if value != 0.0 and not _LEAST <= abs(value) <= _MOST:
        size = f"give 0, or one from {_LEAST:g} to {_MOST:g} in size"
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of any use here: {size}")
    return value


def share(text: str) -> float:
    """A number from 0 to below 1."""
    value = number(text)
    return checked(value, 0.0 <= value < 1.0, text, "a share from 0 to below 1")


def gains_or_file(text: str) -> tuple[float, ...] | str:
    """Numbers separated by commas, or the path of a JSON file."""
    return text if text.lower().endswith(".json") else gains_list(text)


def texts(text: str) -> tuple[str, ...]:
    """Texts separated by commas."""
    return tuple(part.strip() for part in text.split(","))


def three(text: str) -> tuple[float, float, float]:
    """Three finite numbers separated by commas."""
    x, y, z = numbers(text, 3)
    return x, y, z


def mount(text: str) -> tuple[float, float, float]:
    """Roll, pitch, yaw [rad] of the base, from a word or three angles in degrees."""
    degrees = model.frames.MOUNTS[text] if text in model.frames.MOUNTS else three(text)
    roll, pitch, yaw = (math.radians(angle) for angle in degrees)
    return roll, pitch, yaw


def tool_frame(text: str) -> model.Pose:
    """A frame by three lengths in m and three angles in degrees."""
    values = numbers(text, 6)
    return model.Pose.from_rpy(values[:3], [math.radians(angle) for angle in values[3:]])


def numbers(text: str, count: int | None = None) -> tuple[float, ...]:
    """Finite numbers separated by commas."""
    try:
        values = tuple(number(part) for part in text.split(","))
    except argparse.ArgumentTypeError:
        values = ()
    good = len(values) == (count or len(values) or 1) and all(abs(value) < 1e6 for value in values)
    return checked(values, good, text, f"{count or 'a list of'} finite numbers with commas")


def gains_list(text: str) -> tuple[float, ...]:
    """Numbers separated by commas."""
    try:
        return tuple(number(part) for part in text.split(","))
    except argparse.ArgumentTypeError as error:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a list of numbers separated by commas: {error}"
        ) from None


def masses_list(text: str) -> tuple[float, ...]:
    """Masses [kg] separated by commas."""
    values = gains_list(text)
    if not all(0.0 < value < math.inf for value in values):
        raise argparse.ArgumentTypeError(f"{text!r}: a mass in kg is more than zero, and finite")
    return values


def whole_list(text: str) -> tuple[int, ...]:
    """Whole numbers separated by commas."""
    parts = text.replace(" ", "").split(",")
    good = all(part.isdecimal() and len(part) < 9 for part in parts)
    return tuple(map(int, checked(parts, good, text, "a list of whole numbers such as 1,2,2")))


def names_list(text: str) -> tuple[str, ...]:
    """Names separated by commas."""
    names = tuple(part.strip() for part in text.split(","))
    good = all(names) and len(set(names)) == len(names)
    return checked(names, good, text, "a list of different names separated by commas")


def positive_number(text: str) -> float:
    """A number above 0."""
    value = number(text)
    return checked(value, 0.0 < value < 1e9, text, "a number above 0")


def relative(text: str) -> float:
    """A share: 2% or 0.02."""
    try:
        value = number(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except argparse.ArgumentTypeError:
        value = math.nan
    return checked(value, 0.0 <= value < 1.0, text, "a share: write 2% or 0.02")


def relative_list(text: str) -> tuple[float, ...]:
    """Shares separated by commas; a percent sign at the end stands for all of them."""
    parts = text.split(",")
    if text.endswith("%"):
        parts = [part if part.endswith("%") else f"{part}%" for part in parts]
    elif text.count("%"):
        raise argparse.ArgumentTypeError(f"{text!r}: write the percent sign at the end, or after every number")
    return tuple(relative(part) for part in parts)


def seconds_list(text: str) -> tuple[float, ...]:
    """Different positive times separated by commas [s]."""
    times = tuple(number(part) for part in text.split(","))
    good = all(0.0 < time < math.inf for time in times) and len(set(times)) == len(times)
    return checked(times, good, text, "a list of different times in seconds such as 0.1,0.5,1")


def joint_list(text: str) -> tuple[int, ...]:
    """Numbers of joints separated by commas."""
    try:
        joints = tuple(int(part) for part in text.split(","))
    except ValueError:
        joints = ()
    good = min(joints, default=0) > 0 and len(set(joints)) == len(joints)
    return checked(joints, good, text, "a list of different joint numbers such as 2,3,5,6")
