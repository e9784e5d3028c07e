"""URDF: links, joints, limits, damping and dry friction; what Drake reads beside it holds the armature.

A robot keeps the link frames of its own file. Sources: wiki.ros.org/urdf/XML; drake.mit.edu, Parsing models
(drake:rotor_inertia of an actuator with the gear ratio 1 is the inertia on the joint's side, drake:acceleration).
"""

import math
from xml.etree.ElementTree import Element

from ....estimation.possible.whole_robot import WholeRobot
from ....model import Pose
from ...numbers import exact
from ..format import Format
from ..robot import Frames, drive_attributes, drive_value, link_marks, marked, robot_head
from ..xml import COMMENT, DYNIDENT, FIRST, element, urdf_inertial, xml_text

_UNKNOWN = 1e6
"""URDF demands numbers for limits: this stands for none."""


def _write(whole: WholeRobot) -> str:
    robot, names, frames = whole.robot, whole.link_names, Frames(whole.robot)
    spaces = {"xmlns:drake": "http://drake.mit.edu", "xmlns:dynident": DYNIDENT}
    root = element("robot", {"name": robot.name} | spaces, element("link", {"name": names[0]}))
    for j, link in enumerate(whole.links):
        marks, body = link_marks(link, whole.apart[j]), link.body
        mass = [urdf_inertial(body.mass, body.com, body.inertia_com)] if body.mass else []
        root.append(element("link", {"name": link.link}, *marked(marks, mass)))
        joint = robot.joints[j]
        limits, dynamics = joint.limits, drive_attributes(whole.apart[j])
        bounded = all(map(math.isfinite, limits.position))
        kind = "prismatic" if not joint.revolute else "revolute" if bounded else "continuous"
        low, high = limits.position if bounded else (-_UNKNOWN, _UNKNOWN)
        values = {} if kind == "continuous" else {"lower": exact(low), "upper": exact(high)}
        values |= {"velocity": exact(min(limits.speed, _UNKNOWN)), "effort": exact(min(limits.torque, _UNKNOWN))}
        if math.isfinite(limits.acceleration):
            values["drake:acceleration"] = exact(limits.acceleration)
        parts = [*_place(names[j], names[j + 1], frames.link(j)), element("axis", {"xyz": frames.axis(j)})]
        parts += [element("limit", values), *([element("dynamics", dynamics)] if dynamics else [])]
        root.append(element("joint", {"name": whole.joint_names[j], "type": kind}, *parts))
    if (flange := frames.flange_name) not in names:
        fixed = {"name": f"{names[-1]}-{flange}", "type": "fixed"}
        root.append(element("link", {"name": flange}))
        root.append(element("joint", fixed, *_place(names[-1], flange, frames.flange)))
    interface = element("hardwareInterface", {}, "hardware_interface/EffortJointInterface")
    for name, drive in zip(whole.joint_names, whole.apart, strict=True):  # as Drake reads drives
        rotor = element("drake:rotor_inertia", {"value": exact(drive_value(drive, "armature"))})
        gear = element("drake:gear_ratio", {"value": "1"})
        parts = [
            element("type", {}, "transmission_interface/SimpleTransmission"),
            element("joint", {"name": name}, interface),
            element("actuator", {"name": f"{name}_motor"}, rotor, gear),
        ]
        root.append(element("transmission", {"name": f"{name}_transmission"}, *parts))
    return xml_text(root)


def _place(parent: str, child: str, pose: Pose) -> list[Element]:
    return [
        element("parent", {"link": parent}),
        element("child", {"link": child}),
        element("origin", {"xyz": exact(pose.origin), "rpy": exact(pose.rpy)}),
    ]


FORMAT = Format(
    title="URDF",
    source="wiki.ros.org/urdf/XML; Drake's elements: drake.mit.edu, Parsing models",
    head=robot_head,
    write=_write,
    holds=frozenset({"armature", "damping", "friction", "speed", "acceleration", "torque"}),
    remarks=(
        "Armature and limits of acceleration stand in elements of Drake's; Pinocchio, MuJoCo and Gazebo pass them "
        "over: set them there by hand (rotorInertia and armature, dof_armature). Drake has no dry friction.",
    ),
    first_line=FIRST,
    comment=COMMENT,
)
