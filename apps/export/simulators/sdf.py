"""SDFormat (Gazebo, Drake): as URDF, the links in one model that is fixed to the world.

Poses are relative to the parent link, axes stand in the child's frame, which is the joint's. Sources:
sdformat.org/spec; drake.mit.edu, Parsing models (drake:rotor_inertia, drake:gear_ratio, drake:acceleration).
"""

import math
from xml.etree.ElementTree import Element

from ....estimation.possible.whole_robot import WholeRobot
from ....model import Pose
from ...numbers import exact
from ..format import Format
from ..robot import Frames, drive_attributes, drive_value, link_marks, marked, robot_head
from ..xml import COMMENT, DYNIDENT, FIRST, element, sdf_inertial, texts, xml_text


def _write(whole: WholeRobot) -> str:
    robot, names, frames = whole.robot, whole.link_names, Frames(whole.robot)
    ends = texts({"parent": "world", "child": names[0]})
    model = element(
        "model", {"name": robot.name},
        element("link", {"name": names[0]}),
        element("joint", {"name": f"world-{names[0]}", "type": "fixed"}, *ends),
    )  # fmt: skip
    for j, link in enumerate(whole.links):
        pose, drive, body = _pose(frames.link(j)), whole.apart[j], link.body
        pose.set("relative_to", names[j])
        mass = [sdf_inertial(body.mass, body.com, body.inertia_com)] if body.mass else []
        model.append(element("link", {"name": link.link}, pose, *marked(link_marks(link, drive), mass)))
        joint = robot.joints[j]
        limits, kind = joint.limits, "revolute" if joint.revolute else "prismatic"
        bounds = {"lower": limits.position[0], "upper": limits.position[1], "effort": limits.torque}
        bounds |= {"velocity": limits.speed, "drake:acceleration": limits.acceleration}
        finite = {name: exact(end) for name, end in bounds.items() if math.isfinite(end)}
        rotor = {"drake:rotor_inertia": exact(drive_value(drive, "armature")), "drake:gear_ratio": "1"}
        axis = (
            element("xyz", {}, frames.axis(j)),
            element("limit", {}, *texts(finite)),
            element("dynamics", {}, *texts(drive_attributes(drive))),
        )
        parts = [*texts({"parent": names[j], "child": names[j + 1]}), element("axis", {}, *axis)]
        parts += texts(rotor) if "armature" in drive else []
        model.append(element("joint", {"name": whole.joint_names[j], "type": kind}, *parts))
    if (flange := frames.flange_name) not in names:
        attached = {"name": flange, "attached_to": names[-1]}
        model.append(element("frame", attached, _pose(frames.flange)))
    spaces = {"xmlns:drake": "drake.mit.edu", "xmlns:dynident": DYNIDENT}
    return xml_text(element("sdf", {"version": "1.9"} | spaces, model))


def _pose(pose: Pose) -> Element:
    return element("pose", {}, f"{exact(pose.origin)} {exact(pose.rpy)}")


FORMAT = Format(
    title="SDFormat 1.9 (Gazebo, Drake)",
    source="sdformat.org/spec; Drake's elements: drake.mit.edu, Parsing models",
    head=robot_head,
    write=_write,
    holds=frozenset({"armature", "damping", "friction", "speed", "acceleration", "torque"}),
    remarks=(
        "Armature and limits of acceleration stand in elements of Drake's, Gazebo passes them over. Drake has no "
        "dry friction. A base without inertial weighs 1 kg in SDFormat; it is fixed to the world, so nothing "
        "shows it.",
    ),
    first_line=FIRST,
    comment=COMMENT,
)
