"""URDF: links, joints, limits, damping and dry friction; what Drake reads beside it holds the armature.

A robot keeps the link frames of its own file. Sources: wiki.ros.org/urdf/XML; drake.mit.edu, Parsing models
(drake:rotor_inertia of an actuator with the gear ratio 1 is the inertia on the joint's side, drake:acceleration).
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from xml.sax.saxutils import quoteattr

from ....estimation.possible.whole_robot import Labelled, WholeRobot
from ....model import InertialParameters, Pose
from ...numbers import exact, inertia_entries
from .form import (
    SimulatorFormat,
    attributes,
    comment,
    drive_value,
    fields,
    flange_name,
    flange_pose,
    in_parent,
    joint_direction,
    link_marks,
    mark_lines,
)

_UNKNOWN = 1e6
"""URDF demands numbers for limits: this stands for none."""
DRAKE, DYNIDENT = "http://drake.mit.edu", "urn:dynident"
"""Namespaces of the elements beside the standard ones."""


def _write(whole: WholeRobot, head: list[str]) -> str:
    robot, names = whole.robot, whole.link_names
    lines = [
        '<?xml version="1.0" encoding="utf-8"?>',
        *comment(head),
        f'<robot name={quoteattr(robot.name)} xmlns:drake="{DRAKE}" xmlns:dynident="{DYNIDENT}">',
        f"  <link name={quoteattr(names[0])}/>",
    ]
    for j, link in enumerate(whole.links):
        numbers = link_marks(link, whole.apart[j])
        lines += _link(names[j + 1], link.body, numbers)
        lines += _joint(whole, j)
    flange = flange_name(robot)
    if flange not in names:
        lines += [f"  <link name={quoteattr(flange)}/>", *_fixed(names[-1], flange, flange_pose(robot))]
    lines += [line for j in range(robot.n) for line in _transmission(whole, j)]
    return "\n".join([*lines, "</robot>"]) + "\n"


def _link(name: str, body: InertialParameters, numbers: Mapping[str, Labelled]) -> Iterator[str]:
    yield f"  <link name={quoteattr(name)}>"
    yield from link_comment(numbers, "    ")
    if body.mass != 0.0:
        yield from (f"    {line}" for line in inertial(body))
    yield from (f"    {line}" for line in mark_elements(numbers))
    yield "  </link>"


def link_comment(numbers: Mapping[str, Labelled], indent: str) -> Iterator[str]:
    """One comment of a link, a line a number."""
    yield f"{indent}<!--"
    yield from (f"{indent}  {line}" for line in mark_lines(numbers))
    yield f"{indent}-->"


def mark_elements(numbers: Mapping[str, Labelled]) -> Iterator[str]:
    """Marks as elements of a namespace of their own, which readers pass over and SDFormat keeps."""
    for name, label in numbers.items():
        yield f"<dynident:number {attributes({'name': name} | fields(label))}/>"


def inertial(body: InertialParameters) -> Iterator[str]:
    """The element of a body in its own frame, a line each."""
    yield "<inertial>"
    yield f'  <origin xyz="{exact(body.com)}" rpy="0 0 0"/>'
    yield f'  <mass value="{exact(body.mass)}"/>'
    yield f"  <inertia {attributes(inertia_entries(body.inertia_com))}/>"
    yield "</inertial>"


def drive_attributes(drive: Mapping[str, Labelled]) -> dict[str, str]:
    """Attributes of <dynamics>, as far as they are known."""
    return {
        quantity: exact(drive_value(drive, quantity)) for quantity in ("damping", "friction") if quantity in drive
    }


def _joint(whole: WholeRobot, j: int) -> Iterator[str]:
    joint, names = whole.robot.joints[j], whole.link_names
    limits = joint.limits
    bounded = all(math.isfinite(end) for end in limits.position)
    kind = "prismatic" if not joint.revolute else "revolute" if bounded else "continuous"
    low, high = limits.position if bounded else (-_UNKNOWN, _UNKNOWN)
    ends = "" if kind == "continuous" else f'lower="{exact(low)}" upper="{exact(high)}" '
    speed, torque = (exact(min(value, _UNKNOWN)) for value in (limits.speed, limits.torque))
    faster = f' drake:acceleration="{exact(limits.acceleration)}"' if math.isfinite(limits.acceleration) else ""
    yield f'  <joint name={quoteattr(whole.joint_names[j])} type="{kind}">'
    yield from _place(names[j], names[j + 1], in_parent(whole.robot, j))
    yield f'    <axis xyz="{exact(joint_direction(whole.robot, j))}"/>'
    yield f'    <limit {ends}velocity="{speed}" effort="{torque}"{faster}/>'
    if dynamics := drive_attributes(whole.apart[j]):
        yield f"    <dynamics {attributes(dynamics)}/>"
    yield "  </joint>"


def _fixed(parent: str, child: str, pose: Pose) -> Iterator[str]:
    yield f'  <joint name={quoteattr(f"{parent}-{child}")} type="fixed">'
    yield from _place(parent, child, pose)
    yield "  </joint>"


def _place(parent: str, child: str, pose: Pose) -> Iterator[str]:
    yield f"    <parent link={quoteattr(parent)}/>"
    yield f"    <child link={quoteattr(child)}/>"
    yield f'    <origin xyz="{exact(pose.origin)}" rpy="{exact(pose.rpy)}"/>'


def _transmission(whole: WholeRobot, j: int) -> Iterable[str]:
    """A drive as Drake reads it."""
    name = whole.joint_names[j]
    interface = "hardware_interface/EffortJointInterface"
    return (
        f"  <transmission name={quoteattr(f'{name}_transmission')}>",
        "    <type>transmission_interface/SimpleTransmission</type>",
        f"    <joint name={quoteattr(name)}><hardwareInterface>{interface}</hardwareInterface></joint>",
        f"    <actuator name={quoteattr(f'{name}_motor')}>",
        f'      <drake:rotor_inertia value="{exact(drive_value(whole.apart[j], "armature"))}"/>',
        '      <drake:gear_ratio value="1"/>',
        "    </actuator>",
        "  </transmission>",
    )


FORMAT = SimulatorFormat(
    name="urdf",
    title="URDF",
    ending="urdf",
    holds=frozenset({"armature", "damping", "friction", "speed", "acceleration", "torque"}),
    write=_write,
    remarks=(
        "Armature and limits of acceleration stand in elements of Drake's; Pinocchio, MuJoCo and Gazebo pass them "
        "over: set them there by hand (rotorInertia and armature, dof_armature). Drake has no dry friction.",
    ),
)
