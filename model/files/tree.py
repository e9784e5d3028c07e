"""Reads the links and joints of a URDF file: meshes are found but not opened, transmissions are passed over."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ...common.errors import InputError
from ..inertia import InertialParameters, ten_parameters
from ..pose import Pose
from ..robot import SNAP_ANGLE, SNAP_LENGTH, Limits, Mesh
from .described import Source, expanded, package_places

_ZEROS, _ONES = "0 0 0", "1 1 1"


def meshes_of(link: ElementTree.Element, source: Path) -> tuple[Mesh, ...]:
    """Meshes of a link's visuals, in its frame; a visual that cannot be understood is passed over.

    Args:
        link: the URDF's element.
        source: the URDF.
    """
    return tuple(mesh for visual in link.findall("visual") for mesh in _mesh(visual, source))


def _mesh(visual: ElementTree.Element, source: Path) -> Iterator[Mesh]:
    element = visual.find("geometry/mesh")
    if element is None or not element.get("filename"):
        return
    origin = visual.find("origin")
    place = origin if origin is not None else ElementTree.Element("origin")
    try:
        pose = Pose.from_rpy(_three(place.get("xyz", _ZEROS)), _three(place.get("rpy", _ZEROS)))
        yield Mesh(_file(element.get("filename", ""), source), pose, _three(element.get("scale", _ONES)))
    except ValueError:  # looks are no reason to refuse a robot
        return


def _three(text: str) -> tuple[float, float, float]:
    x, y, z = map(float, text.split())
    return x, y, z


def _file(name: str, source: Path) -> str:
    """The file, or its name as written where it is not found.

    ``package://NAME/..`` is sought in the folders above the URDF and in those that ROS names by its environment.
    """
    places = _places(name, source.resolve().parent)
    return next((str(place) for place in places if place.is_file()), name)


def _places(name: str, folder: Path) -> Iterator[Path]:
    scheme, _, rest = name.partition("://")
    if not rest:
        yield folder / name
    elif scheme == "file":
        yield Path(rest)
    elif scheme in ("package", "model"):
        package, _, inside = rest.partition("/")
        yield from (place / inside for place in package_places(package, folder))


LARGEST_FILE = 5_000_000
"""Bytes; a description without its meshes comes nowhere near."""
_LARGEST = 1e9  # no length, angle or mass of an arm comes near
_UNKNOWN_EFFORT = 1e5  # N·m or N: no arm's joint comes near


@dataclass(frozen=True)
class UrdfJoint:
    """One joint as the file gives it.

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
    axis: tuple[float, float, float]
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
    root = _parsed(source.path, _text(source.path))
    if any(map(_of_xacro, root.iter())):
        root = _parsed(source.path, expanded(source))
        if left := next((element.tag for element in root.iter() if _of_xacro(element)), ""):
            raise InputError(
                f"{source.path}: xacro leaves <{left}> as it is: expand it first (xacro FILE > robot.urdf)"
            )
    if root.tag != "robot":
        raise InputError(f"{source.path}: the outermost element is <{root.tag}>, a URDF's is <robot>")
    return _Reader(str(source.path)).tree(root)


def _text(path: Path) -> str:
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise InputError(f"{path}: larger than {LARGEST_FILE // 1_000_000} MB: not a robot description")
        return path.read_bytes().decode("utf-8")
    except UnicodeDecodeError:
        raise InputError(f"{path}: not UTF-8 text: save the description as UTF-8") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None


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
    """Whether an element waits for xacro. Comments are not among the elements: expanded files keep the source's."""
    words = (element.text or "", *element.attrib.values())
    return (element.tag.startswith("{") and "xacro" in element.tag) or any("${" in word for word in words)


class _Reader:
    """Turns the elements of one file into values and names whatever does not fit."""

    def __init__(self, source: str) -> None:
        self._source = source
        self._notes: dict[str, list[str]] = {}

    def tree(self, root: ElementTree.Element) -> UrdfTree:
        links = {self._name(link, "link"): self._body(link) for link in self._unique(root, "link")}
        joints = tuple(self._joint(joint) for joint in self._unique(root, "joint"))
        for joint in joints:
            for link in (joint.parent, joint.child):
                if link not in links:
                    raise self._error(f"joint {joint.name!r}", f"no link {link!r} in the file")
        name = root.get("name") or Path(self._source).stem
        return UrdfTree(
            name,
            self._source,
            links,
            joints,
            tuple(f"{', '.join(places)}: {note}" for note, places in self._notes.items()),
            {link.get("name", ""): meshes_of(link, Path(self._source)) for link in root.findall("link")},
        )

    def _unique(self, root: ElementTree.Element, tag: str) -> Iterator[ElementTree.Element]:
        known_names: set[str] = set()
        for element in root.findall(tag):
            name = self._name(element, tag)
            if name in known_names:
                raise self._error(f"{tag} {name!r}", "given twice")
            known_names.add(name)
            yield element

    def _joint(self, element: ElementTree.Element) -> UrdfJoint:
        name = self._name(element, "joint")
        where = f"joint {name!r}"
        kind = element.get("type", "")
        mimic = element.find("mimic")
        axis = self._numbers(element.find("axis"), "xyz", (1.0, 0.0, 0.0), where)
        if kind in ("revolute", "continuous", "prismatic") and not 1e-9 < math.hypot(*axis) < _LARGEST:
            raise self._error(where, "axis has no direction")
        dynamics = element.find("dynamics")
        return UrdfJoint(
            name,
            kind,
            self._reference(element, "parent", where),
            self._reference(element, "child", where),
            self._pose(element.find("origin"), where),
            axis,
            self._limits(element.find("limit"), kind, where),
            self._optional(dynamics, "damping", where),
            self._optional(dynamics, "friction", where),
            mimic.get("joint", "another joint") if mimic is not None else "",
        )

    def _body(self, link: ElementTree.Element) -> InertialParameters | None:
        inertial = link.find("inertial")
        if inertial is None:
            return None
        where = f"link {self._name(link, 'link')!r} inertial"
        mass, inertia = inertial.find("mass"), inertial.find("inertia")
        if mass is None or inertia is None:
            raise self._error(where, "needs <mass> and <inertia>")
        xx, xy, xz, yy, yz, zz = (self._number(inertia, f"i{key}", where) for key in
                                  ("xx", "xy", "xz", "yy", "yz", "zz"))  # fmt: skip
        at = self._pose(inertial.find("origin"), where)
        inertia_com = at.R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ at.R.T
        # Files hold bodies that cannot exist; the chain's reader notes them.
        return InertialParameters(ten_parameters(self._number(mass, "value", where), at.p, inertia_com))

    def _limits(self, element: ElementTree.Element | None, kind: str, where: str) -> Limits:
        if element is None:
            return Limits()
        bounds = {
            name: self._optional(element, key, where)
            for name, key in (("speed", "velocity"), ("torque", "effort"), ("low", "lower"), ("high", "upper"))
        }
        # Many descriptions write 0 for what they do not know, or a torque that no joint has.
        speed, torque = (bounds[name] or math.inf for name in ("speed", "torque"))
        torque = torque if torque < _UNKNOWN_EFFORT else math.inf
        if speed < 0.0 or torque < 0.0:
            raise self._error(where, "velocity and effort limits must not be negative")
        return Limits(self._range(bounds["low"] or 0.0, bounds["high"] or 0.0, kind, where), speed, torque=torque)

    def _range(self, low: float, high: float, kind: str, where: str) -> tuple[float, float]:
        """Position limits, infinite where the file gives no range."""
        if kind != "continuous" and low < high:
            return low, high
        if kind in ("revolute", "prismatic"):
            self._note(where, f"position limits {low:g} to {high:g} leave no range: not used")
        return Limits().position

    def _pose(self, element: ElementTree.Element | None, where: str) -> Pose:
        xyz = self._numbers(element, "xyz", (0.0, 0.0, 0.0), where)
        rpy = self._numbers(element, "rpy", (0.0, 0.0, 0.0), where)
        return Pose.from_rpy(
            [self._special(value, None, SNAP_LENGTH, f"{where} origin xyz") for value in xyz],
            [self._special(value, math.pi / 2, SNAP_ANGLE, f"{where} origin rpy") for value in rpy],
        )

    def _special(self, value: float, step: float | None, tolerance: float, where: str) -> float:
        """An angle near a multiple of 90 degrees as that multiple, a tiny length as zero."""
        exact = 0.0 if step is None else round(value / step) * step
        if value == exact or abs(value - exact) >= tolerance:
            return value
        # A value written to seven or more digits is right as it stands.
        if abs(value - exact) > 1e-7 or step is None:
            self._note(where, f"{value:.9g} taken as {exact:.9g}")
        return exact

    def _note(self, where: str, text: str) -> None:
        """Say a thing once of all places that it holds for."""
        places = self._notes.setdefault(text, [])
        if where not in places:
            places.append(where)

    # Checks of single entries.

    def _error(self, where: str, problem: str) -> InputError:
        return InputError(f"{self._source}: {where}: {problem}")

    def _name(self, element: ElementTree.Element, tag: str) -> str:
        name = element.get("name")
        if not name:
            raise self._error(f"<{tag}>", "a name is missing")
        return name

    def _reference(self, element: ElementTree.Element, tag: str, where: str) -> str:
        named = element.find(tag)
        link = named.get("link") if named is not None else None
        if not link:
            raise self._error(where, f"<{tag} link=...> is missing")
        return link

    def _optional(self, element: ElementTree.Element | None, key: str, where: str) -> float | None:
        return None if element is None or element.get(key) is None else self._number(element, key, where)

    def _number(self, element: ElementTree.Element, key: str, where: str) -> float:
        return self._parsed([element.get(key, "")], f"{where} {key}")[0]

    def _numbers(
        self, element: ElementTree.Element | None, key: str, default: tuple[float, float, float], where: str
    ) -> tuple[float, float, float]:
        if element is None or element.get(key) is None:
            return default
        words = element.get(key, "").split()
        if len(words) != 3:
            raise self._error(f"{where} {element.tag} {key}", f"three numbers are needed, got {len(words)}")
        x, y, z = self._parsed(words, f"{where} {element.tag} {key}")
        return x, y, z

    def _parsed(self, words: Sequence[str], where: str) -> list[float]:
        try:
            values = [float(word) for word in words]
        except ValueError:
            raise self._error(where, f"{' '.join(words)[:40]!r} is not a number") from None
        if not all(abs(value) < _LARGEST for value in values):
            raise self._error(where, f"{' '.join(words)[:40]!r} is not a finite number of reasonable size")
        return values
