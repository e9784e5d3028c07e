"""A whole robot in the format of a simulator: one file a format.

Every number says who decided it (data, rule or prior) and how sure it is, in comments and in what a simulator keeps
when it writes the model again; what a format has no place for is said. See ``FORMATS`` for what there is.
"""

from . import mjcf, sdf, urdf, usd
from .form import SimulatorFormat, stored_whole_robot
from .into import Changed, into

FORMATS: dict[str, SimulatorFormat] = {module.FORMAT.name: module.FORMAT for module in (mjcf, usd, urdf, sdf)}
"""Every format by its name on the command line."""

__all__ = ["FORMATS", "Changed", "SimulatorFormat", "into", "stored_whole_robot"]
