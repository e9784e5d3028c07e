"""MJCF (MuJoCo): all that a robot's description has, but for tables of springs.

A joint's armature, damping and frictionloss are its drive's; a coupled drive is a fixed tendon over both joints
with its own; an offset is the bias of the joint's actuator, whose control is the motor's torque; a spring between
two pivots is a spatial tendon between two sites. fullinertia is M11, M22, M33, M12, M13, M23 about pos in the axes
of the body. Source: MuJoCo documentation, XML reference.
"""

import math
from collections.abc import Iterator
from xml.sax.saxutils import quoteattr

import numpy as np

from ....common.arrays import Array
from ....estimation.possible.whole_robot import Labelled, WholeRobot
from ....model import InertialParameters, Joint, Pose
from ...numbers import exact, six
from ..controllers.rotation import quaternion
from .form import (
    SimulatorFormat,
    attributes,
    comment,
    drive_value,
    fields,
    flange_name,
    flange_pose,
    gravity_in_base,
    in_parent,
    joint_direction,
    joint_in_parent,
    link_marks,
    mark_lines,
    own_frame,
)


def _write(whole: WholeRobot, head: list[str]) -> str:
    robot = whole.robot
    lines = [
        '<?xml version="1.0" encoding="utf-8"?>',
        *comment(head),
        f"<mujoco model={quoteattr(robot.name)}>",
        '  <compiler angle="radian" autolimits="true"/>',
        f'  <option gravity="{exact(gravity_in_base(robot))}"/>',
        *_custom(whole),
        "  <worldbody>",
        f"    <body name={quoteattr(whole.link_names[0])}>",
        *_bodies(whole),
        "    </body>",
        "  </worldbody>",
        *_tendons(whole),
        *_actuators(whole),
        "</mujoco>",
    ]
    return "\n".join(lines) + "\n"


def marks(whole: WholeRobot) -> dict[str, Labelled]:
    """Every number by the name of its text: "dynident:link3:mass", "dynident:joint3:armature"."""
    named: dict[str, Labelled] = {}
    for link, joint, drive in zip(whole.links, whole.joint_names, whole.drives, strict=True):
        named |= {f"dynident:{link.link}:{name}": label for name, label in (link.numbers | link.parameters).items()}
        named |= {f"dynident:{joint}:{name}": label for name, label in drive.items()}
    return named | {f"dynident:coupled drive:{name}": label for name, label in whole.coupled.items()}


def custom_texts(whole: WholeRobot) -> Iterator[str]:
    """Marks as elements that MuJoCo keeps when it writes a model."""
    for name, label in marks(whole).items():
        words = " ".join(f"{key}={word}" for key, word in fields(label).items())
        yield f"  <text name={quoteattr(name)} data={quoteattr(words)}/>"


def _custom(whole: WholeRobot) -> Iterator[str]:
    yield "  <custom>"
    yield from (f"  {line}" for line in custom_texts(whole))
    yield "  </custom>"


def _bodies(whole: WholeRobot) -> Iterator[str]:
    """The links, each within the one before."""
    robot, n = whole.robot, whole.robot.n
    sites = spring_sites(whole)
    if 0 in sites:
        yield f"      {sites[0]}"
    for j, link in enumerate(whole.links):
        indent = "  " * (j + 3)
        place = in_parent(robot, j)
        yield f"{indent}<body name={quoteattr(link.link)} {_pose(place)}>"
        yield f"{indent}  <!--"
        yield from (f"{indent}    {line}" for line in mark_lines(link_marks(link, whole.drives[j])))
        yield f"{indent}  -->"
        yield f"{indent}  {inertial(link.body)}"
        yield f"{indent}  {_joint(whole, j)}"
        if j + 1 in sites:
            yield f"{indent}  {sites[j + 1]}"
    flange = flange_name(robot)
    yield f"{'  ' * (n + 3)}<site name={quoteattr(flange)} {_pose(flange_pose(robot))}/>"
    yield from (f"{'  ' * (j + 3)}</body>" for j in reversed(range(n)))


def inertial(body: InertialParameters) -> str:
    """The element of a body in its own frame."""
    moments = exact(six(body.inertia_com))
    return f'<inertial pos="{exact(body.com)}" mass="{exact(body.mass)}" fullinertia="{moments}"/>'


def drive_attributes(drive: dict[str, Labelled]) -> dict[str, str]:
    """Attributes of a joint or a tendon for its drive, as far as it is known."""
    names = {"armature": "armature", "damping": "damping", "friction": "frictionloss"}
    return {name: exact(drive_value(drive, quantity)) for quantity, name in names.items() if quantity in drive}


def _joint(whole: WholeRobot, j: int) -> str:
    joint: Joint = whole.robot.joints[j]
    values = {
        "name": whole.joint_names[j],
        "type": "hinge" if joint.revolute else "slide",
        "axis": exact(joint_direction(whole.robot, j)),
    }
    if all(map(math.isfinite, joint.limits.position)):
        values["range"] = exact(joint.limits.position)
    return f"<joint {attributes(values | drive_attributes(whole.drives[j]))}/>"


def _actuators(whole: WholeRobot) -> Iterator[str]:
    """One motor a joint; its control is the torque on the joint's side, its bias takes the offset off."""
    yield "  <actuator>"
    for name, joint, drive in zip(whole.joint_names, whole.robot.joints, whole.drives, strict=True):
        values = {"name": name, "joint": name}
        if math.isfinite(joint.limits.torque):
            values["ctrlrange"] = exact([-joint.limits.torque, joint.limits.torque])
        if "offset" in drive:
            values |= {"biastype": "affine", "biasprm": exact([-drive["offset"].value, 0.0, 0.0])}
        yield f"    <general {attributes(values)}/>"
    yield "  </actuator>"


def _tendons(whole: WholeRobot) -> Iterator[str]:
    lines = [*coupled_tendon(whole, whole.joint_names), *_spring_tendon(whole)]
    if lines:
        yield "  <tendon>"
        yield from (f"    {line}" for line in lines)
        yield "  </tendon>"


def coupled_tendon(whole: WholeRobot, joints: tuple[str, ...]) -> Iterator[str]:
    """The drive that turns with the sum of two joints, which ``joints`` names."""
    coupling = whole.robot.coupling
    if coupling is None or not whole.coupled:
        return
    drive = {
        quantity: label
        for quantity, label in whole.coupled.items()
        if quantity != "friction" or coupling.coulomb == "sum"
    }
    yield f"<fixed {attributes({'name': 'coupled_drive'} | drive_attributes(drive))}>"
    yield from (f'  <joint joint={quoteattr(joints[joint - 1])} coef="1"/>' for joint in coupling.joints)
    yield "</fixed>"


def _spring_tendon(whole: WholeRobot) -> Iterator[str]:
    spring = whole.robot.spring
    if spring is None or spring.table:
        return
    values = {"name": "spring", "stiffness": exact(spring.stiffness), "springlength": exact(spring.length)}
    yield f"<spatial {attributes(values)}>"
    yield '  <site site="spring_fixed"/>'
    yield '  <site site="spring_moving"/>'
    yield "</spatial>"


def spring_sites(whole: WholeRobot) -> dict[int, str]:
    """Pivots of the spring as elements of the links that they stand on, 0 being the base."""
    spring, robot = whole.robot.spring, whole.robot
    if spring is None or spring.table:
        return {}
    j = spring.joint - 1
    moving, fixed = spring_pivots(spring.arms, spring.zero)
    on_link = own_frame(robot, j + 1).inverse()
    on_parent = joint_in_parent(robot, j)
    return {
        j: _site("spring_fixed", on_parent.R @ fixed + on_parent.p),
        j + 1: _site("spring_moving", on_link.R @ moving + on_link.p),
    }


def spring_pivots(arms: tuple[float, float], zero: float) -> tuple[Array, Array]:
    """The moving pivot in the joint's frame and the fixed one in that frame at q = 0 [m], shape (3,) each.

    Their angle about the axis is q - zero - pi, so that L^2 = a^2 + b^2 + 2 a b cos(q - zero).
    """
    a, b = arms
    return np.array([a, 0.0, 0.0]), -b * np.array([math.cos(zero), math.sin(zero), 0.0])


def _site(name: str, place: Array) -> str:
    return f'<site name="{name}" pos="{exact(place)}"/>'


def _pose(pose: Pose) -> str:
    return f'pos="{exact(pose.origin)}" quat="{exact(quaternion(pose.R))}"'


FORMAT = SimulatorFormat(
    name="mjcf",
    title="MJCF (MuJoCo 3.3 or newer)",
    ending="xml",
    holds=frozenset({"armature", "damping", "friction", "offset", "coupled", "spring", "torque", "gravity"}),
    write=_write,
    remarks=(
        "Controls are the motors' torques on the joints' side; actuators take the offsets off. Their limits are "
        "those of the torque.",
    ),
)
