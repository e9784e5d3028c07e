"""OPC UA Robotics ``LoadType``, its variables as JSON.

Mass (AnalogUnit), CenterOfMass (3DFrame: x, y, z of the centre of gravity in the flange frame; A, B, C the
orientation of the principal axes), Inertia (3DVector of principal moments). A turns about x, B about y, C about z,
in the order z, new y, newest x: not as KUKA, whose A turns about z. Sources: OPC 40010-1, 7.23 LoadType and its
table of degrees of modelling; OPC 10000-5, 12.28 3DOrientation; OPC 10000-210, 7.4 (intrinsic z-y'-x'').
"""

import json
from typing import Any

import numpy as np

from ....common.arrays import Array
from .form import ControllerFormat
from .load import ControllerLoad
from .rotation import angles_of


def _write(load: ControllerLoad) -> str:
    moments, axes = load.principal
    angles = angles_of(axes)
    frame = {
        "CartesianCoordinates": {**_vector("XYZ", load.com), "LengthUnit": _unit("MTR", "m")},
        "Orientation": {
            **_vector("ABC", np.degrees([angles.x, angles.y, angles.z])),
            "AngleUnit": _unit("DD", "deg"),
        },
    }
    document: dict[str, Any] = {
        "TypeDefinition": "LoadType",
        "Description": FORMAT.head(load),
        "Mass": {"Value": load.mass, "EngineeringUnits": _unit("KGM", "kg")},
        "CenterOfMass": frame,
    }
    if not load.point_mass:
        document["Inertia"] = {**_vector("XYZ", moments), "VectorUnit": _unit("B32", "kg m^2")}
    return json.dumps(document, indent=2)


def _vector(names: str, values: Array) -> dict[str, float]:
    return {name: float(value) + 0.0 for name, value in zip(names, values, strict=True)}


def _unit(code: str, name: str) -> dict[str, Any]:
    """Unit by its UNECE code, whose letters make up the UnitId (OPC 10000-8, 5.6.3)."""
    return {"UnitId": int.from_bytes(code.encode(), "big"), "DisplayName": name}


FORMAT = ControllerFormat(
    name="opcua",
    title="OPC UA Robotics LoadType",
    reference="principal moments about the centre of mass, their axes turned out of the flange frame by C about z, "
    "B about the new y, A about the newest x",
    order="Mass; CenterOfMass X, Y, Z, A, B, C; Inertia X, Y, Z",
    units="kg, m, deg, kg m^2, told with each variable",
    point_mass="A = B = C = 0 and no Inertia: the specification's 'mass with center of gravity'",
    source="OPC 40010-1, LoadType",
    write=_write,
    comment=None,
    head_inside=True,
)
