"""The recordings that a problem was made from."""

from typing import NamedTuple

from ...model import Processing, Recording


class Source(NamedTuple):
    """Recordings with and without payload, and how they were processed."""

    loaded: tuple[Recording, ...]
    unloaded: tuple[Recording, ...]
    processing: Processing
