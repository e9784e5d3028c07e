"""Staeubli: plain values in the flange frame.

Its load format is not documented publicly, so nothing is guessed: the numbers stand with their names and units, to
be entered where the controller's own manual asks for them.
"""

import numpy as np

from ..load import ControllerLoad, load_format, number


@load_format(
    title="Staeubli: plain values (its load format is not documented publicly)",
    source="none public; see the manual of your controller",
    order="mass; com x, y, z; Ixx, Ixy, Ixz, Iyy, Iyz, Izz, entries of the matrix (Ixy = -integral of x y dm)",
    in_part="the inertia is left out",
)
def _write(load: ControllerLoad) -> str:
    J = load.inertia
    lines = [f"mass  [kg]      {number(load.mass)}"]
    lines += [f"com {a} [m]       {number(value)}" for a, value in zip("xyz", load.com, strict=True)]
    if not load.point_mass:
        pairs = [(j, k) for j, k in zip(*np.triu_indices(3), strict=True)]
        lines += [f"I{'xyz'[j]}{'xyz'[k]}   [kg.m^2]  {number(J[j, k])}" for j, k in pairs]
    return "\n".join(lines)
