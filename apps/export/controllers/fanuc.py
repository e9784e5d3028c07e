"""Fanuc MOTION/PAYLOAD SET, as typed at the pendant.

PAYLOAD [kg]; PAYLOAD CENTER X, Y, Z [cm] from the centre of the faceplate; PAYLOAD INERTIA X, Y, Z [kgf cm s^2]:
moments about axes through the centre of gravity parallel to the faceplate's. 1 kgf cm s^2 = 0.0980665 kg m^2.
Older screens print the mass in kgf: the same number. Source: public copies of the HandlingTool manual's "Setting
payload", such as ch-delivery.lincolnelectric.com/api/public/content/67cd62debb004088957ebe41ecebc9c1 (mass and
centre).
"""

import numpy as np

from .form import ControllerFormat, moment_digits, number
from .load import ControllerLoad

KGF_CM_S2 = 9.80665 * 1e-2
"""One kgf cm s^2 in kg m^2: 9.80665 N times 0.01 m times s^2."""


def _write(load: ControllerLoad) -> str:
    inertia = np.diag(load.inertia) / KGF_CM_S2
    return "\n".join(
        [
            f"PAYLOAD           [kg]        {number(load.mass)}",
            *(f"PAYLOAD CENTER {a}  [cm]        {number(100.0 * v)}" for a, v in zip("XYZ", load.com, strict=True)),
            *(
                f"PAYLOAD INERTIA {a} [kgfcms^2]  {number(v, moment_digits(load))}"
                for a, v in zip("XYZ", inertia, strict=True)
            ),
        ]
    )


FORMAT = ControllerFormat(
    name="fanuc",
    title="Fanuc MOTION/PAYLOAD SET",
    reference="moments about axes through the centre of gravity parallel to the faceplate's x, y, z",
    order="PAYLOAD, PAYLOAD CENTER X, Y, Z, PAYLOAD INERTIA X, Y, Z",
    units="kg (or kgf, the same number), cm, kgf cm s^2 (1 of them is 0.0980665 kg m^2)",
    point_mass="PAYLOAD INERTIA = 0, a point mass",
    source="HandlingTool manual, Setting payload",
    write=_write,
    comment=("# ", ""),
    loses_products=True,
)
