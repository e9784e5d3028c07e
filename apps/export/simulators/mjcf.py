"""MJCF (MuJoCo): all that a robot's description has, but for tables of springs.

A joint's armature, damping and frictionloss are its drive's; a coupled drive is a fixed tendon over both joints
with its own; an offset is the bias of the joint's actuator, whose control is the motor's torque; a spring between
two pivots is a spatial tendon between two sites. fullinertia is M11, M22, M33, M12, M13, M23 about pos in the axes
of the body. Source: MuJoCo documentation, XML reference.
"""

import math
from collections.abc import Mapping
from xml.etree.ElementTree import Element

from ....estimation.possible.whole_robot import Labelled, WholeRobot
from ....model import Pose
from ...numbers import exact
from ..format import Format
from ..robot import Frames, drive_value, fields, link_marks, mark_comment, robot_head
from ..rotation import quaternion
from ..xml import COMMENT, FIRST, element, mjcf_inertial, xml_text


def _write(whole: WholeRobot) -> str:
    frames, spring = Frames(whole.robot), whole.robot.spring
    tendons, motors = coupled_tendon(whole, whole.joint_names), list[Element]()
    if spring is not None and not spring.table:
        values = {"name": "spring", "stiffness": exact(spring.stiffness), "springlength": exact(spring.length)}
        ends = (element("site", {"site": f"spring_{end}"}) for end in ("fixed", "moving"))
        tendons.append(element("spatial", values, *ends))
    for name, drive, joint in zip(whole.joint_names, whole.drives, whole.robot.joints, strict=True):
        values = {"name": name, "joint": name}  # the control is the torque on the joint's side
        if math.isfinite(torque := joint.limits.torque):
            values["ctrlrange"] = exact([-torque, torque])
        if "offset" in drive:  # the bias takes the offset off
            values |= {"biastype": "affine", "biasprm": exact([-drive["offset"].value, 0.0, 0.0])}
        motors.append(element("general", values))
    root = element(
        "mujoco",
        {"model": whole.robot.name},
        element("compiler", {"angle": "radian", "autolimits": "true"}),
        element("option", {"gravity": exact(frames.gravity)}),
        custom(whole),
        element("worldbody", {}, _links(whole)),
        *([element("tendon", {}, *tendons)] if tendons else []),
        element("actuator", {}, *motors),
    )
    return xml_text(root)


def marks(whole: WholeRobot) -> dict[str, Labelled]:
    """Every number by the name of its text: "dynident:link3:mass", "dynident:joint3:armature"."""
    named: dict[str, Labelled] = {}
    for link, joint, drive in zip(whole.links, whole.joint_names, whole.drives, strict=True):
        named |= {f"dynident:{link.link}:{name}": label for name, label in (link.numbers | link.parameters).items()}
        named |= {f"dynident:{joint}:{name}": label for name, label in drive.items()}
    return named | {f"dynident:coupled drive:{name}": label for name, label in whole.coupled.items()}


def custom(whole: WholeRobot) -> Element:
    """Marks as texts that MuJoCo keeps when it writes a model."""
    text = {name: " ".join(f"{key}={word}" for key, word in fields(label).items())
             for name, label in marks(whole).items()}  # fmt: skip
    return element("custom", {}, *(element("text", {"name": name, "data": data}) for name, data in text.items()))


def _links(whole: WholeRobot) -> Element:
    """The base, and each link within the one before."""
    robot, sites, frames = whole.robot, _spring_sites(whole), Frames(whole.robot)
    root = outer = element("body", {"name": whole.link_names[0]}, *sites.get(0, []))
    for j, link in enumerate(whole.links):
        values = {"name": whole.joint_names[j], "type": "hinge" if robot.joints[j].revolute else "slide"}
        values["axis"] = frames.axis(j)
        if all(map(math.isfinite, robot.joints[j].limits.position)):
            values["range"] = exact(robot.joints[j].limits.position)
        inner = element(
            "body", {"name": link.link} | _pose(frames.link(j)),
            mark_comment(link_marks(link, whole.drives[j])),
            mjcf_inertial(link.body.mass, link.body.com, link.body.inertia_com),
            element("joint", values | drive_attributes(whole.drives[j])),
            *sites.get(j + 1, []),
        )  # fmt: skip
        outer.append(inner)
        outer = inner
    outer.append(element("site", {"name": frames.flange_name} | _pose(frames.flange)))
    return root


def _pose(pose: Pose) -> dict[str, str]:
    return {"pos": exact(pose.origin), "quat": exact(quaternion(pose.R))}


def drive_attributes(drive: Mapping[str, Labelled]) -> dict[str, str]:
    """Attributes of a joint or a tendon for its drive, as far as it is known."""
    names = {"armature": "armature", "damping": "damping", "friction": "frictionloss"}
    return {name: exact(drive_value(drive, quantity)) for quantity, name in names.items() if quantity in drive}


def coupled_tendon(whole: WholeRobot, joints: tuple[str, ...]) -> list[Element]:
    """The drive that turns with the sum of two joints, which ``joints`` names; none without one."""
    coupling = whole.robot.coupling
    if coupling is None or not whole.coupled:
        return []
    # As the paper prints it the friction has no place.
    left = {} if coupling.coulomb == "sum" else {"friction"}
    drive = {quantity: label for quantity, label in whole.coupled.items() if quantity not in left}
    both = (element("joint", {"joint": joints[joint - 1], "coef": "1"}) for joint in coupling.joints)
    return [element("fixed", {"name": "coupled_drive"} | drive_attributes(drive), *both)]


def _spring_sites(whole: WholeRobot) -> dict[int, list[Element]]:
    """Pivots of the spring as elements of the links that they stand on, 0 being the base.

    The moving pivot stands in the joint's frame, the fixed one in that frame at q = 0. Their angle about the axis
    is q - zero - pi, so that L^2 = a^2 + b^2 + 2 a b cos(q - zero).
    """
    spring, frames = whole.robot.spring, Frames(whole.robot)
    if spring is None or spring.table:
        return {}
    j, (a, b) = spring.joint - 1, spring.arms
    pivots = (
        ("spring_fixed", frames.joint(j), [-b * math.cos(spring.zero), -b * math.sin(spring.zero), 0.0]),
        ("spring_moving", frames.own(j + 1).inverse(), [a, 0.0, 0.0]),
    )
    return {
        link: [element("site", {"name": name, "pos": exact(pose.R @ pivot + pose.p)})]
        for link, (name, pose, pivot) in enumerate(pivots, j)
    }


FORMAT = Format(
    title="MJCF (MuJoCo 3.3 or newer)",
    source="MuJoCo XML reference",
    head=robot_head,
    write=_write,
    holds=frozenset({"armature", "damping", "friction", "offset", "coupled", "spring", "torque", "gravity"}),
    remarks=(
        "Controls are the motors' torques on the joints' side; actuators take the offsets off. Their limits are "
        "those of the torque.",
    ),
    first_line=FIRST,
    comment=COMMENT,
)
