"""Yaskawa Motoman tool load information, as typed at the pendant (tool file).

Sources: NX100 instructions 9.11 "ARM Control" (easymanua.ls/yaskawa/motoman-nx100/manual?p=259) and YRC1000
(easymanua.ls/yaskawa/motoman-yrc1000/manual?p=119).
"""

import numpy as np

from ..load import ControllerLoad, load_format, number


@load_format(
    title="Yaskawa tool load information",
    source="NX100 and YRC1000 instructions, ARM control",
    holds=frozenset(),
    reference="moments about axes through the centre of gravity parallel to the flange's x, y, z",
    order="W, Xg, Yg, Zg, Ix, Iy, Iz",
    units="kg, mm, kg m^2",
    in_part="Ix = Iy = Iz = 0, which the manual allows for tools that are small against their distance",
)
def _write(load: ControllerLoad) -> str:
    lines = [f"W   [kg]     {number(load.mass)}"]
    lines += [f"{axis}g  [mm]     {number(value)}" for axis, value in zip("XYZ", 1e3 * load.com, strict=True)]
    moments = zip("xyz", np.diag(load.inertia), strict=True)
    return "\n".join([*lines, *(f"I{axis}  [kg.m^2] {number(value)}" for axis, value in moments)])
