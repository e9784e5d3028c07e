"""A payload in the format of a controller: one file a format, which is all that a new one needs; or of a simulator.

Every format gives one small text that says frame, reference point, order, units and source of its numbers.
"""

from ...extras import modules
from ..format import Format
from ..load import SIMULATORS, ControllerLoad

_MAKERS = {name: module._write for name, module in modules(__name__, __path__).items()}
FORMATS: dict[str, Format[ControllerLoad]] = dict(
    sorted((_MAKERS | SIMULATORS).items())
)  # every format by its name
