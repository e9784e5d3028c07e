"""Recordings filtered and aligned once, however many questions are asked of them."""

from ...model import Processing, Recording
from ...model.motion import Measurement
from .alignment import AlignedPair, aligned
from .filtering import grid_rate, measurement


class Measurements:
    """What filtering and aligning make of recordings: worked out when first asked for, then remembered.

    Recordings are told apart by identity; they are kept as long as this value.
    """

    def __init__(self, processing: Processing) -> None:
        """Nothing is filtered yet; ``processing``: settings of all that will be."""
        self.processing = processing
        self._filtered: dict[int, tuple[Recording, Measurement]] = {}
        self._aligned: dict[tuple[int, int], tuple[Recording, Recording, AlignedPair]] = {}

    def of(self, recording: Recording) -> Measurement:
        """The recording filtered.

        Raises:
            InputError: as ``measurement``.
        """
        key = id(recording)
        if key not in self._filtered:
            self._filtered[key] = recording, measurement(recording, self.processing)
        return self._filtered[key][1]

    def pair(self, unloaded: Recording, loaded: Recording) -> AlignedPair:
        """Two recordings of one trajectory on one time, not filtered yet: ``of`` takes the pair's recordings.

        Raises:
            InputError: as ``aligned``.
        """
        key = id(unloaded), id(loaded)
        if key not in self._aligned:
            settings = self.processing
            pair = aligned(unloaded, loaded, grid_rate(loaded, settings), settings.max_mismatch)
            self._aligned[key] = unloaded, loaded, pair
        return self._aligned[key][2]
