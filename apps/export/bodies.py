"""Bodies as simulators hold them, and a payload in their formats.

MJCF: a body inside the body ``flange``. SDFormat: a model of one link, its origin at the flange; without entries of
the inertia it takes 1 kg m^2, so a point mass needs explicit zeros. URDF: a link fixed to the link ``tool0``. USD:
a prim whose origin is the flange, in the stage's units, for referencing a stage converts nothing; a mass or
diagonalInertia of zero is ignored. The inertial's frame is not turned but in USD. Sources: those of ``simulators``.
"""

import json
import math
from collections.abc import Iterable
from xml.etree.ElementTree import Element

from ...common import Array, InputError
from ...model import Pose
from ..numbers import ENTRIES, exact, inertia_entries, principal_axes, quaternion
from .format import element, texts
from .load import ControllerLoad, listed, load_format, number

_LEAST_MOMENT = 1e-15  # MuJoCo's mjMINVAL: no moment of inertia may be smaller


def urdf_inertial(mass: float, com: Array, inertia: Array) -> Element:
    """A body in URDF [kg, m, kg m^2]: entries of the matrix about the centre of mass, in the axes of the link."""
    origin, entries = element("origin", {"xyz": exact(com), "rpy": "0 0 0"}), inertia_entries(inertia)
    return element("inertial", {}, origin, element("mass", {"value": exact(mass)}), element("inertia", entries))


def sdf_inertial(mass: float, com: Array, inertia: Array) -> Element:
    """A body in SDFormat; the pose of its inertial frame is not turned."""
    pose = texts({"pose": f"{exact(com)} 0 0 0", "mass": exact(mass)})
    return element("inertial", {}, *pose, element("inertia", {}, *texts(inertia_entries(inertia))))


def mjcf_inertial(mass: float, com: Array, inertia: Array) -> Element:
    """A body in MJCF: entries M11, M22, M33, M12, M13, M23 of the matrix."""
    moments = {"fullinertia": exact(inertia[ENTRIES])} if inertia.any() else {"diaginertia": "0 0 0"}
    return element("inertial", {"pos": exact(com), "mass": exact(mass)} | moments)


def joint_ends(parent: str, child: str, pose: Pose) -> list[Element]:
    """Links of a joint in URDF, and its place in the first one."""
    return [
        element("parent", {"link": parent}),
        element("child", {"link": child}),
        element("origin", {"xyz": exact(pose.origin), "rpy": exact(pose.rpy)}),
    ]


def stage(root: str, unit: str, prims: Iterable[str]) -> str:
    """A stage of USD with the ``unit`` of length [m]; the prim ``root`` is taken by default."""
    about = [f'defaultPrim = "{root}"', "kilogramsPerUnit = 1", f"metersPerUnit = {unit}", 'upAxis = "Z"']
    return "\n".join(["(", *indented(about), ")", "", *prims])


def prim(kind: str, inside: Iterable[str], metadata: Iterable[str] = ()) -> list[str]:
    """Lines of a prim of USD."""
    return [f"def {kind} (", *indented(metadata), ")", "{", *indented(inside), "}"]


def indented(lines: Iterable[str]) -> list[str]:
    """Lines that stand four blanks further in."""
    return [f"    {line}" for line in lines]


def schemas(*names: str) -> str:
    """Metadata that applies schemas to a prim."""
    return f"prepend apiSchemas = [{', '.join(map(json.dumps, names))}]"


@load_format(
    title="MJCF (copy the body payload into the body of your flange)",
    source="MuJoCo XML reference, body/inertial",
    order="pos x, y, z; fullinertia M11, M22, M33, M12, M13, M23",
    in_part="the inertia is zero, a point mass; a moving link needs inertia of its own",
)
def _mjcf(load: ControllerLoad) -> Element:
    least = float(principal_axes(load.inertia)[0].min())
    if not load.point_mass and least < _LEAST_MOMENT:
        raise InputError(f"the smallest moment of inertia is {least:.2g} kg m^2: MuJoCo refuses so small a body")
    body = element("body", {"name": "payload"}, mjcf_inertial(load.mass, load.com, load.inertia))
    world = element("worldbody", {}, element("body", {"name": "flange"}, body))
    return element("mujoco", {"model": "payload"}, world)


@load_format(
    title="SDFormat (fix the link payload to the flange of your robot, origin on origin)",
    source="sdformat.org/spec, inertial",
    order="pose x, y, z, roll, pitch, yaw; ixx, ixy, ixz, iyy, iyz, izz, entries of the matrix",
    in_part="the inertia is zero, a point mass (left out it would be 1 kg m^2); simulators may ask for one of "
    "your own",
)
def _sdf(load: ControllerLoad) -> Element:
    link = element("link", {"name": "payload"}, sdf_inertial(load.mass, load.com, load.inertia))
    return element("sdf", {"version": "1.7"}, element("model", {"name": "payload"}, link))


@load_format(
    title="URDF (copy joint and link payload into your robot, whose flange link is tool0 here)",
    source="wiki.ros.org/urdf/XML/link",
    order="ixx, ixy, ixz, iyy, iyz, izz, entries of the matrix (ixy = -integral of x y dm)",
    in_part="the inertia is zero, a point mass; simulators may ask for one of your own",
)
def _urdf(load: ControllerLoad) -> Element:
    joint = element("joint", {"name": "tool0-payload", "type": "fixed"}, *joint_ends("tool0", "payload", Pose()))
    link = element("link", {"name": "payload"}, urdf_inertial(load.mass, load.com, load.inertia))
    return element("robot", {"name": "payload"}, element("link", {"name": "tool0"}), joint, link)


@load_format(
    title="USD PhysicsMassAPI (stage units; copy into a stage of the same units)",
    source="OpenUSD, UsdPhysicsMassAPI",
    holds=frozenset({"products", "units"}),
    reference="principal moments about the centre of mass, their axes turned by principalAxes out of the prim's",
    order="centerOfMass x, y, z; diagonalInertia along the principal axes; principalAxes w, x, y, z",
    units="kg (kilogramsPerUnit = 1), length in metersPerUnit, inertia in kg times that squared",
    in_part="no diagonalInertia: the simulator makes one from the shapes",
    first_line="#usda 1.0",
)
def _usd(load: ControllerLoad) -> str:
    (moments, axes), unit, digits = principal_axes(load.inertia), load.meters_per_unit, load.moment_digits
    digits = None if digits is None else digits + round(2.0 * math.log10(unit))
    lines = [
        f"float physics:mass = {number(load.mass)}",
        f"point3f physics:centerOfMass = ({listed(load.com / unit)})",
        f"float3 physics:diagonalInertia = ({listed(moments / unit**2, digits)})",
        f"quatf physics:principalAxes = ({listed(quaternion(axes))})",
    ]
    about = [schemas("PhysicsRigidBodyAPI", "PhysicsMassAPI")]
    return stage("payload", number(unit), prim('Xform "payload"', lines[: 2 if load.point_mass else 4], about))


FORMATS = {"mjcf": _mjcf, "sdf": _sdf, "urdf": _urdf, "usd": _usd}
"""Formats of a payload."""
