"""Universal Robots: ``set_target_payload`` of URScript.

Components beyond +-133 kg m^2 and negative moments raise an exception. Source: URScript manual, set_target_payload
(universal-robots.com/manuals/EN/HTML/SW10_6/Content/prod-scriptmanual/G5/set_target_payload.htm).
"""

import numpy as np

from ....common import Array, InputError
from ...numbers import ENTRIES
from ..load import ControllerLoad, listed, load_format, number

_MOST = 133.0  # kg m^2, of each component


@load_format(
    title="Universal Robots set_target_payload",
    source="URScript manual, set_target_payload",
    reference="inertia matrix about the centre of gravity, axes of the tool flange",
    order="m, [cog x, y, z], [Ixx, Iyy, Izz, Ixy, Ixz, Iyz], entries of the matrix (Ixy = -integral of x y dm)",
    in_part="the inertia is left out, the controller takes zero",
)
def _write(load: ControllerLoad) -> str:
    inertia = "" if load.point_mass else f", [{listed(components(load))}]"
    return f"set_target_payload({number(load.mass)}, [{listed(load.com)}]{inertia})"


def components(load: ControllerLoad) -> Array:
    """Six components of the inertia, of which the controller raises an exception for those that are too large."""
    if (worst := float(np.abs(load.inertia).max())) > _MOST:
        raise InputError(f"the inertia reaches {worst:.4g} kg m^2; set_target_payload refuses more than {_MOST:g}")
    return np.asarray(load.inertia[ENTRIES])
