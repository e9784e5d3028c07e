"""URDF: links, joints, limits, damping and dry friction; what Drake reads beside it holds the armature.

A robot keeps the link frames of its own file. Sources: wiki.ros.org/urdf/XML; wiki.ros.org/urdf/Tutorials (inertia,
sign of products); drake.mit.edu, Parsing models (drake:rotor_inertia of an actuator with the gear ratio 1 is the
inertia on the joint's side, drake:acceleration).
"""

import math
from functools import partial
from xml.etree.ElementTree import Element

from ....estimation.possible.whole_robot import WholeRobot
from ...numbers import exact
from ..bodies import joint_ends, urdf_inertial
from ..format import DYNIDENT, FIRST, Format, element
from ..robot import drive_attributes, drive_value, flange_of, moved_links

_UNKNOWN = 1e6  # URDF demands numbers for limits: this stands for none


@partial(
    Format,
    title="URDF",
    source="wiki.ros.org/urdf/XML; Drake's elements: drake.mit.edu, Parsing models",
    holds=frozenset({"armature", "damping", "friction", "speed", "acceleration", "torque"}),
    remarks=(
        "Armature and acceleration limits are in Drake's own elements. Pinocchio, MuJoCo and Gazebo ignore them: "
        "set them there by hand (rotorInertia and armature, dof_armature). Drake has no dry friction.",
    ),
    first_line=FIRST,
)
def _write(whole: WholeRobot) -> Element:
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
        parts = [*joint_ends(each.parent, each.link.link, each.pose), element("axis", {"xyz": each.axis})]
        parts += [element("limit", values), *([element("dynamics", dynamics)] if dynamics else [])]
        root.append(element("joint", {"name": each.name, "type": kind}, *parts))
    flange, pose = flange_of(whole.robot)
    if flange not in whole.link_names:
        last = whole.link_names[-1]
        root.append(element("link", {"name": flange}))
        root.append(
            element("joint", {"name": f"{last}-{flange}", "type": "fixed"}, *joint_ends(last, flange, pose))
        )
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
