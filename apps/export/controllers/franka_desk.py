"""Franka Desk: ``endeffector-config.json`` of an end-effector archive.

mass [kg], centerOfMass [m] and inertia [kg m^2] (nine entries, column by column) in the flange frame;
transformation: the end-effector frame in the flange's, 4 x 4 column by column, here the flange's own. JSON has no
comments and the file no place for a text: what must be said is told beside it. Source: Franka RIDE documentation,
"End effector commissioning" (download.franka.de/ride-cli-doc-v1.1.1/end_effector_commissioning.html).
"""

import json

import numpy as np

from .form import ControllerFormat
from .load import ControllerLoad


def _write(load: ControllerLoad) -> str:
    document = {
        "id": "dynident-payload",
        "name": "dynident payload",
        "color": "#808080",
        "mass": load.mass,
        "centerOfMass": load.com.tolist(),
        "transformation": np.eye(4).ravel(order="F").tolist(),
        "inertia": load.inertia.ravel(order="F").tolist(),
    }
    return json.dumps(document, indent=2)


FORMAT = ControllerFormat(
    name="franka-desk",
    title="Franka Desk endeffector-config.json (set your tool's transformation)",
    reference="inertia matrix about the centre of mass, axes of the flange",
    order="centerOfMass x, y, z; inertia and transformation column by column",
    units="kg, m, kg m^2",
    point_mass="the inertia is zero, a point mass",
    source="Franka RIDE documentation, End effector commissioning",
    write=_write,
    comment=None,
)
