"""A wrong assumption and how much better the recording fits without it."""

from typing import NamedTuple


class Suspect(NamedTuple):
    """What may be wrong, in words, and the misfit that is left when it is undone."""

    words: str
    misfit: float
