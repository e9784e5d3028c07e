"""A designed motion for a controller: one file a format, each with a head that says what the motion is."""

from typing import TYPE_CHECKING

from ..format import Formats

if TYPE_CHECKING:
    from ..motion import WrittenMotion

FORMATS: "Formats[WrittenMotion]" = Formats(__name__, __path__)
"""Every format by its name."""
