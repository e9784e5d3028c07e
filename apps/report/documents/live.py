"""The document of ``weigh --live`` and ``--replay``, and the lines of ``--watch``."""

import math
from collections.abc import Sequence

from ....common.arrays import Array
from ....common.schema import Document
from ....estimation.payload import Change, Weighed
from ...results.parts import Number


class ChangeDocument(Document, frozen=True):
    """A payload that was put on or off: when, by which mass, and by which time of the samples it was told."""

    time_s: float
    change_kg: float
    interval95_kg: tuple[float, float]
    told_s: float


class LiveDocument(Document, frozen=True):
    """The payload by the last seconds of motion, and all changes; ``hidden``: what is in the way of the mass."""

    robot: str
    frame: str
    seconds: float
    mass_kg: Number
    interval95_kg: tuple[float, float] | None
    com_m: tuple[Number, ...]
    com_sigma_m: tuple[Number, ...]
    hidden: str
    changes: tuple[ChangeDocument, ...]


def change_document(change: Change, at: float) -> ChangeDocument:
    """A line of ``--watch``; ``at``: when it was known [s]."""
    return ChangeDocument(change.time, change.mass, (change.low, change.high), at)


def live_document(robot: str, frame: str, weighed: Weighed, changes: Sequence[ChangeDocument]) -> LiveDocument:
    """What ``weigh --live --json`` writes; ``robot`` and ``frame``: their names."""
    return LiveDocument(
        robot=robot,
        frame=frame,
        seconds=weighed.seconds,
        mass_kg=None if weighed.hidden else weighed.mass,
        interval95_kg=None if weighed.hidden else (weighed.low, weighed.high),
        com_m=_known(weighed.com),
        com_sigma_m=_known(weighed.com_sigma),
        hidden=weighed.hidden,
        changes=tuple(changes),
    )


def _known(values: Array) -> tuple[float | None, ...]:
    return tuple(value if math.isfinite(value) else None for value in values.tolist())
