"""A recording's reduced equations, and the recipe they were made by: what a store holds, as bytes."""

import hashlib
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import msgspec
import numpy as np

from ...common.errors import InputError
from ...estimation.equations.equations import Equations
from ...estimation.equations.leave_one_out import WithoutEach
from ...estimation.fit.drive_gains import Gains
from ...model import BaseParameters, Processing, Robot

_Kind = TypeVar("_Kind")


@dataclass(frozen=True)
class Recipe:
    """How equations are made from logs.

    Attributes:
        drive_gains: torque per current [N·m/A or N/A], if currents were read.
        gains: how sure they are; None where they are taken as exact.
        log_map: how logs were read, in words.
    """

    processing: Processing
    drive_gains: tuple[float, ...] | None = None
    gains: Gains | None = None
    log_map: str = ""

    @property
    def fingerprint(self) -> str:
        """Short text that differs between recipes."""
        return hashlib.sha256(repr(self).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Stored:
    """A recording of a store.

    Attributes:
        name: of the log.
        about: what is known of it: the arm's own name, day, temperature, told payload.
        whole: its equations in the robot's base parameters.
        blocks: the same cut in time.
    """

    name: str
    robot: Robot
    base: BaseParameters
    whole: Equations
    blocks: tuple[Equations, ...] = ()
    about: Mapping[str, str] = field(default_factory=dict)

    @staticmethod
    def of(
        name: str, robot: Robot, base: BaseParameters, equations: Equations, about: Mapping[str, str]
    ) -> "Stored":
        """A recording by its equations."""
        parts = equations.leave_one_out
        blocks = parts.blocks if isinstance(parts, WithoutEach) else ()
        return Stored(name, robot, base, replace(equations, leave_one_out=()), blocks, dict(about))

    @property
    def equations(self) -> Equations:
        """The equations, with those without each block of time."""
        return replace(self.whole, leave_one_out=WithoutEach(self.blocks)) if self.blocks else self.whole


def packed(value: Any) -> bytes:
    """Frozen values as bytes; the same for the same values."""
    return zlib.compress(msgspec.msgpack.encode(value, enc_hook=_plain), 1)


def unpacked(content: bytes, kind: type[_Kind]) -> _Kind:
    """The value that bytes hold.

    Raises:
        InputError: if they are not what was written.
    """
    try:
        return msgspec.msgpack.decode(zlib.decompress(content), type=kind, dec_hook=_made)
    except (zlib.error, ValueError, TypeError) as error:
        raise InputError(f"not as it was written, or by another version ({error}): reduce it again") from None


def _plain(value: Any) -> Any:
    """An array as its shape, its order in memory, which sums round by, and its bytes; a mapping as a plain one."""
    if isinstance(value, np.ndarray):
        turned = value.flags.f_contiguous and not value.flags.c_contiguous
        return [value.shape, "F" if turned else "C", np.asarray(value, "<f8").tobytes("F" if turned else "C")]
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"{type(value).__name__} has no place in a store")


def _made(kind: Any, value: Any) -> Any:
    """An array of what ``_plain`` made of it."""
    shape, order, content = value
    return np.frombuffer(content, "<f8").reshape(shape, order=order)
