"""USD physics with PhysX's own schema (Isaac Sim, Isaac Lab): an articulation fixed to the world.

Angles are degrees, and so is what is per angle: speeds [deg/s] and viscous friction [N·m·s/deg]. The joint's axis
is z of both its frames. Torque limits are the maxForce of a drive without stiffness and damping; the friction is
the joint's own. Physics attributes have single precision; what customData tells of them has double. A payload is a
prim whose origin is the flange, in the stage's units, for referencing a stage converts nothing; a mass or
diagonalInertia of zero is ignored. Sources: openusd.org, UsdPhysics (UsdPhysicsMassAPI; its proposal on units);
docs.omniverse.nvidia.com, Physx Joint Schema (PhysxJointAxisAPI, which takes precedence over PhysxJointAPI);
nvidia-omniverse.github.io/PhysX, PhysxJointAxisAPI (degrees).
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping
from functools import partial

from .... import estimation
from ....model import Pose
from ...numbers import exact, principal_axes, quaternion
from ..format import Format
from ..load import ControllerLoad, listed, load_format, number
from ..robot import drive_value, fields, flange_of, gravity_of, moved_links


@partial(
    Format,
    title="USD with the physics schema of PhysX (Isaac Sim 5 or newer)",
    source="OpenUSD, UsdPhysics; PhysX, PhysxJointAxisAPI",
    holds=frozenset({"armature", "damping", "friction", "speed", "torque", "gravity"}),
    remarks=(
        "Damping and dry friction stand in PhysxJointAxisAPI (per degree, N·m), which Isaac Sim 4 does not read: "
        "its jointFriction has no unit of torque and is not written. A base without mass gets PhysX's own; it is "
        "fixed to the world, so nothing shows it.",
    ),
    first_line="#usda 1.0",
)
def _write(whole: estimation.WholeRobot) -> str:
    root, base, moved = _identifier(whole.robot.name), _identifier(whole.link_names[0]), moved_links(whole)
    flange, pose_of_flange = flange_of(whole.robot)
    g = gravity_of(whole.robot)
    size = math.hypot(*g)
    scene = [
        f"vector3f physics:gravityDirection = ({exact([x / size for x in g] if size else [0, 0, -1], ', ')})",
        f"float physics:gravityMagnitude = {exact(size)}",
    ]
    links, pose = _prim(f'Xform "{base}"', [], [_schemas("PhysicsRigidBodyAPI")]), Pose()
    joints = _prim('PhysicsFixedJoint "world"', [f"rel physics:body1 = </{root}/{base}>"])
    for each in moved:
        inside, pose, link, joint, drive = list[str](), pose @ each.pose, each.link, each.joint, each.drive
        if (body := link.body).mass != 0.0:
            moments, axes = principal_axes(body.inertia_com)
            inside += [
                f"float physics:mass = {exact(body.mass)}",
                f"point3f physics:centerOfMass = ({exact(body.com, ', ')})",
                f"float3 physics:diagonalInertia = ({exact(moments, ', ')})",
                f"quatf physics:principalAxes = ({exact(quaternion(axes), ', ')})",
            ]
        inside += _placed(pose)
        if each is moved[-1] and flange not in whole.link_names:
            inside += _prim(f'Xform "{_identifier(flange)}"', _placed(pose_of_flange))
        marks = [_schemas("PhysicsRigidBodyAPI", "PhysicsMassAPI")]
        marks += _custom_data(link.link, link.numbers | link.parameters)
        links += _prim(f'Xform "{_identifier(link.link)}"', inside, marks)
        limits, turning = joint.limits, ("Revolute", "angular", math.degrees(1.0))
        kind, axis, unit = turning if joint.revolute else ("Prismatic", "linear", 1.0)
        lines = ['uniform token physics:axis = "Z"']
        for k, (end, place) in enumerate(((each.parent, each.frame), (link.link, each.own.inverse()))):
            lines += [
                f"rel physics:body{k} = </{root}/{_identifier(end)}>",
                f"point3f physics:localPos{k} = ({exact(place.origin, ', ')})",
                f"quatf physics:localRot{k} = ({exact(quaternion(place.R), ', ')})",
            ]
        own = f"physxJointAxis:{axis}"
        numbers = {
            "physics:lowerLimit": limits.position[0] * unit,
            "physics:upperLimit": limits.position[1] * unit,
            f"drive:{axis}:physics:stiffness": 0.0,
            f"drive:{axis}:physics:damping": 0.0,
            f"drive:{axis}:physics:maxForce": limits.torque,
            "physxJoint:maxJointVelocity": limits.speed * unit,
            f"{own}:maxJointVelocity": limits.speed * unit,
        }
        armature, friction, damping = (drive_value(drive, key) for key in ("armature", "friction", "damping"))
        if "armature" in drive:
            numbers |= {"physxJoint:armature": armature, f"{own}:armature": armature}
        if "friction" in drive:
            numbers |= {f"{own}:staticFrictionEffort": friction, f"{own}:dynamicFrictionEffort": friction}
        if "damping" in drive:
            numbers[f"{own}:viscousFrictionCoefficient"] = damping / unit
        lines += [f"float {key} = {exact(value)}" for key, value in numbers.items() if math.isfinite(value)]
        schemas = _schemas(f"PhysicsDriveAPI:{axis}", "PhysxJointAPI", f"PhysxJointAxisAPI:{axis}")
        about = [schemas, *_custom_data(each.name, drive)]
        joints += _prim(f'Physics{kind}Joint "{_identifier(each.name)}"', lines, about)
    inside = [*links, *_prim('Scope "joints"', joints)]
    arm = _prim(f'Xform "{root}"', inside, [_schemas("PhysicsArticulationRootAPI")])
    return _stage(root, "1", [*_prim('PhysicsScene "physicsScene"', scene), "", *arm])


def _stage(root: str, unit: str, prims: Iterable[str]) -> str:
    about = [f'defaultPrim = "{root}"', "kilogramsPerUnit = 1", f"metersPerUnit = {unit}", 'upAxis = "Z"']
    return "\n".join(["(", *_indented(about), ")", "", *prims])


def _prim(kind: str, inside: Iterable[str], metadata: Iterable[str] = ()) -> list[str]:
    return [f"def {kind} (", *_indented(metadata), ")", "{", *_indented(inside), "}"]


def _indented(lines: Iterable[str]) -> list[str]:
    return [f"    {line}" for line in lines]


def _schemas(*names: str) -> str:
    return f"prepend apiSchemas = [{', '.join(map(json.dumps, names))}]"


def _placed(pose: Pose) -> list[str]:
    return [
        f"double3 xformOp:translate = ({exact(pose.origin, ', ')})",
        f"quatd xformOp:orient = ({exact(quaternion(pose.R), ', ')})",
        'uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient"]',
    ]


def _custom_data(name: str, numbers: Mapping[str, estimation.Labelled]) -> list[str]:
    """Marks as metadata of a prim, kept by whatever writes the stage again."""
    lines = [f"string name = {json.dumps(name)}"]
    for key, label in numbers.items():
        text = [f'string {name} = "{word}"' for name, word in fields(label).items() if name != "value"]
        lines += [f"dictionary {key} = {{", *_indented([f"double value = {exact(label.value)}", *text]), "}"]
    return ["customData = {", "    dictionary dynident = {", *_indented(_indented(lines)), "    }", "}"]


def _identifier(name: str) -> str:
    return re.sub(r"^(?=\d)", "_", re.sub(r"\W", "_", name, flags=re.ASCII))


@load_format(
    title="USD PhysicsMassAPI (stage units; copy into a stage of the same units)",
    source="OpenUSD, UsdPhysicsMassAPI",
    holds=frozenset({"products", "units"}),
    reference="principal moments about the centre of mass, their axes turned by principalAxes out of the prim's",
    order="centerOfMass x, y, z; diagonalInertia along the principal axes; principalAxes w, x, y, z",
    units="kg (kilogramsPerUnit = 1), length in metersPerUnit, inertia in kg times that squared",
    in_part="no diagonalInertia: the simulator makes one from the shapes",
    first_line="#usda 1.0",
)
def _write_payload(load: ControllerLoad) -> str:
    (moments, axes), unit, digits = principal_axes(load.inertia), load.meters_per_unit, load.moment_digits
    digits = None if digits is None else digits + round(2.0 * math.log10(unit))
    lines = [
        f"float physics:mass = {number(load.mass)}",
        f"point3f physics:centerOfMass = ({listed(load.com / unit)})",
        f"float3 physics:diagonalInertia = ({listed(moments / unit**2, digits)})",
        f"quatf physics:principalAxes = ({listed(quaternion(axes))})",
    ]
    schemas = _schemas("PhysicsRigidBodyAPI", "PhysicsMassAPI")
    payload = _prim('Xform "payload"', lines[: 2 if load.point_mass else 4], [schemas])
    return _stage("payload", number(unit), payload)
