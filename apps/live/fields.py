"""Fields that are asked of a controller, and the samples that hold them."""

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate

from ...common.errors import InputError
from .packets import FORMATS

TIME, POSITION, SPEED, CURRENT = "timestamp", "actual_q", "actual_qd", "actual_current"
TORQUE, MODEL_TORQUE = "actual_current_as_torque", "target_moment"
MASS, CENTRE, INERTIA = "payload", "payload_cog", "payload_inertia"
SAFETY = "safety_mode"
FIELDS = (
    TIME, POSITION, SPEED, CURRENT, MODEL_TORQUE, TORQUE, "joint_temperatures", "actual_TCP_pose",
    MASS, CENTRE, INERTIA, "robot_mode", SAFETY,
)  # fmt: skip
"""What a recording asks for, under the protocol's names: the log's columns are called after them."""
NEEDED = (TIME, POSITION, SPEED, CURRENT)
"""Fields without which a recording says nothing."""
_STOPS = {
    3: "protective stop",
    4: "recovery",
    5: "safeguard stop",
    6: "emergency stop of the system",
    7: "emergency stop of the robot",
    8: "violation",
    9: "fault",
}
"""Safety modes in which the arm does not move as it was told (the maker's guide, safety_mode)."""


class LinkError(InputError):
    """What ended a connection: one line."""


@dataclass(frozen=True)
class Recipe:
    """Fields that a controller sends, in their order, and their types.

    ``number`` stands before each packet of data.
    """

    number: int
    fields: tuple[str, ...]
    types: tuple[str, ...]

    @cached_property
    def layout(self) -> struct.Struct:
        """How a sample is packed."""
        return struct.Struct(">" + "".join(FORMATS[kind] for kind in self.types))

    @cached_property
    def places(self) -> dict[str, slice]:
        """Where the numbers of a field stand in a sample."""
        widths = [struct.Struct(">" + FORMATS[kind]) for kind in self.types]
        counts = [len(width.unpack(bytes(width.size))) for width in widths]
        ends = list(accumulate(counts))
        return {name: slice(end - count, end) for name, count, end in zip(self.fields, counts, ends, strict=True)}

    @property
    def columns(self) -> list[str]:
        """Names of the columns: a field of several numbers counts them from 0."""
        names = []
        for field, place in self.places.items():
            count = place.stop - place.start
            names += [field] if count == 1 else [f"{field}_{k}" for k in range(count)]
        return names


@dataclass(frozen=True)
class Samples:
    """Consecutive samples of one recipe, packed as they came."""

    recipe: Recipe
    packed: bytes

    def __len__(self) -> int:
        """Number of samples."""
        return len(self.packed) // self.recipe.layout.size

    def rows(self) -> Iterator[tuple[float, ...]]:
        """All numbers of each sample, in the order of the recipe's columns."""
        return self.recipe.layout.iter_unpack(self.packed)

    def of(self, field: str) -> list[tuple[float, ...]]:
        """The numbers of one field of each sample; none where the controller does not have it."""
        place = self.recipe.places.get(field)
        return [row[place] for row in self.rows()] if place is not None else []


def stop_of(mode: float) -> str:
    """What stopped the arm, in words; empty where nothing did."""
    return _STOPS.get(int(mode), "")


def chosen(fields: Sequence[str], types: Sequence[str]) -> tuple[str, ...]:
    """The fields that a controller has, by its answer.

    Raises:
        LinkError: if a type is none of the protocol, or one of the fields that are needed is absent.
    """
    there = []
    for field, kind in zip(fields, types, strict=True):
        if kind in FORMATS:
            there.append(field)
        elif kind != "NOT_FOUND":
            raise LinkError(f"the controller sends {field} as {kind!r}, which is no type of RTDE")
    absent = [field for field in fields if field in NEEDED and field not in there]
    if absent:
        raise LinkError(f"the controller has no {', '.join(absent)}: nothing can be recorded from it")
    return tuple(there)
