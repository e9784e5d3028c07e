"""Recordings filtered once, however many questions are asked of them."""

from typing import NamedTuple
from weakref import finalize

from ...model import Processing, Recording
from ...model.motion import Measurement
from .filtering import grid_rate, measured


class _Asked(NamedTuple):
    """A recording by its identity, and the settings that the filter knows of."""

    recording: int
    rate: float | None
    cutoff: float | None


_made: dict[_Asked, Measurement] = {}


def measurement(recording: Recording, processing: Processing) -> Measurement:
    """The recording even in time and filtered, as ``measured`` makes it; remembered as long as the recording lives.

    Raises:
        InputError: as ``measured``.
    """
    key = _Asked(id(recording), grid_rate(recording, processing), processing.cutoff)
    if key not in _made:
        _made[key] = measured(recording, processing)
        finalize(recording, _made.pop, key, None)
    return _made[key]
