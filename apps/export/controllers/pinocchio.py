"""Pinocchio: an ``Inertia`` in Python.

pin.Inertia(mass, lever, inertia): lever is the centre of mass in the frame, inertia the 3 x 3 matrix about it in
the frame's axes. (The order of its dynamic parameters and of Symmetric3 is another: Ixx, Ixy, Iyy, Ixz, Iyz, Izz.)
Source: Pinocchio, InertiaTpl (include/pinocchio/spatial/inertia.hpp).
"""

from ...numbers import exact
from .form import ControllerFormat
from .load import ControllerLoad


def _write(load: ControllerLoad) -> str:
    rows = ",\n            ".join(f"[{exact(row, ', ')}]" for row in load.inertia)
    return f"""import numpy as np
import pinocchio as pin

payload = pin.Inertia(
    {exact(load.mass)},
    np.array([{exact(load.com, ", ")}]),
    np.array(
        [
            {rows},
        ]
    ),
)
# model.appendBodyToJoint(model.frames[flange].parentJoint, payload, model.frames[flange].placement)"""


FORMAT = ControllerFormat(
    name="pinocchio",
    title="Pinocchio Inertia (Python)",
    reference="inertia matrix about the centre of mass, axes of the flange",
    order="mass, lever x, y, z, 3 x 3 matrix",
    units="kg, m, kg m^2",
    point_mass="the inertia is zero, a point mass",
    source="Pinocchio, InertiaTpl",
    write=_write,
    comment=("# ", ""),
)
