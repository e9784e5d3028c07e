"""MJCF (MuJoCo): all that a robot's description has, but for tables of springs.

A joint's armature, damping and frictionloss are its drive's; a coupled drive is a fixed tendon over both joints
with its own; an offset is the bias of the joint's actuator, whose control is the motor's torque; a spring between
two pivots is a spatial tendon between two sites. fullinertia is M11, M22, M33, M12, M13, M23 about pos in the axes
of the body, positive definite with principal moments that fulfil A + B >= C. A payload is a body inside the body
``flange``. Source: MuJoCo documentation, XML reference.
"""

from __future__ import annotations

import math
from collections import defaultdict
from functools import partial
from xml.etree.ElementTree import Element

from .... import estimation
from ....common.errors import InputError
from ....model import Pose
from ...numbers import exact, principal_axes, quaternion
from ..format import FIRST, Format, element, mjcf_inertial
from ..load import ControllerLoad, load_format
from ..robot import drive_attributes, fields, flange_of, gravity_of, moved_links

_LEAST = 1e-15  # MuJoCo's mjMINVAL: no moment of inertia may be smaller
DRIVE = {"armature": "armature", "damping": "damping", "friction": "frictionloss"}
"""Attributes of a joint or a tendon for its drive."""


@partial(
    Format,
    title="MJCF (MuJoCo 3.3 or newer)",
    source="MuJoCo XML reference",
    holds=frozenset({"armature", "damping", "friction", "offset", "coupled", "spring", "torque", "gravity"}),
    remarks=(
        "Controls are motor torques on the joint side, with the torque limits as their range; torque offsets are "
        "the actuators' bias.",
    ),
    first_line=FIRST,
)
def _write(whole: estimation.WholeRobot) -> Element:
    spring, flange = whole.robot.spring, flange_of(whole.robot)
    tendons, motors = coupled_tendon(whole, whole.joint_names), list[Element]()
    moved, sites = moved_links(whole, apart=False), defaultdict[int, list[Element]](list)  # of links, 0: the base
    if spring is not None and not spring.table:
        values = {"name": "spring", "stiffness": exact(spring.stiffness), "springlength": exact(spring.length)}
        ends = (element("site", {"site": f"spring_{end}"}) for end in ("fixed", "moving"))
        tendons.append(element("spatial", values, *ends))
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
            "body", {"name": each.link.link} | _pose(each.pose),
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
    outer.append(element("site", {"name": flange[0]} | _pose(flange[1])))
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


def custom(whole: estimation.WholeRobot) -> Element:
    """Marks as texts that MuJoCo keeps when it writes a model, such as "dynident:link3:mass"."""
    marked: dict[str, estimation.Labelled] = {}
    for link, joint, drive in zip(whole.links, whole.joint_names, whole.drives, strict=True):
        marked |= {f"{link.link}:{name}": label for name, label in (link.numbers | link.parameters).items()}
        marked |= {f"{joint}:{name}": label for name, label in drive.items()}
    marked |= {f"coupled drive:{name}": label for name, label in whole.coupled.items()}
    made = element("custom")
    for name, label in marked.items():
        data = " ".join(f"{key}={word}" for key, word in fields(label).items())
        made.append(element("text", {"name": f"dynident:{name}", "data": data}))
    return made


def _pose(pose: Pose) -> dict[str, str]:
    return {"pos": exact(pose.origin), "quat": exact(quaternion(pose.R))}


def coupled_tendon(whole: estimation.WholeRobot, joints: tuple[str, ...]) -> list[Element]:
    """The drive that turns with the sum of two joints, which ``joints`` names; none without one."""
    coupling = whole.robot.coupling
    if coupling is None or not whole.coupled:
        return []
    # As the paper prints it the friction has no place.
    left = {} if coupling.coulomb == "sum" else {"friction"}
    drive = {quantity: label for quantity, label in whole.coupled.items() if quantity not in left}
    both = (element("joint", {"joint": joints[joint - 1], "coef": "1"}) for joint in coupling.joints)
    return [element("fixed", {"name": "coupled_drive"} | drive_attributes(drive, DRIVE), *both)]


@load_format(
    title="MJCF (copy the body payload into the body of your flange)",
    source="MuJoCo XML reference, body/inertial",
    order="pos x, y, z; fullinertia M11, M22, M33, M12, M13, M23",
    in_part="the inertia is zero, a point mass; a moving link needs inertia of its own",
)
def _write_payload(load: ControllerLoad) -> Element:
    least = float(principal_axes(load.inertia)[0].min())
    if not load.point_mass and least < _LEAST:
        raise InputError(f"the smallest moment of inertia is {least:.2g} kg m^2: MuJoCo refuses so small a body")
    body = element("body", {"name": "payload"}, mjcf_inertial(load.mass, load.com, load.inertia))
    world = element("worldbody", {}, element("body", {"name": "flange"}, body))
    return element("mujoco", {"model": "payload"}, world)
