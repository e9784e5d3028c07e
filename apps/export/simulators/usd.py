"""USD physics with PhysX's own schema (Isaac Sim, Isaac Lab): an articulation fixed to the world.

Angles are degrees, and so is what is per angle: speeds [deg/s] and viscous friction [N·m·s/deg]. The joint's axis
is z of both its frames. Torque limits are the maxForce of a drive without stiffness and damping; the friction is
the joint's own. Physics attributes have single precision; what customData tells of them has double. Sources:
openusd.org, UsdPhysics (UsdPhysicsMassAPI; its proposal on units); docs.omniverse.nvidia.com, Physx Joint Schema
(PhysxJointAxisAPI, which takes precedence over PhysxJointAPI); nvidia-omniverse.github.io/PhysX, PhysxJointAxisAPI
(degrees).
"""

import json
import math
import re
from collections.abc import Mapping
from functools import partial

from ....estimation.possible.whole_robot import Labelled, WholeRobot
from ....model import Pose
from ...numbers import exact, principal_axes, quaternion
from ..bodies import indented, prim, schemas, stage
from ..format import Format
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
def _write(whole: WholeRobot) -> str:
    root, base, moved = _identifier(whole.robot.name), _identifier(whole.link_names[0]), moved_links(whole)
    flange, pose_of_flange = flange_of(whole.robot)
    g = gravity_of(whole.robot)
    size = math.hypot(*g)
    scene = [
        f"vector3f physics:gravityDirection = ({exact([x / size for x in g] if size else [0, 0, -1], ', ')})",
        f"float physics:gravityMagnitude = {exact(size)}",
    ]
    links, pose = prim(f'Xform "{base}"', [], [schemas("PhysicsRigidBodyAPI")]), Pose()
    joints = prim('PhysicsFixedJoint "world"', [f"rel physics:body1 = </{root}/{base}>"])
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
            inside += prim(f'Xform "{_identifier(flange)}"', _placed(pose_of_flange))
        marks = [schemas("PhysicsRigidBodyAPI", "PhysicsMassAPI")]
        marks += _custom_data(link.link, link.numbers | link.parameters)
        links += prim(f'Xform "{_identifier(link.link)}"', inside, marks)
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
        applied = schemas(f"PhysicsDriveAPI:{axis}", "PhysxJointAPI", f"PhysxJointAxisAPI:{axis}")
        about = [applied, *_custom_data(each.name, drive)]
        joints += prim(f'Physics{kind}Joint "{_identifier(each.name)}"', lines, about)
    inside = [*links, *prim('Scope "joints"', joints)]
    arm = prim(f'Xform "{root}"', inside, [schemas("PhysicsArticulationRootAPI")])
    return stage(root, "1", [*prim('PhysicsScene "physicsScene"', scene), "", *arm])


def _placed(pose: Pose) -> list[str]:
    return [
        f"double3 xformOp:translate = ({exact(pose.origin, ', ')})",
        f"quatd xformOp:orient = ({exact(quaternion(pose.R), ', ')})",
        'uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient"]',
    ]


def _custom_data(name: str, numbers: Mapping[str, Labelled]) -> list[str]:
    """Marks as metadata of a prim, kept by whatever writes the stage again."""
    lines = [f"string name = {json.dumps(name)}"]
    for key, label in numbers.items():
        text = [f'string {name} = "{word}"' for name, word in fields(label).items() if name != "value"]
        lines += [f"dictionary {key} = {{", *indented([f"double value = {exact(label.value)}", *text]), "}"]
    return ["customData = {", "    dictionary dynident = {", *indented(indented(lines)), "    }", "}"]


def _identifier(name: str) -> str:
    return re.sub(r"^(?=\d)", "_", re.sub(r"\W", "_", name, flags=re.ASCII))
