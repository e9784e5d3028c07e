"""Fanuc MOTION/PAYLOAD SET, as typed at the pendant; older screens print the mass in kgf: the same number.

Source: public copies of the HandlingTool manual's "Setting payload" (mass and centre), such as
ch-delivery.lincolnelectric.com/api/public/content/67cd62debb004088957ebe41ecebc9c1.
"""

import numpy as np

from ..load import ControllerLoad, load_format, number

KGF_CM_S2 = 9.80665 * 1e-2
"""One kgf cm s^2 in kg m^2: 9.80665 N times 0.01 m times s^2."""


@load_format(
    title="Fanuc MOTION/PAYLOAD SET",
    source="HandlingTool manual, Setting payload",
    holds=frozenset(),
    reference="moments about axes through the centre of gravity parallel to the faceplate's x, y, z",
    order="PAYLOAD, PAYLOAD CENTER X, Y, Z, PAYLOAD INERTIA X, Y, Z",
    units="kg (or kgf, the same number), cm, kgf cm s^2 (1 of them is 0.0980665 kg m^2)",
    in_part="PAYLOAD INERTIA = 0, a point mass",
)
def _write(load: ControllerLoad) -> str:
    centre = zip("XYZ", 100.0 * load.com, strict=True)
    moments = zip("XYZ", np.diag(load.inertia) / KGF_CM_S2, strict=True)
    lines = [f"PAYLOAD           [kg]        {number(load.mass)}"]
    lines += [f"PAYLOAD CENTER {axis}  [cm]        {number(value)}" for axis, value in centre]
    lines += [f"PAYLOAD INERTIA {axis} [kgfcms^2]  {number(value, load.moment_digits)}" for axis, value in moments]
    return "\n".join(lines)
