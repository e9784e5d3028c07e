"""A payload in the format of a controller: one file a format, which is all that a new one needs; or of a simulator.

Every format gives one small text that says frame, reference point, order, units and source of its numbers.
"""

from .. import bodies
from ..format import formats

FORMATS = dict(sorted((formats(__name__, __path__) | bodies.FORMATS).items()))  # every format by its name
