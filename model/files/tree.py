"""Reads the links and joints of a URDF file: meshes are found but not opened, transmissions are passed over."""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ...common.errors import InputError
from ...common.schema import naming, read_text
from ..inertia import InertialParameters, ten_parameters
from ..pose import Pose
from ..robot import SNAP_ANGLE, SNAP_LENGTH, Limits, Mesh
from .described import Source, expanded, package_places

_LARGEST_FILE = 5_000_000
"""Largest file that is read, in bytes; a description without its meshes comes nowhere near."""
_LARGEST = 1e9  # no length, angle or mass of an arm comes near
_UNKNOWN_EFFORT = 1e5  # N·m or N: no arm's joint comes near
_Three = tuple[float, float, float]
_ZEROS = (0.0, 0.0, 0.0)
_Notes = dict[str, list[str]]
"""Notes on what was made exact or left out, and where."""


@dataclass(frozen=True)
class UrdfJoint:
    """Joint of a URDF file, as the file gives it.

    Attributes:
        name, kind, parent, child: as written.
        origin: the child's frame in the parent's at the zero position.
        axis: in the child's frame.
        damping, friction: viscous [N·m·s/rad or N·s/m] and dry friction [N·m or N], None where not given.
        mimics: the joint it follows, empty for a joint of its own.
    """

    name: str
    kind: str
    parent: str
    child: str
    origin: Pose
    axis: _Three
    limits: Limits
    damping: float | None
    friction: float | None
    mimics: str


@dataclass(frozen=True)
class UrdfTree:
    """Links and joints of one file.

    Attributes:
        name: of the robot.
        source: the file, for messages.
        links: every link's body in its own frame, None where the file gives none.
        joints: in the order of the file.
        notes: what was made exact or left out.
        meshes: of every link, in its own frame.
    """

    name: str
    source: str
    links: Mapping[str, InertialParameters | None]
    joints: tuple[UrdfJoint, ...]
    notes: tuple[str, ...]
    meshes: Mapping[str, tuple[Mesh, ...]]


def read_urdf(source: str | Path | Source) -> UrdfTree:
    """Read a file, expanded by xacro where it waits for that.

    Raises:
        InputError: names the element that cannot be used.
    """
    source = source if isinstance(source, Source) else Source(Path(source))
    path = source.path
    root = _parsed(path, read_text(path, _LARGEST_FILE))
    if any(map(_of_xacro, root.iter())):
        root = _parsed(path, expanded(source))
        if left := next((element.tag for element in root.iter() if _of_xacro(element)), ""):
            raise InputError(f"{path}: xacro leaves <{left}> as it is: expand it first (xacro FILE > robot.urdf)")
    if root.tag != "robot":
        raise InputError(f"{path}: the outermost element is <{root.tag}>, a URDF's is <robot>")
    notes: _Notes = {}
    with naming(path):
        links = _named(root, "link")
        bodies = {name: _body(link, f"link {name!r} inertial", notes) for name, link in links.items()}
        joints = tuple(_joint(name, joint, notes) for name, joint in _named(root, "joint").items())
        for joint in joints:
            for link in (joint.parent, joint.child):
                if link not in links:
                    raise ValueError(f"joint {joint.name!r}: no link {link!r} in the file")
    return UrdfTree(
        root.get("name") or path.stem,
        str(path),
        bodies,
        joints,
        tuple(f"{', '.join(spots)}: {note}" for note, spots in notes.items()),
        {name: tuple(_meshes(link, path.resolve().parent)) for name, link in links.items()},
    )


def _parsed(path: Path, text: str) -> ElementTree.Element:
    # Entities can grow without bound and read other files; no robot description needs them.
    for word in ("<!DOCTYPE", "<!ENTITY"):
        if word in text:
            raise InputError(f"{path}: {word} is not accepted in a robot description: remove it")
    try:
        return ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise InputError(f"{path}: not valid XML: {error}") from None


def _of_xacro(element: ElementTree.Element) -> bool:
    """True if an element waits for xacro. Comments are no elements: expanded files keep the source's."""
    texts = (element.text or "", *element.attrib.values())
    return (element.tag.startswith("{") and "xacro" in element.tag) or any("${" in text for text in texts)


def _named(root: ElementTree.Element, tag: str) -> dict[str, ElementTree.Element]:
    """Map names to the elements of a tag."""
    named: dict[str, ElementTree.Element] = {}
    for element in root.findall(tag):
        name = element.get("name")
        if not name:
            raise ValueError(f"<{tag}>: a name is missing")
        if name in named:
            raise ValueError(f"{tag} {name!r}: given twice")
        named[name] = element
    return named


def _meshes(link: ElementTree.Element, folder: Path) -> Iterator[Mesh]:
    """Read the meshes of a link's visuals, in its frame; a visual that cannot be understood is passed over.

    ``package://NAME/..`` is sought in the folders above the URDF and in those that ROS names by its environment; a
    file that is not found keeps its name as written.
    """
    for visual in link.findall("visual"):
        element, origin = visual.find("geometry/mesh"), visual.find("origin")
        name = "" if element is None else element.get("filename", "")
        if element is None or not name:
            continue
        with suppress(ValueError):  # looks are no reason to refuse a robot
            pose = Pose.from_rpy(_triple(origin, "xyz", _ZEROS, ""), _triple(origin, "rpy", _ZEROS, ""))
            file = next((str(path) for path in _places(name, folder) if path.is_file()), name)
            yield Mesh(file, pose, _triple(element, "scale", (1.0, 1.0, 1.0), ""))


def _places(name: str, folder: Path) -> Iterator[Path]:
    scheme, _, rest = name.partition("://")
    if not rest:
        yield folder / name
    elif scheme == "file":
        yield Path(rest)
    elif scheme in ("package", "model"):
        package, _, inside = rest.partition("/")
        yield from (root / inside for root in package_places(package, folder))


def _joint(name: str, element: ElementTree.Element, notes: _Notes) -> UrdfJoint:
    where, kind, mimic = f"joint {name!r}", element.get("type", ""), element.find("mimic")
    axis = _triple(element.find("axis"), "xyz", (1.0, 0.0, 0.0), where)
    if kind in ("revolute", "continuous", "prismatic") and not 1e-9 < math.hypot(*axis) < _LARGEST:
        raise ValueError(f"{where}: axis has no direction")
    ends = {tag: "" if (end := element.find(tag)) is None else end.get("link", "") for tag in ("parent", "child")}
    for tag, link in ends.items():
        if not link:
            raise ValueError(f"{where}: <{tag} link=...> is missing")
    dynamics = element.find("dynamics")
    return UrdfJoint(
        name,
        kind,
        ends["parent"],
        ends["child"],
        _pose(element.find("origin"), where, notes),
        axis,
        _limits(element.find("limit"), kind, where, notes),
        _optional(dynamics, "damping", where),
        _optional(dynamics, "friction", where),
        mimic.get("joint", "another joint") if mimic is not None else "",
    )


def _body(link: ElementTree.Element, where: str, notes: _Notes) -> InertialParameters | None:
    inertial = link.find("inertial")
    if inertial is None:
        return None
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is None or inertia is None:
        raise ValueError(f"{where}: needs <mass> and <inertia>")
    xx, xy, xz, yy, yz, zz = (_number(inertia, f"i{key}", where) for key in ("xx", "xy", "xz", "yy", "yz", "zz"))
    at = _pose(inertial.find("origin"), where, notes)
    inertia_com = at.R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ at.R.T
    # Files hold bodies that cannot exist; the chain's reader notes them.
    return InertialParameters(ten_parameters(_number(mass, "value", where), at.p, inertia_com))


def _limits(element: ElementTree.Element | None, kind: str, where: str, notes: _Notes) -> Limits:
    """Read limits, infinite where the file gives none; many write 0 for an unknown limit, or a torque none has."""
    if element is None:
        return Limits()
    keys = ("velocity", "effort", "lower", "upper")
    speed, torque, low, high = (_optional(element, key, where) or 0.0 for key in keys)
    if speed < 0.0 or torque < 0.0:
        raise ValueError(f"{where}: velocity and effort limits must not be negative")
    position = (low, high) if kind != "continuous" and low < high else Limits().position
    if kind in ("revolute", "prismatic") and not low < high:
        _note(notes, where, f"position limits {low:g} to {high:g} leave no range: not used")
    return Limits(position, speed or math.inf, torque=torque if 0.0 < torque < _UNKNOWN_EFFORT else math.inf)


def _pose(element: ElementTree.Element | None, where: str, notes: _Notes) -> Pose:
    """Read a frame, with angles near a multiple of 90 degrees as that multiple and tiny lengths as zero."""
    exact: dict[str, list[float]] = {}
    for key, tolerance in (("xyz", SNAP_LENGTH), ("rpy", SNAP_ANGLE)):
        exact[key] = list(_triple(element, key, _ZEROS, where))
        for k, value in enumerate(exact[key]):
            special = round(value / (math.pi / 2)) * (math.pi / 2) if key == "rpy" else 0.0
            if value == special or abs(value - special) >= tolerance:
                continue
            exact[key][k] = special
            # An angle written to seven or more digits is right as it stands.
            if abs(value - special) > 1e-7 or key == "xyz":
                _note(notes, f"{where} origin {key}", f"{value:.9g} taken as {special:.9g}")
    return Pose.from_rpy(exact["xyz"], exact["rpy"])


def _note(notes: _Notes, where: str, text: str) -> None:
    """Note a thing once for all places that it holds for."""
    spots = notes.setdefault(text, [])
    if where not in spots:
        spots.append(where)


def _optional(element: ElementTree.Element | None, key: str, where: str) -> float | None:
    return None if element is None or element.get(key) is None else _number(element, key, where)


def _number(element: ElementTree.Element, key: str, where: str) -> float:
    return _numbers([element.get(key, "")], f"{where} {key}")[0]


def _triple(element: ElementTree.Element | None, key: str, default: _Three, where: str) -> _Three:
    if element is None or element.get(key) is None:
        return default
    words = element.get(key, "").split()
    if len(words) != 3:
        raise ValueError(f"{where} {element.tag} {key}: three numbers are needed, got {len(words)}")
    x, y, z = _numbers(words, f"{where} {element.tag} {key}")
    return x, y, z


def _numbers(words: Sequence[str], where: str) -> list[float]:
    try:
        values = [float(word) for word in words]
    except ValueError:
        raise ValueError(f"{where}: {' '.join(words)[:40]!r} is not a number") from None
    if not all(abs(value) < _LARGEST for value in values):
        raise ValueError(f"{where}: {' '.join(words)[:40]!r} is not a finite number of reasonable size")
    return values
