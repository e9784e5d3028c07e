"""Types of option values: how a word is written, and the one reading of it, which refuses what no arm has."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, TypeVar

from cyclopts import Parameter, Token

from ... import estimation, model
from ...common.errors import InputError

if TYPE_CHECKING:
    from ...estimation import Candidates, StopRule
    from ...model import Friction, Pose, Robot

else:  # --help names options without importing what they become
    Candidates = Friction = StopRule = Pose = object

_LEAST, _MOST = 1e-12, 1e9
"""Size of a number that is not 0: no length, time, mass or torque of an arm lies outside, and no sum of squares
overflows within."""
_COUNTS = 1_000_000
"""Points, processes or random starts at most: more fill the memory before anything is told."""
_Value = TypeVar("_Value")


class Named(NamedTuple):
    """Marks an option that names a file to read, or what is written; "-" is the standard output."""

    kind: Literal["input", "file", "folder", "stream"]
    role: str = ""  # of an input: what it is for
    endings: tuple[str, ...] = ()  # that the name of what is written may have; any by default


Reads = partial(Named, "input")
"""Marks an option that names a file to read, and what it is for."""


def checked(value: _Value, good: bool, text: str, words: str) -> _Value:
    """The value of a text, refused unless it is good; ``words``: what the text should be."""
    if not good:
        raise ValueError(f"{text!r} is not {words}")
    return value


def where(read: Callable[[str], _Value], good: Callable[[_Value], bool], words: str) -> Callable[[str], _Value]:
    """A reading of which only good values are taken; ``words``: what the text should be."""
    return lambda text: checked(value := read(text), good(value), text, words)


def whole(text: str, least: int = 0, most: int = 999_999_999) -> int:
    """A whole number; cyclopts rounds 1.5 where it reads one."""
    good = text.isdecimal() and len(text) < 10 and least <= int(text) <= most
    return checked(int(text) if good else 0, good, text, f"a whole number from {least} to {most}")


def number(text: str) -> float:
    """Any number that an arm may have."""
    try:
        value = float(text)
    except ValueError:
        raise ValueError(f"{text!r} is not a number") from None
    size = f"a number of any use here: give 0, or one from {_LEAST:g} to {_MOST:g} in size"
    return checked(value, value == 0.0 or _LEAST <= abs(value) <= _MOST, text, size)


positive_number = where(number, lambda value: value > 0.0, "a number above 0")


def share(text: str) -> float:
    """A share from 0 to below 1: 2% or 0.02."""
    try:
        value = number(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        value = math.nan
    return checked(value, 0.0 <= value < 1.0, text, "a fraction below 1: write 2% or 0.02")


def numbers(text: str, count: int | None = None, layout: str = "") -> tuple[float, ...]:
    """Numbers separated by commas; ``layout`` says what each is."""
    words = f"{count or 'a list of'} numbers separated by commas{f' ({layout})' * bool(layout)}"
    try:
        values = tuple(map(number, text.split(",")))
    except ValueError as error:
        raise ValueError(f"{text!r} is not {words}: {error}") from None
    return checked(values, len(values) == (count or len(values)), text, words)


def each_joint(given: tuple[float, ...], count: int, option: str) -> tuple[float, ...]:
    """A number for each of so many joints, where one may stand for all."""
    if len(given) not in (1, count):
        raise InputError(f"{option}: {len(given)} numbers for {count} joints: give one for all, or one each")
    return given * count if len(given) == 1 else given


def texts(text: str) -> tuple[str, ...]:
    """Texts separated by commas."""
    return tuple(part.strip() for part in text.split(","))


def different(values: Sequence[object]) -> bool:
    """True if no value is empty or stands there twice."""
    return all(values) and len(set(values)) == len(values)


def whole_numbers(text: str) -> tuple[int, ...]:
    """Whole numbers separated by commas."""
    return tuple(map(whole, texts(text)))


names_list = where(texts, different, "a list of different names separated by commas")
joint_list = where(whole_numbers, different, "a list of different joint numbers such as 2,3,5,6")
path_or_dash = where(str, lambda text: not text.startswith("--"), "a path, or - for standard output")


def with_sigma(text: str) -> tuple[tuple[float, ...], float | None]:
    """Masses [kg] and their standard deviation where it is told: 2.5+-0.01."""
    values, mark, sigma = text.replace("±", "+-").partition("+-")
    masses = numbers(values)
    checked(masses, min(masses) > 0.0, text, "a mass above 0 kg, such as 2.5 or 2.5+-0.01")
    return masses, positive_number(sigma) if mark else None


def weighed(text: str) -> tuple[float, float | None]:
    """A mass [kg] and the scale's standard deviation where it is told."""
    masses, sigma = with_sigma(text)
    checked(masses, len(masses) == 1, text, "one mass, with its standard deviation where it was weighed: 2.5+-0.01")
    return masses[0], sigma


def friction(text: str) -> tuple[Friction, ...] | Candidates:
    """Terms of friction: those that the data show, the paper's, or a list such as FS,FV,FL2."""
    if text == "auto":
        return estimation.Candidates()
    return model.PAPER if text == "paper" else model.friction_terms(texts(text))


def bounds(text: str) -> tuple[float | None, float | None]:
    """Least and largest value; either may be left out: 1,3 or ,3."""
    words = "two numbers, of which one may be omitted, such as 1,3 or ,3"
    low, high = checked(parts := text.split(","), len(parts) == 2 and any(parts), text, words)
    return number(low) if low else None, number(high) if high else None


def levels(text: str) -> dict[str, float]:
    """Numbers by name: FL2=0.06,FB1@0.1=5."""
    parts = [part.partition("=") for part in texts(text)]
    checked(parts, all(mark for _, mark, _ in parts), text, "levels such as FL2=0.06,FR1=20")
    return {name: number(value) for name, _, value in parts}


def gain_errors(text: str) -> tuple[tuple[float, ...], float]:
    """Relative errors of each joint's gain, and of all together: 2%, 2,2,3% (each in percent) or 2%,common=1%."""
    parts = texts(text)
    common = [part.removeprefix("common=") for part in parts if part.startswith("common=")]
    own = [part for part in parts if not part.startswith("common=")]
    if own and own[-1].endswith("%"):
        own = [part if part.endswith("%") else f"{part}%" for part in own]
    good = len(common) < 2 and ("%" not in "".join(own) or own[-1].endswith("%"))
    checked(own, good, text, "a list such as 2,2,3% or 2%,common=1%: the percent sign at the end, or after each")
    return tuple(map(share, own)) or (0.0,), share(common[0]) if common else 0.0


def stop_rule(text: str) -> StopRule:
    """When elimination ends: growth of the error's standard deviation, 1.02, or largest relative sigma, 10%."""
    return estimation.SigmaBound(share(text)) if text.endswith("%") else estimation.SigmaRatio(number(text))


def method(text: str) -> str:
    """A method's number, from its number or its name."""
    names = {name: str(number) for number, name in estimation.METHOD_NAMES.items()}
    known = text in (*names, *names.values(), "all")
    return checked(names.get(text, text), known, text, f"one of {', '.join(names)}, 1 to 4, all")


def mount(text: str) -> Callable[[Robot], Robot]:
    """Mounting of a robot's base: by a word, by roll, pitch, yaw in degrees, or by gravity in its frame [m/s²]."""
    if text.startswith("gravity="):
        return partial(model.with_gravity, gravity=numbers(text.removeprefix("gravity="), 3))
    try:
        roll, pitch, yaw = model.frames.MOUNTS[text] if text in model.frames.MOUNTS else numbers(text, 3)
    except ValueError as error:
        known = ", ".join(model.frames.MOUNTS)
        raise ValueError(f"{error}: give {known}, roll,pitch,yaw or gravity=X,Y,Z") from None
    return partial(model.mounted, rpy=(math.radians(roll), math.radians(pitch), math.radians(yaw)))


def chain(text: str) -> tuple[str | None, str | None]:
    """First link and flange of a chain, either of which may be left out: base_link:tool0 or :tool0."""
    base, mark, tip = text.partition(":")
    checked(text, bool(mark and (base or tip)), text, "BASE:TIP, of which one may be omitted, such as :tool0")
    return base or None, tip or None


def frame(text: str) -> Pose:
    """A frame by three lengths in m and three angles in degrees."""
    values = numbers(text, 6)
    return model.Pose.from_rpy(values[:3], [math.radians(angle) for angle in values[3:]])


def word(read: Callable[[str], Any], metavar: str, count: int | None = 1) -> Parameter:
    """A value of one word, perhaps with a minus, or of ``count`` joined by commas; without it of each word."""

    def converted(_: object, tokens: Sequence[Token]) -> Any:
        words = [token.value for token in tokens]
        if count is None:
            return tuple(map(read, words))
        return read(words[-1] if count == 1 and tokens[-1].source == "cli" else ",".join(words))

    return Parameter(
        converter=converted, n_tokens=count or 1, metavar=metavar, accepts_keys=False, allow_leading_hyphen=True
    )


def numbers_or(ending: str, metavar: str) -> Parameter:
    """A text of this ending as it stands; or numbers separated by commas."""
    return word(lambda text: text if text.lower().endswith(ending) else numbers(text), metavar)


Hertz = Annotated[float, word(number, "HZ")]
Seconds = Annotated[float, word(positive_number, "S")]
Share = Annotated[float, word(share, "SHARE")]
Count = Annotated[int, word(partial(whole, least=1, most=_COUNTS), "N")]
Seed = Annotated[int, word(whole, "N")]
Port = Annotated[int, word(partial(whole, least=1, most=65535), "N")]
Positions = Annotated[tuple[float, ...], word(numbers, "Q1,Q2,..")]
"""In degrees of turning joints, metres of sliding ones."""
Joints = Annotated[tuple[int, ...], word(joint_list, "J1,J2,..")]
Names = Annotated[tuple[str, ...], word(names_list, "A,B,..")]
Weighed = Annotated[tuple[float, float | None], word(weighed, "KG+-KG")]
_TOOL = "Frame of the payload, relative to the flange: metres, then roll, pitch, yaw in degrees (default: itself)."
ToolFrame = Annotated[Pose, word(frame, "X,Y,Z,R,P,Y"), Parameter(help=_TOOL)]
_ARM_MASS = "Mass of the whole arm, if its file has neither a mass nor link bodies."
ArmMass = Annotated[float, word(positive_number, "KG"), Parameter(help=_ARM_MASS)]
"""Of a robot to plan or simulate with, which may need a stand-in."""
FrameWords = Annotated[Pose, word(frame, "X Y Z RX RY RZ", 6)]
FrictionTerms = Annotated[tuple[Friction, ...] | Candidates, word(friction, "auto|paper|TERMS")]
Essential = Annotated[StopRule, word(stop_rule, "RATIO|PERCENT")]

LOG = Parameter(metavar="LOG")
SEVERAL = Parameter(consume_multiple=True)
DataFiles = Annotated[tuple[Annotated[str, Reads("without payload"), LOG], ...], SEVERAL]
LoadedFiles = Annotated[tuple[Annotated[str, Reads("with payload"), LOG], ...], SEVERAL]
HeldOutFiles = Annotated[tuple[Annotated[str, Reads("held out"), LOG], ...], SEVERAL]
RobotFile = Annotated[str, Reads("robot"), Parameter(metavar="NAME|FILE")]
RobotParametersFile = Annotated[str, Reads("robot's parameters"), Parameter(metavar="JSON")]
LogMapFile = Annotated[str, Reads("log map"), Parameter(metavar="TOML")]
PayloadFile = Annotated[str, Reads("payload"), Parameter(metavar="TOML")]
PayloadResultFile = Annotated[str, Reads("payload"), Parameter(metavar="PAYLOAD.json")]
NewFile = Annotated[str, Named("file"), Parameter(metavar="F")]
NewDrawing = Annotated[str, Named("file", endings=(".png", ".svg", ".pdf")), Parameter(metavar="F")]
NewFolder = Annotated[str, Named("folder"), Parameter(metavar="DIR")]
Stream = Annotated[str, Named("stream"), word(path_or_dash, "F")]
