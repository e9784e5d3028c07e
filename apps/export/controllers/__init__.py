"""A payload in the format of a controller or of a simulator: one file a format.

Every format gives one small text that says frame, reference point, order, units and source of its numbers. See
``ControllerLoad`` for the body, ``FORMATS`` for what there is.
"""

from . import (
    abb,
    fanuc,
    franka,
    kuka,
    mjcf,
    ros2,
    sdformat,
    staubli,
    universal_robots,
    urdf,
    usd,
    yaskawa,
)
from .form import ControllerFormat
from .load import ControllerLoad
from .payload_file import load_of_document, read_load

_MODULES = (
    abb, kuka, universal_robots, ros2, franka, fanuc, yaskawa, staubli, urdf, sdformat, mjcf, usd,
)  # fmt: skip

FORMATS: dict[str, ControllerFormat] = {module.FORMAT.name: module.FORMAT for module in _MODULES}
"""Every format by its name on the command line."""

__all__ = ["FORMATS", "ControllerFormat", "ControllerLoad", "load_of_document", "read_load"]
