"""A payload in the format of a controller or of a simulator: one file a format, which is all that a new one needs.

Every format gives one small text that says frame, reference point, order, units and source of its numbers.
"""

from ..format import formats

FORMATS = formats(__name__, __path__)  # every format by its name on the command line
