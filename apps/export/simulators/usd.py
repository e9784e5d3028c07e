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
from collections.abc import Iterator, Mapping

from ....common.arrays import Array
from ....estimation.possible.whole_robot import Labelled, WholeRobot
from ....model import InertialParameters, Pose
from ...numbers import exact
from ..controllers.rotation import principal_axes, quaternion
from .form import (
    SimulatorFormat,
    drive_value,
    fields,
    flange_name,
    flange_pose,
    gravity_in_base,
    in_parent,
    joint_in_parent,
    link_marks,
    own_frame,
    plain,
)


def _write(whole: WholeRobot, head: list[str]) -> str:
    root = _identifier(whole.robot.name)
    g = gravity_in_base(whole.robot)
    size = math.hypot(*g)
    down = [value / size for value in g] if size else [0.0, 0.0, -1.0]
    lines = [
        "#usda 1.0",
        "(",
        f'    defaultPrim = "{root}"',
        "    kilogramsPerUnit = 1",
        "    metersPerUnit = 1",
        '    upAxis = "Z"',
        ")",
        *(f"# {plain(line)}" for line in head),
        "",
        'def PhysicsScene "physicsScene"',
        "{",
        f"    vector3f physics:gravityDirection = ({_list(down)})",
        f"    float physics:gravityMagnitude = {exact(size)}",
        "}",
        "",
        f'def Xform "{root}" (',
        '    prepend apiSchemas = ["PhysicsArticulationRootAPI"]',
        ")",
        "{",
        *_indented(_links(whole)),
        '    def Scope "joints"',
        "    {",
        *_indented(_indented(_joints(whole, f"/{root}"))),
        "    }",
        "}",
    ]
    return "\n".join(lines) + "\n"


def _indented(lines: Iterator[str]) -> Iterator[str]:
    yield from (f"    {line}" for line in lines)


def _links(whole: WholeRobot) -> Iterator[str]:
    base, *names = whole.link_names
    yield from (
        f'def Xform "{_identifier(base)}" (',
        '    prepend apiSchemas = ["PhysicsRigidBodyAPI"]',
        ")",
        "{",
        "}",
    )
    pose = Pose()
    for j, (name, link) in enumerate(zip(names, whole.links, strict=True)):
        pose = pose @ in_parent(whole.robot, j)
        yield f'def Xform "{_identifier(name)}" ('
        yield '    prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]'
        yield from _indented(_custom_data(name, link_marks(link, {})))
        yield ")"
        yield "{"
        yield from _indented(_mass(link.body))
        yield from _placed(pose)
        if j == whole.robot.n - 1:
            yield from _indented(_flange(whole))
        yield "}"


def _mass(body: InertialParameters) -> Iterator[str]:
    if body.mass == 0.0:
        return
    moments, axes = principal_axes(body.inertia_com)
    yield f"float physics:mass = {exact(body.mass)}"
    yield f"point3f physics:centerOfMass = ({_list(body.com)})"
    yield f"float3 physics:diagonalInertia = ({_list(moments)})"
    yield f"quatf physics:principalAxes = ({_list(quaternion(axes))})"


def _flange(whole: WholeRobot) -> Iterator[str]:
    pose, name = flange_pose(whole.robot), flange_name(whole.robot)
    if name in whole.link_names:
        return
    yield f'def Xform "{_identifier(name)}"'
    yield "{"
    yield from _placed(pose)
    yield "}"


def _placed(pose: Pose) -> Iterator[str]:
    """Where a prim stands in the one above it."""
    yield f"    double3 xformOp:translate = ({_list(pose.origin)})"
    yield f"    quatd xformOp:orient = ({_list(quaternion(pose.R))})"
    yield '    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient"]'


def _joints(whole: WholeRobot, root: str) -> Iterator[str]:
    base = f"{root}/{_identifier(whole.link_names[0])}"
    yield from ('def PhysicsFixedJoint "world"', "{", f"    rel physics:body1 = <{base}>", "}")
    for j in range(whole.robot.n):
        yield from _joint(whole, j, root)


def _joint(whole: WholeRobot, j: int, root: str) -> Iterator[str]:
    robot, name, drive = whole.robot, whole.joint_names[j], whole.apart[j]
    joint, limits = robot.joints[j], robot.joints[j].limits
    kind, axis, unit = (
        ("Revolute", "angular", math.degrees(1.0)) if joint.revolute else ("Prismatic", "linear", 1.0)
    )
    parent, child = (f"{root}/{_identifier(link)}" for link in whole.link_names[j : j + 2])
    here, there = joint_in_parent(robot, j), own_frame(robot, j + 1).inverse()
    schemas = f'"PhysicsDriveAPI:{axis}", "PhysxJointAPI", "PhysxJointAxisAPI:{axis}"'
    yield f'def Physics{kind}Joint "{_identifier(name)}" ('
    yield f"    prepend apiSchemas = [{schemas}]"
    yield from _indented(_custom_data(name, drive))
    yield ")"
    yield "{"
    yield '    uniform token physics:axis = "Z"'
    yield f"    rel physics:body0 = <{parent}>"
    yield f"    rel physics:body1 = <{child}>"
    for k, pose in enumerate((here, there)):
        yield f"    point3f physics:localPos{k} = ({_list(pose.origin)})"
        yield f"    quatf physics:localRot{k} = ({_list(quaternion(pose.R))})"
    numbers = {
        "physics:lowerLimit": limits.position[0] * unit,
        "physics:upperLimit": limits.position[1] * unit,
        f"drive:{axis}:physics:stiffness": 0.0,
        f"drive:{axis}:physics:damping": 0.0,
        f"drive:{axis}:physics:maxForce": limits.torque,
        "physxJoint:maxJointVelocity": limits.speed * unit,
        f"physxJointAxis:{axis}:maxJointVelocity": limits.speed * unit,
    } | _drive(drive, axis, unit)
    yield from (f"    float {key} = {exact(value)}" for key, value in numbers.items() if math.isfinite(value))
    yield "}"


def _drive(drive: Mapping[str, Labelled], axis: str, unit: float) -> dict[str, float]:
    """Attributes of a joint for its drive, as far as it is known; ``unit``: degrees a radian, 1 for metres."""
    values: dict[str, float] = {}
    if "armature" in drive:
        values |= dict.fromkeys(
            ("physxJoint:armature", f"physxJointAxis:{axis}:armature"), drive_value(drive, "armature")
        )
    if "friction" in drive:
        names = (f"physxJointAxis:{axis}:{kind}FrictionEffort" for kind in ("static", "dynamic"))
        values |= dict.fromkeys(names, drive_value(drive, "friction"))
    if "damping" in drive:
        values[f"physxJointAxis:{axis}:viscousFrictionCoefficient"] = drive_value(drive, "damping") / unit
    return values


def _custom_data(name: str, numbers: Mapping[str, Labelled]) -> Iterator[str]:
    """Marks as metadata of a prim, kept by whatever writes the stage again."""
    yield "customData = {"
    yield "    dictionary dynident = {"
    yield f"        string name = {json.dumps(name)}"
    for key, label in numbers.items():
        yield f"        dictionary {key} = {{"
        yield f"            double value = {exact(label.value)}"
        words = {name: word for name, word in fields(label).items() if name != "value"}
        yield from (f'            string {name} = "{word}"' for name, word in words.items())
        yield "        }"
    yield "    }"
    yield "}"


def _identifier(name: str) -> str:
    """A name as prims may have it."""
    return re.sub(r"^(?=\d)", "_", re.sub(r"\W", "_", name, flags=re.ASCII))


def _list(values: "Array | tuple[float, ...] | list[float]") -> str:
    return exact(values, ", ")


FORMAT = SimulatorFormat(
    name="usd",
    title="USD with the physics schema of PhysX (Isaac Sim 5 or newer)",
    ending="usda",
    holds=frozenset({"armature", "damping", "friction", "speed", "torque", "gravity"}),
    write=_write,
    remarks=(
        "Damping and dry friction stand in PhysxJointAxisAPI (per degree, N·m), which Isaac Sim 4 does not read: "
        "its jointFriction has no unit of torque and is not written. A base without mass gets PhysX's own; it is "
        "fixed to the world, so nothing shows it.",
    ),
)
