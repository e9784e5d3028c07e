"""SDFormat (Gazebo, Drake): as URDF, the links in one model that is fixed to the world.

Poses are relative to the parent link, axes stand in the child's frame, which is the joint's. Sources:
sdformat.org/spec; drake.mit.edu, Parsing models (drake:rotor_inertia, drake:gear_ratio, drake:acceleration).
"""

import math
from collections.abc import Iterator, Mapping
from xml.sax.saxutils import quoteattr

from ....estimation.possible.whole_robot import Labelled, WholeRobot
from ....model import InertialParameters
from ...numbers import exact, inertia_entries
from .form import (
    SimulatorFormat,
    comment,
    drive_value,
    flange_name,
    flange_pose,
    in_parent,
    joint_direction,
    link_marks,
)
from .urdf import DYNIDENT, drive_attributes, link_comment, mark_elements


def _write(whole: WholeRobot, head: list[str]) -> str:
    robot, names = whole.robot, whole.link_names
    lines = [
        '<?xml version="1.0" encoding="utf-8"?>',
        *comment(head),
        f'<sdf version="1.9" xmlns:drake="drake.mit.edu" xmlns:dynident="{DYNIDENT}">',
        f"  <model name={quoteattr(robot.name)}>",
        f"    <link name={quoteattr(names[0])}/>",
        f'    <joint name="world-{names[0]}" type="fixed"><parent>world</parent><child>{names[0]}</child></joint>',
    ]
    for j, link in enumerate(whole.links):
        place = in_parent(robot, j)
        lines += [
            f"    <link name={quoteattr(link.link)}>",
            f"      <pose relative_to={quoteattr(names[j])}>{exact(place.origin)} {exact(place.rpy)}</pose>",
            *_body(link.body, link_marks(link, whole.apart[j])),
            "    </link>",
            *_joint(whole, j),
        ]
    place = flange_pose(robot)
    flange = flange_name(robot)
    if flange not in names:
        lines += [
            f"    <frame name={quoteattr(flange)} attached_to={quoteattr(names[-1])}>",
            f"      <pose>{exact(place.origin)} {exact(place.rpy)}</pose>",
            "    </frame>",
        ]
    return "\n".join([*lines, "  </model>", "</sdf>"]) + "\n"


def _body(body: InertialParameters, numbers: Mapping[str, Labelled]) -> Iterator[str]:
    yield from link_comment(numbers, "      ")
    if body.mass != 0.0:
        yield "      <inertial>"
        yield f"        <pose>{exact(body.com)} 0 0 0</pose>"
        yield f"        <mass>{exact(body.mass)}</mass>"
        yield f"        <inertia>{_elements(inertia_entries(body.inertia_com))}</inertia>"
        yield "      </inertial>"
    yield from (f"      {line}" for line in mark_elements(numbers))


def _joint(whole: WholeRobot, j: int) -> Iterator[str]:
    joint, names, drive = whole.robot.joints[j], whole.link_names, whole.apart[j]
    limits = joint.limits
    bounds = {
        "lower": limits.position[0],
        "upper": limits.position[1],
        "effort": limits.torque,
        "velocity": limits.speed,
        "drake:acceleration": limits.acceleration,
    }
    kind = "revolute" if joint.revolute else "prismatic"
    yield f'    <joint name={quoteattr(whole.joint_names[j])} type="{kind}">'
    yield f"      <parent>{names[j]}</parent>"
    yield f"      <child>{names[j + 1]}</child>"
    finite = {name: exact(end) for name, end in bounds.items() if math.isfinite(end)}
    yield "      <axis>"
    yield f"        <xyz>{exact(joint_direction(whole.robot, j))}</xyz>"
    yield f"        <limit>{_elements(finite)}</limit>"
    yield f"        <dynamics>{_elements(drive_attributes(drive))}</dynamics>"
    yield "      </axis>"
    if "armature" in drive:
        yield f"      <drake:rotor_inertia>{exact(drive_value(drive, 'armature'))}</drake:rotor_inertia>"
        yield "      <drake:gear_ratio>1</drake:gear_ratio>"
    yield "    </joint>"


def _elements(values: Mapping[str, str]) -> str:
    return "".join(f"<{name}>{value}</{name}>" for name, value in values.items())


FORMAT = SimulatorFormat(
    name="sdf",
    title="SDFormat 1.9 (Gazebo, Drake)",
    ending="sdf",
    holds=frozenset({"armature", "damping", "friction", "speed", "acceleration", "torque"}),
    write=_write,
    remarks=(
        "Armature and limits of acceleration stand in elements of Drake's, Gazebo passes them over. Drake has no "
        "dry friction. A base without inertial weighs 1 kg in SDFormat; it is fixed to the world, so nothing "
        "shows it.",
    ),
)
