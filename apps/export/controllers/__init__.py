"""A payload in the format of a controller or of a simulator: one file a format, which is all that a new one needs.

Every format gives one small text that says frame, reference point, order, units and source of its numbers.
"""

from typing import TYPE_CHECKING

from ..format import Formats

if TYPE_CHECKING:
    from ..load import ControllerLoad

FORMATS: "Formats[ControllerLoad]" = Formats(__name__, __path__)
"""Every format by its name on the command line."""
