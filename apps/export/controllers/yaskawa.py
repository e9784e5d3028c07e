"""Yaskawa Motoman tool load information, as typed at the pendant (tool file).

W [kg]; Xg, Yg, Zg [mm] in flange coordinates; Ix, Iy, Iz [kg m^2] about axes through the centre of gravity
parallel to the flange's. Sources: NX100 instructions 9.11 "ARM Control"
(easymanua.ls/yaskawa/motoman-nx100/manual?p=259) and YRC1000 (easymanua.ls/yaskawa/motoman-yrc1000/manual?p=119).
"""

import numpy as np

from .form import ControllerFormat, number
from .load import ControllerLoad


def _write(load: ControllerLoad) -> str:
    moments = np.diag(load.inertia)
    return "\n".join(
        [
            f"W   [kg]     {number(load.mass)}",
            *(f"{a}g  [mm]     {number(1e3 * value)}" for a, value in zip("XYZ", load.com, strict=True)),
            *(f"I{a}  [kg.m^2] {number(value)}" for a, value in zip("xyz", moments, strict=True)),
        ]
    )


FORMAT = ControllerFormat(
    name="yaskawa",
    title="Yaskawa tool load information",
    reference="moments about axes through the centre of gravity parallel to the flange's x, y, z",
    order="W, Xg, Yg, Zg, Ix, Iy, Iz",
    units="kg, mm, kg m^2",
    point_mass="Ix = Iy = Iz = 0, which the manual allows for tools that are small against their distance",
    source="NX100 and YRC1000 instructions, ARM control",
    write=_write,
    comment=("# ", ""),
    loses_products=True,
)
