"""USD physics: ``PhysicsMassAPI`` on a prim whose origin is the flange.

mass, centerOfMass (prim's local space), diagonalInertia (principal moments about the centre of mass),
principalAxes (quaternion, scalar first), all in the stage's units: lengths divided by metersPerUnit, inertia by
its square. Referencing a stage converts nothing. A mass or diagonalInertia of zero is ignored. Source:
UsdPhysicsMassAPI in the OpenUSD documentation (openusd.org/release/api/class_usd_physics_mass_a_p_i.html) and the
UsdPhysics proposal on units.
"""

import math

from .form import ControllerFormat, moment_digits, number, numbers
from .load import ControllerLoad
from .rotation import quaternion


def _digits(load: ControllerLoad) -> int | None:
    """Decimals of a moment in the stage's units."""
    digits = moment_digits(load)
    return None if digits is None else digits + round(2.0 * math.log10(load.meters_per_unit))


def _write(load: ControllerLoad) -> str:
    moments, axes = load.principal
    unit = load.meters_per_unit
    lines = [
        f"float physics:mass = {number(load.mass)}",
        f"point3f physics:centerOfMass = ({numbers(load.com / unit)})",
    ]
    if not load.point_mass:
        lines += [
            f"float3 physics:diagonalInertia = ({numbers(moments / unit**2, _digits(load))})",
            f"quatf physics:principalAxes = ({numbers(quaternion(axes))})",
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


FORMAT = ControllerFormat(
    name="usd",
    title="USD PhysicsMassAPI (stage units; copy into a stage of the same units)",
    reference="principal moments about the centre of mass, their axes turned by principalAxes out of the prim's",
    order="centerOfMass x, y, z; diagonalInertia along the principal axes; principalAxes w, x, y, z",
    units="kg (kilogramsPerUnit = 1), length in metersPerUnit, inertia in kg times that squared",
    point_mass="no diagonalInertia: the simulator makes one from the shapes",
    source="OpenUSD, UsdPhysicsMassAPI",
    write=_write,
    comment=("# ", ""),
    first_line="#usda 1.0",
    own_units=True,
)
