"""Identified numbers in a user's own model, matched by names of joints and moved into its frames.

Of its XML some elements change: all else stays, byte for byte.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from typing import Any, NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Comment, Element
from xml.sax.saxutils import quoteattr

import numpy as np

from ...common import Array, InputError
from ...common.schema import read_text
from ...estimation.possible.whole_robot import WholeRobot
from ...model import InertialParameters, Pose
from ...model.files.urdf import read_urdf
from ...model.frames import frames_at
from ..extras import mujoco_model
from .format import element, plain, xml_text
from .load import mjcf_inertial, urdf_inertial
from .robot import drive_attributes, moved_links
from .simulators import DRIVE, coupled_tendon, custom

FAR = 0.005  # m: how far a joint's axis may lie beside the robot's own; descriptions round lengths to a millimetre
TURNED = math.radians(0.5)  # by how much it may be turned
_TOKEN = re.compile(
    r"<!--.*?-->|<\?.*?\?>|<!\[CDATA\[.*?\]\]>|"
    r"<(?P<close>/?)(?P<tag>[^\s/>!?]+)(?P<values>(?:[^\"'>]|\"[^\"]*\"|'[^']*')*?)(?P<alone>/?)>",
    re.DOTALL,
)
_ATTRIBUTE = re.compile(r"""([^\s=]+)\s*=\s*("[^"]*"|'[^']*')""")


class XmlEdits:
    """Elements of a text, and what is to stand in their places."""

    def __init__(self, path: str) -> None:
        text = read_text(path)
        if "<!DOCTYPE" in text or "<!ENTITY" in text:
            raise InputError(f"{path}: <!DOCTYPE and <!ENTITY are not accepted in a model: remove them")
        try:
            self.root = ElementTree.fromstring(text)
        except ElementTree.ParseError as error:
            raise InputError(f"{path}: not valid XML: {error}") from None
        self._path, self._text, self._changes = path, text, list[tuple[int, int, str]]()
        # Of each element where it begins, where what is inside begins, and where it ends.
        self._places, opened, elements = dict[Element, list[int]](), list[list[int]](), self.root.iter()
        for found in _TOKEN.finditer(text):
            if found["close"]:
                opened.pop()[2] = found.end()
            elif found["tag"]:
                each, place = next(elements), [found.start(), found.end(), found.end()]
                each.tag, self._places[each] = found["tag"], place  # as it is written, without its namespace
                opened += [] if found["alone"] else [place]

    def named(self, tag: str, name: str) -> Element:
        """The element of a tag and a name, which must stand in the file."""
        if (found := next((each for each in self.root.iter(tag) if each.get("name") == name), None)) is None:
            fault = f"{tag} {name!r} does not stand in this file: give the file that it is included from"
            raise InputError(f"{self._path}: {fault}")
        return found

    def set(self, spot: Element, values: Mapping[str, str]) -> None:
        """Give an element attributes, in the place of those of the same names."""
        begin, inside, _ = self._places[spot]
        tag = self._text[begin:inside]
        for name, value in sorted(values.items()):
            end = len(tag.rstrip("/> \t\r\n"))
            there = {found[1]: found.span() for found in _ATTRIBUTE.finditer(tag)}
            start, stop = there.get(name, (end, end))
            tag = f"{tag[:start]}{'' if name in there else ' '}{name}={quoteattr(value)}{tag[stop:]}"
        self._changes.append((begin, inside, tag))

    def put(self, above: Element, elements: "Sequence[Element[Any]]", place: Element | str | None = None) -> None:
        """Put elements into another one, a line each: in the ``place`` of one in it, "last", or first."""
        start, inside, stop = self._places[above]
        before = self._text[:start].rpartition("\n")[2]
        margin = f"\n{before if before.isspace() else ''}  "
        text = "".join(margin + xml_text(each).replace("\n", margin) for each in elements)
        begin = end = inside
        if isinstance(place, Element):
            (begin, _, end), text = self._places[place], text.lstrip()
        elif inside == stop:
            begin, text = inside - 2, f">{text}</{above.tag}>"
        elif place:
            begin = end = len(self._text[: self._text.rindex("<", start, stop)].rstrip())
        self._changes.append((begin, end, text))

    def text(self) -> str:
        """The text with all changes."""
        text = self._text
        for begin, end, new in sorted(self._changes, key=lambda change: -change[0]):
            text = text[:begin] + new + text[end:]
        return text


class Placed(NamedTuple):
    """A joint of a model at zero, in its world: a point on its axis, the axis, and the body that it moves."""

    point: Array
    axis: Array
    body: str
    pose: Pose


def _read_mjcf(path: str) -> tuple[dict[str, Placed], dict[str, tuple[str, float]]]:
    """Joints, and bodies that are fixed to others: the moving body that carries them, and their mass [kg]."""
    mujoco, model = mujoco_model(path)
    data = mujoco.MjData(model)
    data.qpos[:] = 0.0
    mujoco.mj_kinematics(model, data)
    placed, names = {}, [model.body(k).name for k in range(model.nbody)]
    for k, body in enumerate(map(int, model.jnt_bodyid)):
        pose = Pose.of(data.xmat[body].reshape(3, 3), data.xpos[body])
        placed[model.joint(k).name] = Placed(data.xanchor[k].copy(), data.xaxis[k].copy(), names[body], pose)
    loads = enumerate(zip(model.body_weldid.tolist(), model.body_mass.tolist(), strict=True))
    return placed, {names[k]: (names[on], mass) for k, (on, mass) in loads if on not in (0, k)}


def _read_urdf(path: str) -> tuple[dict[str, Placed], dict[str, tuple[str, float]]]:
    tree = read_urdf(path)
    before = {joint.child: joint for joint in tree.joints}

    def pose(link: str) -> Pose:
        return pose(before[link].parent) @ before[link].origin if link in before else Pose()

    placed, fixed = {}, dict[str, tuple[str, float]]()
    for joint in (joint for joint in tree.joints if joint.kind != "fixed"):
        there, axis = pose(joint.child), np.array(joint.axis) / np.linalg.norm(joint.axis)
        placed[joint.name] = Placed(there.p, there.R @ axis, joint.child, there)
        on_it = ((name, tree.links[name]) for name, _ in tree.fixed_to(joint.child, there) if name != joint.child)
        fixed |= {name: (joint.child, body.mass) for name, body in on_it if body is not None}
    return placed, fixed


def into(kind: str, path: str, whole: WholeRobot, head: Iterable[str]) -> tuple[str, list[str]]:
    """Put a robot's numbers, below lines at the head, into an MJCF or URDF file ("mjcf" or "urdf").

    Returns the model's text; what did not match, and what must be known. A file of another geometry is refused.
    """
    of_mujoco = kind == "mjcf"
    model, (placed, extra) = XmlEdits(path), _read_mjcf(path) if of_mujoco else _read_urdf(path)
    tag, inertial_of = ("body", mjcf_inertial) if of_mujoco else ("link", urdf_inertial)
    if of_mujoco and any(each.get("inertiafromgeom") == "true" for each in model.root.iter()):
        raise InputError(f'{path}: inertiafromgeom="true" makes MuJoCo pass over inertials: set it to auto')
    names, moved = _matched(whole, placed, path)
    coupled = whole.robot.coupling
    both = of_mujoco and coupled is not None and {joint - 1 for joint in coupled.joints} <= names.keys()
    links = moved_links(whole, apart=not both)
    for j, name in names.items():
        body, joint, drive = moved[j], model.named("joint", name), links[j].drive
        if of_mujoco:
            link = next((body for body in model.root.iter(tag) if joint in list(body)), None)
            if link is None:
                raise InputError(f"{path}: joint {name!r} is in no body")
            model.set(joint, drive_attributes(drive, DRIVE))
        else:
            link, values = model.named(tag, placed[name].body), drive_attributes(drive)
            if (dynamics := joint.find("dynamics")) is not None:
                model.set(dynamics, values)
            elif values:
                model.put(joint, [element("dynamics", values)])
        inertial = inertial_of(body.mass, body.com, body.inertia_com)
        model.put(link, [links[j].comment(), inertial], link.find("inertial"))
    joints = tuple(names.get(j, "") for j in range(whole.robot.n))
    tendon = [element("tendon", {}, *coupled_tendon(whole, joints))] if both else []
    model.put(model.root, [Comment(f" {plain(line)} ") for line in head])
    model.put(model.root, [*([custom(whole)] if of_mujoco else []), *tendon], "last")
    notes = list[str]()
    if missing := [joint for j, joint in enumerate(whole.joint_names) if j not in names]:
        notes.append(f"Joints of {whole.robot.name} that are not in {path}: {', '.join(missing)}.")
    if others := [name for name in placed if name not in names.values()]:
        notes.append(f"Joints of {path} that are left alone: {', '.join(others)}.")
    bodies = {placed[name].body for name in names.values()}
    for name, (fixed, mass) in extra.items():
        if fixed not in bodies or mass <= 0.0:
            continue
        nothing = [mjcf_inertial(0.0, np.zeros(3), np.zeros((3, 3)))] if of_mujoco else []
        model.put(link := model.named(tag, name), nothing, link.find("inertial"))
        note = f"Taken out: the {mass:.4g} kg of {name}, for what is fixed to a link is part of its numbers"
        notes.append(f"{note}; put them back if it was not there in the recording.")
    if coupled is not None and not both:
        notes.append("The drive that turns with two joints is not put in: each joint has its own share.")
    if offsets := [name for j, name in names.items() if "offset" in whole.drives[j]]:
        notes.append(f"Offsets of the torque are not put in ({', '.join(offsets)}): they belong to your actuators.")
    if whole.robot.spring is not None:
        notes.append("The spring is not put in: add it from the file that is written without --into.")
    return model.text(), notes


def _matched(
    whole: WholeRobot, placed: Mapping[str, Placed], path: str
) -> tuple[dict[int, str], dict[int, InertialParameters]]:
    """Names in the model by the robot's joints, from 0, and links in the frames of the model's bodies."""
    robot, names = whole.robot, dict[int, str]()
    lists = (whole.joint_names, *robot.joint_names, [f"joint{j + 1}" for j in range(robot.n)])
    for j in range(robot.n):
        own_names = [each[j] for each in lists if each[j] in placed]
        names |= {j: own_names[0]} if own_names else {}
    if not names:
        theirs, ours = ", ".join(placed) or "none", ", ".join(whole.joint_names)
        fault = f"none of its joints ({theirs}) is called as the robot's ({ours})"
        raise InputError(f"{path}: {fault}: give joint_names in a robot file of your own")
    frames = frames_at(robot, [0.0] * robot.n)
    own = {j: (frames[j + 1].p, frames[j + 1].R[:, 2]) for j in names}
    there = {j: (placed[name].point, placed[name].axis) for j, name in names.items()}
    turning = [j for j in names if robot.joints[j].revolute]
    # Rotation and shift that lay the robot's axes on the model's, by least squares.
    pairs = [(own[j][1], there[j][1]) for j in names]
    pairs += [(_between(own[i], own[j]), _between(there[i], there[j])) for i, j in combinations(turning, 2)]
    U, _, Vt = np.linalg.svd(sum(np.outer(b, a) for a, b in pairs))
    R: Array = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
    t: Array = np.zeros(3)
    if turning:
        across = np.array([np.eye(3) - np.outer(there[j][1], there[j][1]) for j in turning])
        apart = [P @ (there[j][0] - R @ own[j][0]) for P, j in zip(across, turning, strict=True)]
        t = np.linalg.lstsq(across.reshape(-1, 3), np.concatenate(apart), rcond=None)[0]
    moved, links = {}, moved_links(whole)
    for j, name in names.items():
        (p, z), (point, axis) = own[j], there[j]
        angle = math.atan2(float(np.linalg.norm(np.cross(R @ z, axis))), float((R @ z) @ axis))
        beside = float(np.linalg.norm(np.cross(R @ p + t - point, axis))) if j in turning else 0.0
        if angle > TURNED or beside > FAR:
            lies = f"lies {1e3 * beside:.1f} mm beside the robot's, turned by {math.degrees(angle):.2f} deg"
            fault = f"at zero the axis of {name} {lies}: its geometry, zero or sense is not {robot.name}'s"
            raise InputError(f"{path}: {fault}")
        link, pose = frames[j + 1] @ links[j].own, placed[name].pose
        moved[j] = whole.links[j].body.moved(pose.R.T @ R @ link.R, pose.R.T @ (R @ link.p + t - pose.p))
    return names, moved


def _between(first: tuple[Array, Array], second: tuple[Array, Array]) -> Array:
    (p, a), (q, b) = first, second
    directions, offset = np.column_stack([a, b]), q - p
    return np.asarray(offset - directions @ np.linalg.lstsq(directions, offset, rcond=1e-9)[0])
