"""USD physics: ``PhysicsMassAPI`` on a prim whose origin is the flange, in the stage's units.

Referencing a stage converts nothing; a mass or diagonalInertia of zero is ignored. Source: UsdPhysicsMassAPI in the
OpenUSD documentation (openusd.org/release/api/class_usd_physics_mass_a_p_i.html) and the UsdPhysics proposal on
units.
"""

import math

from ...numbers import principal_axes, quaternion
from ..load import ControllerLoad, listed, load_format, number


def _digits(load: ControllerLoad) -> int | None:
    digits = load.moment_digits
    return None if digits is None else digits + round(2.0 * math.log10(load.meters_per_unit))


def _write(load: ControllerLoad) -> str:
    moments, axes = principal_axes(load.inertia)
    unit = load.meters_per_unit
    lines = [
        f"float physics:mass = {number(load.mass)}",
        f"point3f physics:centerOfMass = ({listed(load.com / unit)})",
    ]
    if not load.point_mass:
        lines += [
            f"float3 physics:diagonalInertia = ({listed(moments / unit**2, _digits(load))})",
            f"quatf physics:principalAxes = ({listed(quaternion(axes))})",
        ]
    body = "\n    ".join(lines)
    return f"""(
    defaultPrim = "payload"
    kilogramsPerUnit = 1
    metersPerUnit = {number(unit)}
    upAxis = "Z"
)

def Xform "payload" (
    prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]
)
{{
    {body}
}}"""


FORMAT = load_format(
    title="USD PhysicsMassAPI (stage units; copy into a stage of the same units)",
    source="OpenUSD, UsdPhysicsMassAPI",
    write=_write,
    holds=frozenset({"products", "units"}),
    reference="principal moments about the centre of mass, their axes turned by principalAxes out of the prim's",
    order="centerOfMass x, y, z; diagonalInertia along the principal axes; principalAxes w, x, y, z",
    units="kg (kilogramsPerUnit = 1), length in metersPerUnit, inertia in kg times that squared",
    in_part="no diagonalInertia: the simulator makes one from the shapes",
    first_line="#usda 1.0",
)
