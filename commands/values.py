"""Values as they are written on the command line."""

from __future__ import annotations

import argparse
import math

from .. import estimation, model


def method(text: str) -> str:
    """A method's number, from its number or its name."""
    names = {name: str(number) for number, name in estimation.payload.METHOD_NAMES.items()}
    if text not in (*names, *names.values(), "all"):
        raise argparse.ArgumentTypeError(f"{text!r} is not one of {', '.join(names)}, 1 to 4, all")
    return names.get(text, text)


def fraction(text: str) -> float:
    """A percentage, "10%" or "10", as a fraction."""
    try:
        return float(text.strip().removesuffix("%")) / 100.0
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a percentage such as 10%") from None


def whole(text: str) -> int:
    """A whole number of at least 0."""
    if not text.isdecimal() or len(text) > 9:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number of at least 0")
    return int(text)


def positive(text: str) -> int:
    """A whole number of at least 1."""
    if whole(text) == 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number of at least 1")
    return int(text)


def port_number(text: str) -> int:
    """A port of TCP."""
    if not 0 < whole(text) < 65536:
        raise argparse.ArgumentTypeError(f"{text!r} is not a port from 1 to 65535")
    return int(text)


def number(text: str) -> float:
    """Any number."""
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None


def share(text: str) -> float:
    """A number from 0 to below 1."""
    value = number(text)
    if not 0.0 <= value < 1.0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a share from 0 to below 1")
    return value


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
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        values = ()
    if not values or (count and len(values) != count) or not all(abs(value) < 1e6 for value in values):
        raise argparse.ArgumentTypeError(f"{text!r} is not {count or 'a list of'} finite numbers with commas")
    return values


def gains_list(text: str) -> tuple[float, ...]:
    """Numbers separated by commas."""
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of numbers separated by commas") from None


def masses_list(text: str) -> tuple[float, ...]:
    """Masses [kg] separated by commas."""
    values = gains_list(text)
    if not all(0.0 < value < math.inf for value in values):
        raise argparse.ArgumentTypeError(f"{text!r}: a mass in kg is more than zero, and finite")
    return values


def whole_list(text: str) -> tuple[int, ...]:
    """Whole numbers separated by commas."""
    parts = text.replace(" ", "").split(",")
    if not all(part.isdecimal() and len(part) < 9 for part in parts):
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of whole numbers such as 1,2,2")
    return tuple(map(int, parts))


def names_list(text: str) -> tuple[str, ...]:
    """Names separated by commas."""
    names = tuple(part.strip() for part in text.split(","))
    if not all(names) or len(set(names)) != len(names):
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of different names separated by commas")
    return names


def positive_number(text: str) -> float:
    """A number above 0."""
    value = number(text)
    if not 0.0 < value < 1e9:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number above 0")
    return value


def relative(text: str) -> float:
    """A share: 2% or 0.02."""
    try:
        value = float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        value = math.nan
    if not 0.0 <= value < 1.0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a share: write 2% or 0.02")
    return value


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
    if not all(0.0 < time < math.inf for time in times) or len(set(times)) != len(times):
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of different times in seconds such as 0.1,0.5,1")
    return times


def joint_list(text: str) -> tuple[int, ...]:
    """Numbers of joints separated by commas."""
    try:
        joints = tuple(int(part) for part in text.split(","))
    except ValueError:
        joints = ()
    if not joints or min(joints) < 1 or len(set(joints)) != len(joints):
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of different joint numbers such as 2,3,5,6")
    return joints
