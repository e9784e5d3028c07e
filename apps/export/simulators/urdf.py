"""URDF: links, joints, limits, damping and dry friction; what Drake reads beside it holds the armature.

A robot keeps the link frames of its own file. A payload is a link fixed to the link ``tool0``; its inertial origin
is not turned. Sources: wiki.ros.org/urdf/XML; wiki.ros.org/urdf/Tutorials (inertia, sign of products);
drake.mit.edu, Parsing models (drake:rotor_inertia of an actuator with the gear ratio 1 is the inertia on the
joint's side, drake:acceleration).
"""

from __future__ import annotations

import math
from functools import partial
from xml.etree.ElementTree import Element

from .... import estimation
from ....model import Pose
from ...numbers import exact
from ..format import DYNIDENT, FIRST, Format, element, urdf_inertial
from ..load import ControllerLoad, load_format
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
def _write(whole: estimation.WholeRobot) -> Element:
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
        parts = [*_place(each.parent, each.link.link, each.pose), element("axis", {"xyz": each.axis})]
        parts += [element("limit", values), *([element("dynamics", dynamics)] if dynamics else [])]
        root.append(element("joint", {"name": each.name, "type": kind}, *parts))
    flange, pose = flange_of(whole.robot)
    if flange not in whole.link_names:
        last = whole.link_names[-1]
        root.append(element("link", {"name": flange}))
        root.append(element("joint", {"name": f"{last}-{flange}", "type": "fixed"}, *_place(last, flange, pose)))
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


def _place(parent: str, child: str, pose: Pose) -> list[Element]:
    return [
        element("parent", {"link": parent}),
        element("child", {"link": child}),
        element("origin", {"xyz": exact(pose.origin), "rpy": exact(pose.rpy)}),
    ]


@load_format(
    title="URDF (copy joint and link payload into your robot, whose flange link is tool0 here)",
    source="wiki.ros.org/urdf/XML/link",
    order="ixx, ixy, ixz, iyy, iyz, izz, entries of the matrix (ixy = -integral of x y dm)",
    in_part="the inertia is zero, a point mass; simulators may ask for one of your own",
)
def _write_payload(load: ControllerLoad) -> Element:
    joint = element("joint", {"name": "tool0-payload", "type": "fixed"}, *_place("tool0", "payload", Pose()))
    link = element("link", {"name": "payload"}, urdf_inertial(load.mass, load.com, load.inertia))
    return element("robot", {"name": "payload"}, element("link", {"name": "tool0"}), joint, link)
