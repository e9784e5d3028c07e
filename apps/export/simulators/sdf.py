"""SDFormat (Gazebo, Drake): as URDF, the links in one model that is fixed to the world.

Poses are relative to the parent link, axes stand in the child's frame, which is the joint's. A payload is a model
of one link, its origin at the flange; without entries of the inertia SDFormat takes 1 kg m^2, so a point mass needs
explicit zeros. Sources: sdformat.org/spec, link/inertial (element descriptions in sdf/1.x/inertial.sdf); gz-math,
Inertial; drake.mit.edu, Parsing models (drake:rotor_inertia, drake:gear_ratio, drake:acceleration).
"""

from __future__ import annotations

import math
from functools import partial
from xml.etree.ElementTree import Element

from .... import estimation
from ....model import Pose
from ...numbers import exact
from ..format import DYNIDENT, FIRST, Format, element, sdf_inertial, texts
from ..load import ControllerLoad, load_format
from ..robot import drive_attributes, drive_value, flange_of, moved_links


@partial(
    Format,
    title="SDFormat 1.9 (Gazebo, Drake)",
    source="sdformat.org/spec; Drake's elements: drake.mit.edu, Parsing models",
    holds=frozenset({"armature", "damping", "friction", "speed", "acceleration", "torque"}),
    remarks=(
        "Armature and acceleration limits are in Drake's own elements, which Gazebo ignores. Drake has no dry "
        "friction. A base without inertial weighs 1 kg in SDFormat, which has no effect, as it is fixed to the "
        "world.",
    ),
    first_line=FIRST,
)
def _write(whole: estimation.WholeRobot) -> Element:
    base = whole.link_names[0]
    model = element(
        "model", {"name": whole.robot.name},
        element("link", {"name": base}),
        element("joint", {"name": f"world-{base}", "type": "fixed"}, *texts({"parent": "world", "child": base})),
    )  # fmt: skip
    for each in moved_links(whole):
        pose, name = _pose(each.pose), each.link.link
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
    flange, pose_of_flange = flange_of(whole.robot)
    if flange not in whole.link_names:
        model.append(element("frame", {"name": flange, "attached_to": whole.link_names[-1]}, _pose(pose_of_flange)))
    return element("sdf", {"version": "1.9", "xmlns:drake": "drake.mit.edu", "xmlns:dynident": DYNIDENT}, model)


def _pose(pose: Pose) -> Element:
    return element("pose", {}, f"{exact(pose.origin)} {exact(pose.rpy)}")


@load_format(
    title="SDFormat (fix the link payload to the flange of your robot, origin on origin)",
    source="sdformat.org/spec, inertial",
    order="pose x, y, z, roll, pitch, yaw; ixx, ixy, ixz, iyy, iyz, izz, entries of the matrix",
    in_part="the inertia is zero, a point mass (left out it would be 1 kg m^2); simulators may ask for one of "
    "your own",
)
def _write_payload(load: ControllerLoad) -> Element:
    link = element("link", {"name": "payload"}, sdf_inertial(load.mass, load.com, load.inertia))
    return element("sdf", {"version": "1.7"}, element("model", {"name": "payload"}, link))
