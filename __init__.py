"""dynident: what hangs on the flange of an industrial manipulator.

Identifies the inertial parameters of a robot and of its payload from recordings of the joints, and says how
far each number can be trusted. The rooms: ``dynident.model`` (the robot and its dynamics),
``dynident.estimation`` (recordings to parameters), ``dynident.trajectories`` (motions and simulation). The
names in ``dir(dynident)`` are the short way to what most scripts need; they are imported on first use.
"""

from importlib import import_module

from .common.lazy import attach
from .common.speech import Speaks as _Speaks

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = attach(__name__, __file__)
# The room that shows results is imported when one is first asked to show itself.
_Speaks.shown_by = lambda: import_module(".apps.report.speech", __name__)
