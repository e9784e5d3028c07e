"""A whole robot in the formats of simulators.

Every number of a robot says who decided it (data, rule or prior) and how sure it is, in comments and in what a
simulator keeps when it writes the model again; what a format has no place for is said.

MJCF (MuJoCo): all that a robot's description has, but for tables of springs. A joint's armature, damping and
frictionloss are its drive's; a coupled drive is a fixed tendon over both joints with its own; an offset is the bias
of the joint's actuator, whose control is the motor's torque; a spring between two pivots is a spatial tendon
between two sites. fullinertia is M11, M22, M33, M12, M13, M23 about pos in the axes of the body, positive definite
with principal moments that fulfil A + B >= C. Source: MuJoCo documentation, XML reference.

URDF: links, joints, limits, damping and dry friction; what Drake reads beside it holds the armature. A robot keeps
the link frames of its own file. Sources: wiki.ros.org/urdf/XML; wiki.ros.org/urdf/Tutorials (inertia, sign of
products); drake.mit.edu, Parsing models (drake:rotor_inertia of an actuator with the gear ratio 1 is the inertia on
the joint's side, drake:acceleration).

SDFormat (Gazebo, Drake): as URDF, the links in one model that is fixed to the world. Poses are relative to the
parent link, axes stand in the child's frame, which is the joint's. Sources: sdformat.org/spec, link/inertial
(element descriptions in sdf/1.x/inertial.sdf); gz-math, Inertial; drake.mit.edu, Parsing models
(drake:rotor_inertia, drake:gear_ratio, drake:acceleration).

USD physics with PhysX's own schema (Isaac Sim, Isaac Lab): an articulation fixed to the world. Angles are degrees,
and so is what is per angle: speeds [deg/s] and viscous friction [N·m·s/deg]. The joint's axis is z of both its
frames. Torque limits are the maxForce of a drive without stiffness and damping; the friction is the joint's own.
Physics attributes have single precision; what customData tells of them has double. Sources: openusd.org, UsdPhysics
(UsdPhysicsMassAPI; its proposal on units); docs.omniverse.nvidia.com, Physx Joint Schema (PhysxJointAxisAPI, which
takes precedence over PhysxJointAPI); nvidia-omniverse.github.io/PhysX, PhysxJointAxisAPI (degrees).
"""

import json
import math
import re
from collections import defaultdict
from collections.abc import Mapping
from functools import partial
from xml.etree.ElementTree import Element

from ...estimation.possible.whole_robot import Labelled, WholeRobot
from ...model import Pose
from ..numbers import exact, principal_axes, quaternion
from .format import DYNIDENT, FIRST, Format, element, texts
from .load import ends, indented, mjcf_inertial, prim, schemas, sdf_inertial, stage, urdf_inertial
from .robot import drive_attributes, drive_value, fields, flange_of, gravity_of, moved_links, robot_head

robot_format = partial(Format[WholeRobot], head=robot_head, first_line=FIRST)
"""Makes a function the format of a robot."""
DRIVE = {"armature": "armature", "damping": "damping", "friction": "frictionloss"}
"""Attributes of a joint or a tendon in MJCF for its drive."""
_UNKNOWN = 1e6  # URDF demands numbers for limits: this stands for none


@partial(
    robot_format,
    title="MJCF (MuJoCo 3.3 or newer)",
    source="MuJoCo XML reference",
    holds=frozenset({"armature", "damping", "friction", "offset", "coupled", "spring", "torque", "gravity"}),
    remarks=(
        "Controls are motor torques on the joint side, with the torque limits as their range; torque offsets are "
        "the actuators' bias.",
    ),
)
def _mjcf(whole: WholeRobot) -> Element:
    spring, flange = whole.robot.spring, flange_of(whole.robot)
    tendons, motors = coupled_tendon(whole, whole.joint_names), list[Element]()
    moved, sites = moved_links(whole, apart=False), defaultdict[int, list[Element]](list)  # of links, 0: the base
    if spring is not None and not spring.table:
        values = {"name": "spring", "stiffness": exact(spring.stiffness), "springlength": exact(spring.length)}
        both = (element("site", {"site": f"spring_{end}"}) for end in ("fixed", "moving"))
        tendons.append(element("spatial", values, *both))
        # The moving pivot stands in the joint's frame, the fixed one in that frame at q = 0. Their angle about the
        # axis is q - zero - pi, so that L^2 = a^2 + b^2 + 2 a b cos(q - zero).
        (a, b), each = spring.arms, moved[spring.joint - 1]
        pivots = (
            ("spring_fixed", each.frame, [-b * math.cos(spring.zero), -b * math.sin(spring.zero), 0.0]),
            ("spring_moving", each.own.inverse(), [a, 0.0, 0.0]),
        )
        for link, (name, pose, pivot) in enumerate(pivots, spring.joint - 1):
            sites[link].append(element("site", {"name": name, "pos": exact(pose.R @ pivot + pose.p)}))
    base = outer = element("body", {"name": whole.link_names[0]}, *sites[0])
    for j, each in enumerate(moved, 1):
        body, limits, drive = each.link.body, each.joint.limits, each.drive
        joint = {"name": each.name, "type": "hinge" if each.joint.revolute else "slide", "axis": each.axis}
        if all(map(math.isfinite, limits.position)):
            joint["range"] = exact(limits.position)
        inner = element(
            "body", {"name": each.link.link} | _mjcf_pose(each.pose),
            each.comment(),
            mjcf_inertial(body.mass, body.com, body.inertia_com),
            element("joint", joint | drive_attributes(drive, DRIVE)),
            *sites[j],
        )  # fmt: skip
        outer.append(inner)
        outer = inner
        values = {"name": each.name, "joint": each.name}  # the control is the torque on the joint's side
        if math.isfinite(limits.torque):
            values["ctrlrange"] = exact([-limits.torque, limits.torque])
        if "offset" in drive:  # the bias takes the offset off
            values |= {"biastype": "affine", "biasprm": exact([-drive["offset"].value, 0.0, 0.0])}
        motors.append(element("general", values))
    outer.append(element("site", {"name": flange[0]} | _mjcf_pose(flange[1])))
    return element(
        "mujoco",
        {"model": whole.robot.name},
        element("compiler", {"angle": "radian", "autolimits": "true"}),
        element("option", {"gravity": exact(gravity_of(whole.robot))}),
        custom(whole),
        element("worldbody", {}, base),
        *([element("tendon", {}, *tendons)] if tendons else []),
        element("actuator", {}, *motors),
    )


def custom(whole: WholeRobot) -> Element:
    """Marks as texts that MuJoCo keeps when it writes a model, such as "dynident:link3:mass"."""
    marked: dict[str, Labelled] = {}
    for link, joint, drive in zip(whole.links, whole.joint_names, whole.drives, strict=True):
        marked |= {f"{link.link}:{name}": label for name, label in (link.numbers | link.parameters).items()}
        marked |= {f"{joint}:{name}": label for name, label in drive.items()}
    marked |= {f"coupled drive:{name}": label for name, label in whole.coupled.items()}
    made = element("custom")
    for name, label in marked.items():
        data = " ".join(f"{key}={word}" for key, word in fields(label).items())
        made.append(element("text", {"name": f"dynident:{name}", "data": data}))
    return made


def _mjcf_pose(pose: Pose) -> dict[str, str]:
    return {"pos": exact(pose.origin), "quat": exact(quaternion(pose.R))}


def coupled_tendon(whole: WholeRobot, joints: tuple[str, ...]) -> list[Element]:
    """The drive that turns with the sum of two joints, which ``joints`` names; none without one."""
    coupling = whole.robot.coupling
    if coupling is None or not whole.coupled:
        return []
    # As the paper prints it the friction has no place.
    left = {} if coupling.coulomb == "sum" else {"friction"}
    drive = {quantity: label for quantity, label in whole.coupled.items() if quantity not in left}
    both = (element("joint", {"joint": joints[joint - 1], "coef": "1"}) for joint in coupling.joints)
    return [element("fixed", {"name": "coupled_drive"} | drive_attributes(drive, DRIVE), *both)]


@partial(
    robot_format,
    title="URDF",
    source="wiki.ros.org/urdf/XML; Drake's elements: drake.mit.edu, Parsing models",
    holds=frozenset({"armature", "damping", "friction", "speed", "acceleration", "torque"}),
    remarks=(
        "Armature and acceleration limits are in Drake's own elements. Pinocchio, MuJoCo and Gazebo ignore them: "
        "set them there by hand (rotorInertia and armature, dof_armature). Drake has no dry friction.",
    ),
)
def _urdf(whole: WholeRobot) -> Element:
    links, base = moved_links(whole), whole.link_names[0]
    spaces = {"xmlns:drake": "http://drake.mit.edu", "xmlns:dynident": DYNIDENT}
    root = element("robot", {"name": whole.robot.name} | spaces, element("link", {"name": base}))
    for each in links:
        limits, dynamics = each.joint.limits, drive_attributes(each.drive)
        root.append(element("link", {"name": each.link.link}, *each.marked(urdf_inertial)))
        bounded = all(map(math.isfinite, limits.position))
        kind = "prismatic" if not each.joint.revolute else "revolute" if bounded else "continuous"
        low, high = limits.position if bounded else (-_UNKNOWN, _UNKNOWN)
        values = {} if kind == "continuous" else {"lower": exact(low), "upper": exact(high)}
        values |= {"velocity": exact(min(limits.speed, _UNKNOWN)), "effort": exact(min(limits.torque, _UNKNOWN))}
        if math.isfinite(limits.acceleration):
            values["drake:acceleration"] = exact(limits.acceleration)
        parts = [*ends(each.parent, each.link.link, each.pose), element("axis", {"xyz": each.axis})]
        parts += [element("limit", values), *([element("dynamics", dynamics)] if dynamics else [])]
        root.append(element("joint", {"name": each.name, "type": kind}, *parts))
    flange, pose = flange_of(whole.robot)
    if flange not in whole.link_names:
        last = whole.link_names[-1]
        root.append(element("link", {"name": flange}))
        root.append(element("joint", {"name": f"{last}-{flange}", "type": "fixed"}, *ends(last, flange, pose)))
    interface = element("hardwareInterface", {}, "hardware_interface/EffortJointInterface")
    for each in links:  # as Drake reads drives
        rotor = element("drake:rotor_inertia", {"value": exact(drive_value(each.drive, "armature"))})
        gear = element("drake:gear_ratio", {"value": "1"})
        parts = [
            element("type", {}, "transmission_interface/SimpleTransmission"),
            element("joint", {"name": each.name}, interface),
            element("actuator", {"name": f"{each.name}_motor"}, rotor, gear),
        ]
        root.append(element("transmission", {"name": f"{each.name}_transmission"}, *parts))
    return root


@partial(
    robot_format,
    title="SDFormat 1.9 (Gazebo, Drake)",
    source="sdformat.org/spec; Drake's elements: drake.mit.edu, Parsing models",
    holds=frozenset({"armature", "damping", "friction", "speed", "acceleration", "torque"}),
    remarks=(
        "Armature and acceleration limits are in Drake's own elements, which Gazebo ignores. Drake has no dry "
        "friction. A base without inertial weighs 1 kg in SDFormat, which has no effect, as it is fixed to the "
        "world.",
    ),
)
def _sdf(whole: WholeRobot) -> Element:
    base = whole.link_names[0]
    model = element(
        "model", {"name": whole.robot.name},
        element("link", {"name": base}),
        element("joint", {"name": f"world-{base}", "type": "fixed"}, *texts({"parent": "world", "child": base})),
    )  # fmt: skip
    for each in moved_links(whole):
        pose, name = _sdf_pose(each.pose), each.link.link
        pose.set("relative_to", each.parent)
        model.append(element("link", {"name": name}, pose, *each.marked(sdf_inertial)))
        limits, kind = each.joint.limits, "revolute" if each.joint.revolute else "prismatic"
        bounds = {"lower": limits.position[0], "upper": limits.position[1], "effort": limits.torque}
        bounds |= {"velocity": limits.speed, "drake:acceleration": limits.acceleration}
        finite = {name: exact(end) for name, end in bounds.items() if math.isfinite(end)}
        rotor = {"drake:rotor_inertia": exact(drive_value(each.drive, "armature")), "drake:gear_ratio": "1"}
        axis = (
            element("xyz", {}, each.axis),
            element("limit", {}, *texts(finite)),
            element("dynamics", {}, *texts(drive_attributes(each.drive))),
        )
        parts = [*texts({"parent": each.parent, "child": name}), element("axis", {}, *axis)]
        parts += texts(rotor) if "armature" in each.drive else []
        model.append(element("joint", {"name": each.name, "type": kind}, *parts))
    flange, at = flange_of(whole.robot)
    if flange not in whole.link_names:
        model.append(element("frame", {"name": flange, "attached_to": whole.link_names[-1]}, _sdf_pose(at)))
    return element("sdf", {"version": "1.9", "xmlns:drake": "drake.mit.edu", "xmlns:dynident": DYNIDENT}, model)


def _sdf_pose(pose: Pose) -> Element:
    return element("pose", {}, f"{exact(pose.origin)} {exact(pose.rpy)}")


@partial(
    robot_format,
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
def _usd(whole: WholeRobot) -> str:
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


FORMATS: dict[str, Format[WholeRobot]] = {"mjcf": _mjcf, "sdf": _sdf, "urdf": _urdf, "usd": _usd}
"""Every format of a robot by its name."""
