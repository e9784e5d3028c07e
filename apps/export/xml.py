"""Elements of XML that several formats have, and bodies as URDF, SDFormat and MJCF hold them."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any
from xml.etree.ElementTree import Element, indent, tostring

from ...common.arrays import Array
from ..numbers import exact, inertia_entries, six

FIRST = '<?xml version="1.0" encoding="utf-8"?>'
COMMENT = ("<!-- ", " -->")
DYNIDENT = "urn:dynident"  # namespace of the elements beside the standard ones
_NONE: Mapping[str, str] = MappingProxyType({})


def element(tag: str, values: Mapping[str, str] = _NONE, *inside: "Element[Any] | str") -> Element:
    """An element, its attributes, and what stands in it."""
    made = Element(tag, dict(values))
    for part in inside:
        if isinstance(part, str):
            made.text = part
        else:
            made.append(part)
    return made


def texts(values: Mapping[str, str]) -> list[Element]:
    """Elements that hold a text each, by their tags."""
    return [element(tag, _NONE, text) for tag, text in values.items()]


def xml_text(root: Element) -> str:
    """An element as text, indented."""
    indent(root)
    return tostring(root, encoding="unicode").replace(" />", "/>")


def urdf_inertial(mass: float, com: Array, inertia: Array) -> Element:
    """A body in URDF [kg, m, kg m^2]: entries of the matrix about the centre of mass, in the axes of the link."""
    return element(
        "inertial", _NONE,
        element("origin", {"xyz": exact(com), "rpy": "0 0 0"}),
        element("mass", {"value": exact(mass)}),
        element("inertia", inertia_entries(inertia)),
    )  # fmt: skip


def sdf_inertial(mass: float, com: Array, inertia: Array) -> Element:
    """A body in SDFormat; the pose of its inertial frame is not turned."""
    pose = texts({"pose": f"{exact(com)} 0 0 0", "mass": exact(mass)})
    return element("inertial", _NONE, *pose, element("inertia", _NONE, *texts(inertia_entries(inertia))))


def mjcf_inertial(mass: float, com: Array, inertia: Array) -> Element:
    """A body in MJCF: entries M11, M22, M33, M12, M13, M23 of the matrix."""
    moments = {"fullinertia": exact(six(inertia))} if inertia.any() else {"diaginertia": "0 0 0"}
    return element("inertial", {"pos": exact(com), "mass": exact(mass)} | moments)
