"""A payload in the format of a controller: one file a format, which is all that a new one needs; or of a simulator.

Every format gives one small text that says frame, reference point, order, units and source of its numbers.
"""

from .. import simulators
from ..format import formats

_OF_SIMULATORS = formats(simulators.__name__, simulators.__path__, "_write_payload")
FORMATS = dict(sorted((formats(__name__, __path__) | _OF_SIMULATORS).items()))  # every format by its name
