"""USD physics with PhysX's own schema (Isaac Sim, Isaac Lab): an articulation fixed to the world.

Angles are degrees, and so is what is per angle: speeds [deg/s] and viscous friction [N·m·s/deg]. The joint's axis
is z of both its frames. Torque limits are the maxForce of a drive without stiffness and damping; the friction is
the joint's own. Physics attributes have single precision; what customData tells of them has double. Sources:
openusd.org, UsdPhysics; docs.omniverse.nvidia.com, Physx Joint Schema (PhysxJointAxisAPI, which takes precedence
over PhysxJointAPI); nvidia-omniverse.github.io/PhysX, PhysxJointAxisAPI (degrees).
"""

import json
import math
import re
from collections.abc import Iterable, Mapping

from ....estimation.possible.whole_robot import Labelled, WholeRobot
from ....model import Pose
from ...numbers import exact
from ..format import Format
from ..robot import Frames, drive_value, fields, link_marks, robot_head
from ..rotation import principal_axes, quaternion


def _write(whole: WholeRobot) -> str:
    root, joints = _identifier(whole.robot.name), range(whole.robot.n)
    base = _identifier(whole.link_names[0])
    frames = Frames(whole.robot)
    g = frames.gravity
    size = math.hypot(*g)
    scene = [
        f"vector3f physics:gravityDirection = ({exact([x / size for x in g] if size else [0, 0, -1], ', ')})",
        f"float physics:gravityMagnitude = {exact(size)}",
    ]
    links = _prim(f'Xform "{base}"', [], [_schemas("PhysicsRigidBodyAPI")])
    pose, flange = Pose(), frames.flange_name
    for j, link in enumerate(whole.links):
        inside, pose = list[str](), pose @ frames.link(j)
        if (body := link.body).mass != 0.0:
            moments, axes = principal_axes(body.inertia_com)
            inside += [
                f"float physics:mass = {exact(body.mass)}",
                f"point3f physics:centerOfMass = ({exact(body.com, ', ')})",
                f"float3 physics:diagonalInertia = ({exact(moments, ', ')})",
                f"quatf physics:principalAxes = ({exact(quaternion(axes), ', ')})",
            ]
        inside += _placed(pose)
        if j == whole.robot.n - 1 and flange not in whole.link_names:
            inside += _prim(f'Xform "{_identifier(flange)}"', _placed(frames.flange))
        marks = [_schemas("PhysicsRigidBodyAPI", "PhysicsMassAPI"), *_custom_data(link.link, link_marks(link, {}))]
        links += _prim(f'Xform "{_identifier(link.link)}"', inside, marks)
    held = _prim('PhysicsFixedJoint "world"', [f"rel physics:body1 = </{root}/{base}>"])
    moving = [line for j in joints for line in _joint(whole, j, root)]
    lines = [
        "(",
        *_indented([f'defaultPrim = "{root}"', "kilogramsPerUnit = 1", "metersPerUnit = 1", 'upAxis = "Z"']),
        ")",
        "",
        *_prim('PhysicsScene "physicsScene"', scene),
        "",
        *_prim(
            f'Xform "{root}"',
            [*links, *_prim('Scope "joints"', [*held, *moving])],
            [_schemas("PhysicsArticulationRootAPI")],
        ),
    ]
    return "\n".join(lines)


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


def _joint(whole: WholeRobot, j: int, root: str) -> list[str]:
    robot, name, drive = whole.robot, whole.joint_names[j], whole.apart[j]
    joint, limits = robot.joints[j], robot.joints[j].limits
    kind, axis, unit = (
        ("Revolute", "angular", math.degrees(1.0)) if joint.revolute else ("Prismatic", "linear", 1.0)
    )
    lines = ['uniform token physics:axis = "Z"']
    frames = Frames(robot)
    ends = frames.joint(j), frames.own(j + 1).inverse()
    for k, (link, pose) in enumerate(zip(whole.link_names[j : j + 2], ends, strict=True)):
        lines += [
            f"rel physics:body{k} = </{root}/{_identifier(link)}>",
            f"point3f physics:localPos{k} = ({exact(pose.origin, ', ')})",
            f"quatf physics:localRot{k} = ({exact(quaternion(pose.R), ', ')})",
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
    return _prim(f'Physics{kind}Joint "{_identifier(name)}"', lines, [schemas, *_custom_data(name, drive)])


def _custom_data(name: str, numbers: Mapping[str, Labelled]) -> list[str]:
    """Marks as metadata of a prim, kept by whatever writes the stage again."""
    lines = [f"string name = {json.dumps(name)}"]
    for key, label in numbers.items():
        text = [f'string {name} = "{word}"' for name, word in fields(label).items() if name != "value"]
        entries = [f"double value = {exact(label.value)}", *text]
        lines += [f"dictionary {key} = {{", *_indented(entries), "}"]
    return ["customData = {", "    dictionary dynident = {", *_indented(_indented(lines)), "    }", "}"]


def _identifier(name: str) -> str:
    return re.sub(r"^(?=\d)", "_", re.sub(r"\W", "_", name, flags=re.ASCII))


FORMAT = Format(
    title="USD with the physics schema of PhysX (Isaac Sim 5 or newer)",
    source="OpenUSD, UsdPhysics; PhysX, PhysxJointAxisAPI",
    head=robot_head,
    write=_write,
    holds=frozenset({"armature", "damping", "friction", "speed", "torque", "gravity"}),
    remarks=(
        "Damping and dry friction stand in PhysxJointAxisAPI (per degree, N·m), which Isaac Sim 4 does not read: "
        "its jointFriction has no unit of torque and is not written. A base without mass gets PhysX's own; it is "
        "fixed to the world, so nothing shows it.",
    ),
    first_line="#usda 1.0",
)
