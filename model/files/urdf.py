"""Reads a serial robot from a URDF file: its links and joints, and of them the chain from base to flange.

Meshes are found but not opened, transmissions are passed over. Files of xacro are expanded; names of
robot_descriptions are found in the cache of that package.
"""

import math
import os
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from dataclasses import replace
from difflib import get_close_matches
from importlib import import_module
from io import StringIO
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from ...common import InputError, listed
from ...common.schema import naming, read_text
from ..frames import JointAxis, frames_at, modified_dh
from ..inertia import InertialParameters, Pose, symmetric, ten_parameters
from ..motion import Processing, usual_slow_speed
from ..robot import Limits, Links, Mesh, Robot, snapped

_LARGEST_FILE = 5_000_000  # bytes; a description without its meshes comes nowhere near
_LARGEST = 1e9  # no length, angle or mass of an arm comes near
_UNKNOWN_EFFORT = 1e5  # N·m or N: no arm's joint comes near
_FAR = 20.0  # m: no arm is as large
_DIGITS = 1e-3  # of the largest moment of inertia: what rounding in a file may do to the others
_MOVES = ("revolute", "continuous", "prismatic")
_FLANGES = (r"(.*[_-])?tool0", r"(.*[_-])?flange", r"(panda|fer|fr3|fp3)_link8")
"""Patterns of the names of the maker's flange: ROS-Industrial's, then Franka's; the first that fits counts."""
_UNKNOWN = (math.nan,)
_ZEROS = (0.0, 0.0, 0.0)
_Element = ElementTree.Element
_Notes = dict[str, dict[str, None]]  # notes on what was made exact or left out, and at which places, each once
_ENDING = "_description"  # of names of robot_descriptions: ``panda_description``
_INSTALL = "pip install 'dynident[robots]'"


class Source(NamedTuple):
    """File of a description; of a xacro file its arguments, and packages that it names besides its own."""

    path: Path
    arguments: Mapping[str, str] = {}
    packages: Mapping[str, str] = {}


class UrdfJoint(NamedTuple):
    """Joint of a URDF file."""

    name: str
    kind: str
    parent: str
    child: str
    origin: Pose  # the child's frame in the parent's at the zero position
    axis: tuple[float, ...]  # in the child's frame
    limits: Limits
    friction: Mapping[str, float]  # FV [N·m·s/rad or N·s/m] and FS [N·m or N], as far as they are given
    mimics: str  # the joint it follows, empty for a joint of its own


class Urdf(NamedTuple):
    """Links and joints of one file."""

    name: str  # of the robot
    source: str  # the file, for messages
    # every link's body in its own frame, None where the file gives none
    links: Mapping[str, InertialParameters | None]
    joints: tuple[UrdfJoint, ...]  # in the order of the file
    children: Mapping[str, Sequence[UrdfJoint]]  # of every link, the joints that it carries
    above: Mapping[str, UrdfJoint]  # of every link but the first ones, the joint that carries it
    notes: tuple[str, ...]  # what was made exact or left out
    meshes: Mapping[str, tuple[Mesh, ...]]  # of every link, in its own frame

    def fixed_to(self, link: str, pose: Pose) -> list[tuple[str, Pose]]:
        """List a link and all that is fixed to it, with their frames where the link's is at ``pose``."""
        fixed = [(link, pose)]
        for name, at in fixed:  # grows while it is walked
            fixed += [(joint.child, at @ joint.origin) for joint in self.children[name] if joint.kind == "fixed"]
        return fixed


def load_urdf(path: str | Path | Source, base: str | None = None, tip: str | None = None) -> Robot:
    """Read a serial robot from a URDF or xacro file.

    Fixed joints are merged, meshes are not read. Gravity points along -z of the base link. Joint positions count
    as in the file. Inertias are read into ``Robot.parameters``, as a prior.

    Args:
        base: first link of the chain; the root by default.
        tip: the flange's link; by default the only link at an end of the tree that a joint moves.
    """
    tree = read_urdf(path)
    with naming(tree.source):
        for link in (base, tip):
            if link is not None and link not in tree.links:
                raise ValueError(f"chain = BASE:TIP: no link {link!r}: the links are {listed([*tree.links], 30)}")
        roots = [name for name in tree.links if name not in tree.above] if base is None else [base]
        if not roots:
            raise ValueError("no links in the file")
        if len(roots) > 1:
            chosen = f"set chain to BASE:, BASE one of {listed(roots, 30)}"
            raise ValueError(f"{len(roots)} links have no parent: {chosen}")
        first, by_convention = roots[0], list[str]()
        last = _tip(tree, first, by_convention) if tip is None else tip
        moving, flange = _chain(tree, first, last)
        axes = []
        for joint, pose in moving:
            slides, direction = joint.kind == "prismatic", tuple((pose.R @ np.array(joint.axis)).tolist())
            axes.append(JointAxis("prismatic" if slides else "revolute", direction, pose.origin, joint.limits))
        robot = modified_dh(axes, flange)
        far = [
            f"axes {number - 1} and {number} are almost parallel (a calibrated description?): their common normal "
            f"lies {away:.3g} m away, and parameters lose digits; the nominal description has them parallel"
            for number, joint in enumerate(robot.joints, start=1)
            if (away := max(abs(joint.d), abs(joint.r))) > _FAR
        ]
        frames = frames_at(robot, [0.0] * robot.n)[1:-1]
        poses = tuple(frame.inverse() @ pose for frame, (_, pose) in zip(frames, moving, strict=True))
        names = tuple(joint.child for joint, _ in moving)
        looks = (
            [mesh._replace(pose=at @ mesh.pose) for part, at in tree.fixed_to(*link) for mesh in tree.meshes[part]]
            for link in zip((first, *names), (robot.base, *poses), strict=True)
        )
        parameters, left_out = _parameters(tree, [joint for joint, _ in moving], poses)
        file, is_flange = Path(tree.source).name, any(re.fullmatch(pattern, last) for pattern in _FLANGES[::2])
        return replace(
            robot,
            name=re.sub(r"\s+", "_", tree.name.strip()) or "robot",
            # The axes of a link "flange" are not the controller's: its x points out.
            payload_frame=f"{'flange: ' if is_flange else ''}link {last} of {file}",
            links=Links(names, poses, tuple(x.name for x, _ in moving), first, last, tuple(map(tuple, looks))),
            processing=Processing(slow_speed=usual_slow_speed([joint.revolute for joint in robot.joints])),
            parameters=parameters,
            title=f"{tree.name} ({file}, {first} to {last})",
            snapped=(*by_convention, *tree.notes, *left_out, *far, *robot.snapped),
        )


def _tip(tree: Urdf, base: str, notes: list[str]) -> str:
    """Find the flange's link, and note where it was one of several by its name."""
    fixed, below = {name for name, _ in tree.fixed_to(base, Pose())}, [base]
    for link in below:  # grows while it is walked
        below += [joint.child for joint in tree.children[link]]
    moved = [link for link in below if link not in fixed]
    ends = sorted(link for link in moved if not tree.children[link])
    if not ends:
        raise ValueError(f"no joint moves anything from link {base!r} on: give another BASE (chain BASE:TIP)")
    if len(ends) == 1:
        return ends[0]
    for pattern in _FLANGES:
        if named := [link for link in moved if re.fullmatch(pattern, link)]:
            break
    if len(named) != 1:  # none, or several arms have one each
        raise ValueError(f"several chains end in a link: set chain to :TIP, TIP one of {listed(ends, 30)}")
    ways = f"ends are {listed(ends, 30)}: chain = :TIP chooses"
    notes.append(f"link {named[0]!r} is taken as the flange by its name; {ways}")
    return named[0]


def _chain(tree: Urdf, base: str, tip: str) -> tuple[list[tuple[UrdfJoint, Pose]], Pose]:
    """Find the moving joints from base to tip with their frames, and the tip's, in the base at zero position."""
    path, link = list[UrdfJoint](), tip
    while link != base:
        if link not in tree.above:
            raise ValueError(f"no chain leads from {base!r} down to {tip!r}: swap or change them")
        path.append(tree.above[link])
        link = path[-1].parent
    pose, moving, advice = Pose(), [], "choose another chain BASE:TIP"
    for joint in reversed(path):
        pose = pose @ joint.origin
        if joint.kind in _MOVES and not joint.mimics:
            moving.append((joint, pose))
        elif joint.kind in _MOVES:
            fault = f"mimics {joint.mimics!r}: coupled joints of a URDF are not supported"
            raise ValueError(f"joint {joint.name!r} {fault}; {advice}")
        elif joint.kind != "fixed":
            needed = "a chain of revolute, continuous, prismatic and fixed joints is needed"
            raise ValueError(f"joint {joint.name!r} is {joint.kind or 'of no kind'!r}: {needed}; {advice}")
    if not moving:
        raise ValueError(f"no joint moves between base and tip; {advice}")
    return moving, pose


def _parameters(
    tree: Urdf, chain: Sequence[UrdfJoint], poses: Sequence[Pose]
) -> tuple[dict[str, float], list[str]]:
    values: dict[str, float] = {}
    notes: list[str] = []
    for j, (moving, at) in enumerate(zip(chain, poses, strict=True), start=1):
        vectors = []
        for name, pose in tree.fixed_to(moving.child, at):
            if (body := tree.links[name]) is not None:
                vectors.append(body.moved(pose.R, pose.p).vector)
                # A link without mass and inertia only carries others.
                a, b, c = np.linalg.eigvalsh(body.inertia_com) if body.mass else np.zeros(3)
                if body.mass < 0.0 or (body.mass == 0.0 and body.vector.any()):
                    fault = f"a mass of {body.mass:g} kg and this inertia"
                    notes.append(f"link {name!r}: no body has {fault}: correct the file")
                elif a + b < (1.0 - _DIGITS) * c or a < -_DIGITS * c:
                    fault = f"these principal moments of inertia: {a:.3g}, {b:.3g}, {c:.3g} kg m^2"
                    why = "the largest exceeds the sum of the others, or one is negative"
                    notes.append(f"link {name!r}: no body has {fault} ({why}): correct the file")
            for joint in tree.children[name]:
                if joint.kind != "fixed" and joint not in chain:
                    notes.append(f"joint {joint.name!r} is not of the chain: it and what hangs on it are left out")
        if vectors:
            values |= InertialParameters(np.sum(vectors, axis=0)).named(str(j))
        values |= {f"{kind}{j}": value for kind, value in moving.friction.items()}
    return values, notes


def read_urdf(source: str | Path | Source) -> Urdf:
    """Read a file, expanded by xacro where it waits for that."""
    source = source if isinstance(source, Source) else Source(Path(source))
    path = source.path
    root = _parsed(path, read_text(path, _LARGEST_FILE))
    if _of_xacro(root):
        root = _parsed(path, expanded(source))
        if left := _of_xacro(root):
            raise InputError(f"{path}: xacro leaves <{left}> as it is: expand it first (xacro FILE > robot.urdf)")
    if root.tag != "robot":
        raise InputError(f"{path}: the outermost element is <{root.tag}>, a URDF's is <robot>")
    notes: _Notes = {}
    with naming(path):
        links = _named(root, "link")
        bodies = {name: _body(link, f"link {name!r} inertial", notes) for name, link in links.items()}
        joints = tuple(_joint(name, joint, notes) for name, joint in _named(root, "joint").items())
        children: dict[str, list[UrdfJoint]] = {name: [] for name in links}
        above: dict[str, UrdfJoint] = {}
        for joint in joints:
            for link in (joint.parent, joint.child):
                if link not in children:
                    raise ValueError(f"joint {joint.name!r}: no link {link!r} in the file")
            if (other := above.setdefault(joint.child, joint)) is not joint:
                both = f"link {joint.child!r} is the child of joints {other.name!r} and {joint.name!r}"
                raise ValueError(f"{both}: closed loops are not supported")
            children[joint.parent].append(joint)
        reached = [name for name in links if name not in above]
        for name in reached:  # grows while it is walked
            reached += [joint.child for joint in children[name]]
        if ring := [name for name in links if name not in set(reached)]:
            raise ValueError(f"link {ring[0]!r} is its own ancestor: closed loops are not supported")
    told = tuple(f"{', '.join(spots)}: {note}" for note, spots in notes.items())
    meshes = {name: tuple(_meshes(link, path.resolve().parent)) for name, link in links.items()}
    return Urdf(root.get("name") or path.stem, str(path), bodies, joints, children, above, told, meshes)


def _parsed(path: Path, text: str) -> _Element:
    # Entities can grow without bound and read other files; no robot description needs them.
    for word in ("<!DOCTYPE", "<!ENTITY"):
        if word in text:
            raise InputError(f"{path}: {word} is not accepted in a robot description: remove it")
    try:
        return ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise InputError(f"{path}: not valid XML: {error}") from None


def _of_xacro(root: _Element) -> str:
    """Tag of an element that waits for xacro, empty without one.

    What stands in elements of simulators and drives is not read. Comments are no elements: expanded files keep the
    source's.
    """
    read = [root, *(element for part in root if part.tag in ("link", "joint") for element in part.iter())]
    texts = ((element, (element.text or "", *element.attrib.values())) for element in read)
    waiting = [element for element, own in texts if any("${" in text for text in own)]
    waiting += [element for element in (*root, *read) if element.tag.startswith("{") and "xacro" in element.tag]
    return waiting[0].tag if waiting else ""


def _named(root: _Element, tag: str) -> dict[str, _Element]:
    named: dict[str, _Element] = {}
    for element in root.findall(tag):
        name = element.get("name")
        if not name:
            raise ValueError(f"<{tag}>: a name is missing")
        if name in named:
            raise ValueError(f"{tag} {name!r}: given twice")
        named[name] = element
    return named


def _meshes(link: _Element, folder: Path) -> Iterator[Mesh]:
    """Read the meshes of a link's visuals, in its frame; what cannot be understood is passed over.

    ``package://NAME/..`` is sought at ``package_places``; a file that is not found keeps its name as written.
    """
    for visual in link.findall("visual"):
        element, origin = visual.find("geometry/mesh"), visual.find("origin")
        name = "" if element is None else element.get("filename", "")
        if not name:
            continue
        scheme, _, rest = name.partition("://")
        places = [folder / name if not rest else Path(rest)]
        if scheme in ("package", "model"):
            package, _, inside = rest.partition("/")
            places = [root / inside for root in package_places(package, folder)]
        with suppress(ValueError):  # looks are no reason to refuse a robot
            pose = Pose.from_rpy(_numbers(origin, "xyz", _ZEROS), _numbers(origin, "rpy", _ZEROS))
            x, y, z = _numbers(element, "scale", (1.0, 1.0, 1.0))
            yield Mesh(next((str(path) for path in places if path.is_file()), name), pose, (x, y, z))


def _joint(name: str, element: _Element, notes: _Notes) -> UrdfJoint:
    where, kind, mimic = f"joint {name!r}", element.get("type", ""), element.find("mimic")
    axis = _numbers(element.find("axis"), "xyz", (1.0, 0.0, 0.0), where)
    if kind in _MOVES and not 1e-9 < math.hypot(*axis) < _LARGEST:
        raise ValueError(f"{where}: axis has no direction")
    dynamics = element.find("dynamics")
    rubs = {x: _numbers(dynamics, key, _UNKNOWN, where)[0] for x, key in (("FV", "damping"), ("FS", "friction"))}
    friction = {x: value for x, value in rubs.items() if not math.isnan(value)}
    ends = {tag: "" if (end := element.find(tag)) is None else end.get("link", "") for tag in ("parent", "child")}
    for tag, link in ends.items():
        if not link:
            raise ValueError(f"{where}: <{tag} link=...> is missing")
    # Many files write 0 for an unknown limit, or a torque that no joint has.
    keys, limits = ("velocity", "effort", "lower", "upper"), element.find("limit")
    speed, torque, low, high = (_numbers(limits, key, (0.0,), where)[0] for key in keys)
    if speed < 0.0 or torque < 0.0:
        raise ValueError(f"{where}: velocity and effort limits must not be negative")
    if limits is not None and kind in ("revolute", "prismatic") and not low < high:
        notes.setdefault(f"position limits {low:g} to {high:g} leave no range: not used", {})[where] = None
    position = (low, high) if kind != "continuous" and low < high else Limits().position
    reach = Limits(position, speed or math.inf, torque=torque if 0.0 < torque < _UNKNOWN_EFFORT else math.inf)
    mimics, at = "" if mimic is None else mimic.get("joint", "another joint"), element.find("origin")
    origin = _pose(at, where, notes)
    return UrdfJoint(name, kind, ends["parent"], ends["child"], origin, axis, reach, friction, mimics)


def _body(link: _Element, where: str, notes: _Notes) -> InertialParameters | None:
    inertial = link.find("inertial")
    if inertial is None:
        return None
    inertia = inertial.find("inertia")
    entries = [_numbers(inertia, f"i{key}", _UNKNOWN, where)[0] for key in ("xx", "xy", "xz", "yy", "yz", "zz")]
    (mass,) = _numbers(inertial.find("mass"), "value", _UNKNOWN, where)
    if not np.isfinite([mass, *entries]).all():
        raise ValueError(f"{where}: needs <mass> and <inertia> with all their numbers")
    at = _pose(inertial.find("origin"), where, notes)
    # Files hold bodies that cannot exist: the chain's are noted.
    return InertialParameters(ten_parameters(mass, at.p, at.R @ symmetric(entries) @ at.R.T))


def _pose(element: _Element | None, where: str, notes: _Notes) -> Pose:
    """Read a frame, with angles near a multiple of 90 degrees as that multiple and tiny lengths as zero."""
    exact = []
    for key in ("xyz", "rpy"):
        values = _numbers(element, key, _ZEROS, where)
        exact.append([snapped(value, angle=key == "rpy") for value in values])
        for value, special in zip(values, exact[-1], strict=True):
            # An angle written to seven or more digits is right as it stands.
            if abs(value - special) > (1e-7 if key == "rpy" else 0.0):
                notes.setdefault(f"{value:.9g} taken as {special:.9g}", {})[f"{where} origin {key}"] = None
    return Pose.from_rpy(*exact)


def _numbers(element: _Element | None, key: str, default: tuple[float, ...], where: str = "") -> tuple[float, ...]:
    """Read the numbers of an attribute, as many as ``default`` has, which stands where there is none."""
    if element is None or (text := element.get(key)) is None:
        return default
    spot, words = f"{where} {element.tag} {key}", text.split()
    if len(words) != len(default):
        count = "three numbers are" if len(default) == 3 else "one number is"
        raise ValueError(f"{spot}: {count} needed, got {len(words)}")
    try:
        values = tuple(map(float, words))
    except ValueError:
        raise ValueError(f"{spot}: {text.strip()[:40]!r} is not a number") from None
    if not all(abs(value) < _LARGEST for value in values):
        raise ValueError(f"{spot}: {text.strip()[:40]!r} is not a finite number of reasonable size")
    return values


def described(name: str) -> Source:
    """Find the URDF or xacro file of a name of robot_descriptions in the cache of that package; fetch nothing.

    Raises InputError if the package is not installed, has no such URDF, or the file is not in its cache.
    """
    try:
        from robot_descriptions import DESCRIPTIONS, _repositories
    except ImportError:
        raise InputError(f"no robot {name!r} is shipped; for names of robot_descriptions: {_INSTALL}") from None
    known = [key for key, about in DESCRIPTIONS.items() if about.has_urdf]
    if name not in known:
        near = get_close_matches(name.removesuffix(_ENDING), [key.removesuffix(_ENDING) for key in known], 3, 0.6)
        meant = " or ".join(repr(f"{key}{_ENDING}") for key in near)
        hint = f"did you mean {meant}?" if near else "'robot_descriptions list' shows them"
        raise InputError(f"no robot {name!r}, nor a URDF of that name in robot_descriptions: {hint}")
    cache = Path(os.environ.get("ROBOT_DESCRIPTIONS_CACHE", "~/.cache/robot_descriptions")).expanduser()

    def cached(repository: str, commit: str | None = None) -> str:
        own = _repositories.REPOSITORIES[repository].cache_path
        folder = cache / (own if commit is None else f"{own}-{commit}/{own}")
        if not folder.is_dir():
            fault = f"{name}: not in the cache of robot_descriptions, {folder} is missing"
            pull = f"run 'robot_descriptions pull {name}' once, where there is a network"
            raise InputError(f"{fault}: {pull}, or give the path of a URDF")
        return str(folder)

    # A description's module tells where its files are, and clones them as it is imported: not here.
    module = f"robot_descriptions.{name}"
    with _standing_in("robot_descriptions._cache", clone_to_cache=cached):
        sys.modules.pop(module, None)
        about = import_module(module)
        del sys.modules[module]  # the next one may find another cache
    path = Path(getattr(about, "URDF_PATH", None) or about.XACRO_PATH)
    if not path.is_file():
        fault = f"{path} is missing in the cache of robot_descriptions"
        raise InputError(f"{name}: {fault}: delete {cache} and pull again")
    packages = {path.name: str(path) for path in (Path(about.PACKAGE_PATH), Path(about.REPOSITORY_PATH))}
    return Source(path, getattr(about, "XACRO_ARGS", {}), packages | getattr(about, "XACRO_PACKAGE_PATHS", {}))


def expanded(source: Source) -> str:
    """Expand a xacro file to URDF; InputError if the package xacro is not installed or does not take the file."""
    path, arguments, packages = source
    try:
        import xacro
    except ImportError:
        advice = "or expand it first (xacro FILE > robot.urdf)"
        raise InputError(f"{path}: a xacro file: {_INSTALL}, {advice}") from None

    def find(package: str) -> str:
        own = packages.get(package)
        for place in (Path(own),) if own else package_places(package, path.resolve().parent):
            if place.is_dir():
                return str(place)
        raise LookupError(f"package {package!r} is not found above the file, nor by ROS_PACKAGE_PATH")

    try:
        finding = _standing_in("ament_index_python.packages", get_package_share_directory=find)
        with finding, redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            return str(xacro.process_file(str(path), mappings=dict(arguments)).toxml())
    except Exception as error:  # it evaluates Python of the file's own: anything may come
        message = " ".join(str(error).split()) or type(error).__name__
        advice = "expand it first (xacro FILE ARGUMENT:=VALUE > robot.urdf)"
        raise InputError(f"{path}: xacro failed ({message}): {advice}") from None


def package_places(package: str, folder: Path) -> Iterator[Path]:
    """List where a ROS package may be: in the folders above a file, and in those of ROS's environment."""
    for above in (folder, *folder.parents):
        yield above / package
        if above.name == package:
            yield above
    for root in filter(None, os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)):
        yield from (Path(root) / package, Path(root).parent / package)
    for root in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
        yield Path(root) / "share" / package


@contextmanager
def _standing_in(name: str, **functions: Any) -> Iterator[None]:
    """Replace a module by one that holds these functions only, within the block."""
    before, sys.modules[name] = sys.modules.get(name), ModuleType(name)
    vars(sys.modules[name]).update(functions)
    try:
        yield
    finally:
        del sys.modules[name]
        if before is not None:
            sys.modules[name] = before
