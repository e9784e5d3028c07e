"""A payload in the format of a controller or of a simulator: one file a format.

Every format gives one small text that says frame, reference point, order, units and source of its numbers. See
``ControllerLoad`` for the body, ``FORMATS`` for what there is.
"""

from . import abb, fanuc, franka, kuka, mjcf, sdformat, staubli, universal_robots, urdf, usd, yaskawa
from .form import ControllerFormat
from .load import ControllerLoad, load_of, read_load

_FORMATS = (
    abb.FORMAT, kuka.FORMAT, universal_robots.FORMAT, universal_robots.ROS2, franka.FORMAT, fanuc.FORMAT,
    yaskawa.FORMAT, staubli.FORMAT, urdf.FORMAT, sdformat.FORMAT, mjcf.FORMAT, usd.FORMAT,
)  # fmt: skip
FORMATS: dict[str, ControllerFormat] = {form.name: form for form in _FORMATS}
"""Every format by its name on the command line."""

__all__ = ["FORMATS", "ControllerFormat", "ControllerLoad", "load_of", "read_load"]
