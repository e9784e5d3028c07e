"""Identified numbers in a user's own model, matched by names of joints and moved into its frames."""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from io import StringIO
from itertools import combinations
from typing import Any, NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ....common.arrays import Array
from ....common.errors import InputError
from ....common.schema import read_text
from ....estimation.possible.whole_robot import WholeRobot
from ....model import InertialParameters, Pose
from ....model.files.tree import read_urdf
from ....model.frames import frames_at
from . import mjcf, urdf
from .form import comment, link_marks, own_frame


class Placed(NamedTuple):
    """A joint of a model at zero, in its world: a point on its axis, the axis, and the body that it moves."""

    point: Array
    axis: Array
    body: str
    pose: Pose


Extra = dict[str, tuple[str, float]]
"""Bodies fixed to others: to which, and their mass [kg]."""


def _read_mjcf(path: str) -> tuple[dict[str, Placed], Extra]:
    try:
        import mujoco
    except ImportError:
        raise InputError("--into an MJCF file needs MuJoCo: pip install 'dynident[simulators]'") from None
    try:
        model: Any = mujoco.MjModel.from_xml_path(path)
    except ValueError as error:
        raise InputError(f"{path}: MuJoCo does not take it: {' '.join(str(error).split())}") from None
    data = mujoco.MjData(model)
    data.qpos[:] = 0.0
    mujoco.mj_kinematics(model, data)
    placed = {}
    for k in range(model.njnt):
        body = int(model.jnt_bodyid[k])
        pose = Pose.of(data.xmat[body].reshape(3, 3), data.xpos[body])
        placed[model.joint(k).name] = Placed(
            data.xanchor[k].copy(), data.xaxis[k].copy(), model.body(body).name, pose
        )
    fixed = {
        model.body(k).name: (model.body(int(model.body_weldid[k])).name, float(model.body_mass[k]))
        for k in range(1, model.nbody)
        if model.body_weldid[k] not in (0, k) and model.body_mass[k] > 0.0
    }
    return placed, fixed


def _read_urdf(path: str) -> tuple[dict[str, Placed], Extra]:
    tree = read_urdf(path)
    children = {joint.child: joint for joint in tree.joints}

    def pose(link: str) -> Pose:
        joint = children.get(link)
        return Pose() if joint is None else pose(joint.parent) @ joint.origin

    placed, fixed = {}, {}
    for joint in tree.joints:
        there, body = pose(joint.child), tree.links[joint.child]
        if joint.kind == "fixed":
            fixed[joint.child] = (joint.parent, body.mass if body is not None else 0.0)
            continue
        axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
        placed[joint.name] = Placed(there.p, there.R @ axis, joint.child, there)
    return placed, fixed


def _elements(text: str) -> list[Element]:
    """What a text holds, comments too."""
    builder = ElementTree.TreeBuilder(insert_comments=True, insert_pis=True)
    return list(ElementTree.XML(f"<all>{text}</all>", ElementTree.XMLParser(target=builder)))


class UserXml:
    """A user's XML of which some elements change: all else stays, comments too.

    Attributes:
        root: the outermost element.
        above: the element that each stands in.
    """

    def __init__(self, path: str) -> None:
        """Read a file.

        Raises:
            InputError: if it is no XML, or defines entities.
        """
        text = read_text(path)
        if "<!DOCTYPE" in text or "<!ENTITY" in text:
            raise InputError(f"{path}: <!DOCTYPE and <!ENTITY are not accepted in a model: remove them")
        # What stands around the root is no part of the tree, nor are prefixes that no name has.
        around = r"(?:\s|<\?(?:(?!\?>).)*\?>|<!--(?:(?!-->).)*-->)*"
        before, after = re.match(around, text, re.DOTALL), re.search(around + r"\Z", text, re.DOTALL)
        self._path, self._before, self._after = path, before[0] if before else "", after[0] if after else ""
        try:
            prefixes = dict(names for _, names in ElementTree.iterparse(StringIO(text), ["start-ns"]))
            (self.root,) = _elements(text[len(self._before) : len(text) - len(self._after)])
        except ElementTree.ParseError as error:
            raise InputError(f"{path}: not valid XML: {error}") from None
        self.above = {child: parent for parent in self.root.iter() for child in parent}
        for prefix, space in prefixes.items():
            if not any(
                f"{{{space}}}" in f"{element.tag} {' '.join(element.attrib)}" for element in self.root.iter()
            ):
                self.root.set(f"xmlns:{prefix}", space)
            elif not re.fullmatch(r"ns\d+", prefix):
                ElementTree.register_namespace(prefix, space)

    def named(self, tag: str, name: str) -> Element:
        """The element of a tag and a name.

        Raises:
            InputError: if there is none.
        """
        for element in self.root.iter(tag):
            if element.get("name") == name:
                return element
        raise InputError(
            f"{self._path}: {tag} {name!r} does not stand in this file: give the file that it is included from"
        )

    def set_inertial(self, parent: Element, lines: list[str]) -> None:
        """Put lines in the place of a link's inertial, or first into it."""
        old = parent.find("inertial")
        place, space = (0, parent.text) if old is None else (list(parent).index(old), old.tail)
        if old is not None:
            parent.remove(old)
        for element in reversed(_elements("\n".join(lines))):
            element.tail = space
            parent.insert(place, element)

    def text(self) -> str:
        """The text with all changes."""
        text = ElementTree.tostring(self.root, encoding="unicode")
        # Elements without content end as MJCF and URDF have them; comments may hold anything.
        text = re.sub(r"(<!--.*?-->)| />", lambda found: found[1] or "/>", text, flags=re.DOTALL)
        return self._before + text + self._after


FAR = 0.005
"""m: how far a joint's axis may lie beside the robot's own; descriptions round lengths to a millimetre."""
TURNED = math.radians(0.5)
"""rad: by how much it may be turned."""


@dataclass(frozen=True)
class Changed:
    """A model with the numbers in it.

    Attributes:
        text: of the file.
        notes: what did not match, and what must be known.
    """

    text: str
    notes: tuple[str, ...]


def into(kind: str, path: str, whole: WholeRobot, head: list[str]) -> Changed:
    """Put a robot's numbers into an MJCF or URDF file.

    Args:
        kind: "mjcf" or "urdf".
        path: of the file.
        head: what is to be said at the head.

    Raises:
        InputError: if the file cannot be used, no joint matches, or its geometry is not the robot's.
    """
    placed, extra = _read_mjcf(path) if kind == "mjcf" else _read_urdf(path)
    text = UserXml(path)
    if kind == "mjcf" and any(element.get("inertiafromgeom") == "true" for element in text.root.iter()):
        raise InputError(f'{path}: inertiafromgeom="true" makes MuJoCo pass over inertials: set it to auto')
    names = _matching(whole, placed, path)
    moved = _bodies(whole, names, placed, path)
    for element in reversed(_elements("".join(comment(head)))):
        element.tail = text.root.text
        text.root.insert(0, element)
    coupled = whole.robot.coupling
    both = kind == "mjcf" and coupled is not None and {joint - 1 for joint in coupled.joints} <= names.keys()
    drives = whole.drives if both else whole.apart
    for j, name in names.items():
        lines = list(urdf.link_comment(link_marks(whole.links[j], drives[j]), ""))
        joint = text.named("joint", name)
        if kind == "urdf":
            values, dynamics = urdf.drive_attributes(drives[j]), joint.find("dynamics")
            if values and dynamics is None:
                dynamics = SubElement(joint, "dynamics")
            if dynamics is not None:
                dynamics.attrib.update(values)
            text.set_inertial(text.named("link", placed[name].body), [*lines, *urdf.inertial(moved[j])])
            continue
        joint.attrib.update(mjcf.drive_attributes(drives[j]))
        if text.above[joint].tag != "body":
            raise InputError(f"{path}: joint {name!r} stands in no body")
        text.set_inertial(text.above[joint], [*lines, mjcf.inertial(moved[j])])
    if kind == "mjcf":
        text.root.extend(_elements("\n".join(_mjcf_beside(whole, names, both)) + "\n"))
    notes = [*_unmatched(whole, names, placed, path)]
    for body, mass in _carried(extra, {placed[name].body for name in names.values()}):
        nothing = ['<inertial pos="0 0 0" mass="0" diaginertia="0 0 0"/>'] if kind == "mjcf" else []
        text.set_inertial(text.named("body" if kind == "mjcf" else "link", body), nothing)
        notes.append(
            f"Taken out: the {mass:.4g} kg of {body}, for what is fixed to a link is part of its numbers; put them "
            "back if it was not there in the recording."
        )
    if coupled is not None and not both:
        notes.append("The drive that turns with two joints is not put in: each joint has its own share.")
    return Changed(text.text(), (*notes, *_left_out(whole, names)))


def _mjcf_beside(whole: WholeRobot, names: Mapping[int, str], coupled: bool) -> list[str]:
    """What an MJCF file gets beside its bodies: texts, and the tendon of coupled drives."""
    joints = tuple(names.get(j, "") for j in range(whole.robot.n))
    tendon = ["<tendon>", *mjcf.coupled_tendon(whole, joints), "</tendon>"] if coupled else []
    return ["<custom>", *mjcf.custom_texts(whole), "</custom>", *tendon]


def _unmatched(
    whole: WholeRobot, names: Mapping[int, str], placed: Mapping[str, Placed], path: str
) -> Iterator[str]:
    """What to tell of joints that only the robot or only the model has."""
    if missing := [joint for j, joint in enumerate(whole.joint_names) if j not in names]:
        yield f"Joints of {whole.robot.name} that are not in {path}: {', '.join(missing)}."
    if others := [name for name in placed if name not in names.values()]:
        yield f"Joints of {path} that are left alone: {', '.join(others)}."


def _carried(extra: Extra, links: set[str]) -> Iterator[tuple[str, float]]:
    """Bodies with mass that are fixed to one of the links, straight or through others."""
    for body, (fixed, mass) in extra.items():
        while fixed not in links and fixed in extra:
            fixed = extra[fixed][0]
        if fixed in links and mass > 0.0:
            yield body, mass


def _left_out(whole: WholeRobot, names: Mapping[int, str]) -> Iterator[str]:
    offsets = [name for j, name in names.items() if "offset" in whole.drives[j]]
    if offsets:
        yield f"Offsets of the torque are not put in ({', '.join(offsets)}): they belong to your actuators."
    if whole.robot.spring is not None:
        yield "The spring is not put in: add it from the file that is written without --into."


def _matching(whole: WholeRobot, placed: Mapping[str, Placed], path: str) -> dict[int, str]:
    """Names in the model by the robot's joints, from 0."""
    lists = (whole.joint_names, *whole.robot.joint_names, [f"joint{j + 1}" for j in range(whole.robot.n)])
    matches: dict[int, str] = {}
    for j in range(whole.robot.n):
        own = [names[j] for names in lists if names[j] in placed]
        matches |= {j: own[0]} if own else {}
    if not matches:
        raise InputError(
            f"{path}: none of its joints ({', '.join(placed) or 'none'}) is called as the robot's "
            f"({', '.join(whole.joint_names)}): give joint_names in a robot file of your own"
        )
    return matches


def _bodies(
    whole: WholeRobot, names: Mapping[int, str], placed: Mapping[str, Placed], path: str
) -> dict[int, InertialParameters]:
    """Links in the frames of the model's bodies.

    Raises:
        InputError: names the joint whose axis lies elsewhere.
    """
    robot = whole.robot
    frames = frames_at(robot, [0.0] * robot.n)
    own = {j: (frames[j + 1].p, frames[j + 1].R[:, 2]) for j in names}
    theirs = {j: (placed[name].point, placed[name].axis) for j, name in names.items()}
    slides = {j for j in names if not robot.joints[j].revolute}
    R, t = _aligned(own, theirs, slides)
    for j, name in names.items():
        (p, z), (point, axis) = own[j], theirs[j]
        angle = math.atan2(float(np.linalg.norm(np.cross(R @ z, axis))), float((R @ z) @ axis))
        beside = 0.0 if j in slides else float(np.linalg.norm(np.cross(R @ p + t - point, axis)))
        if angle > TURNED or beside > FAR:
            raise InputError(
                f"{path}: at zero the axis of {name} lies {1e3 * beside:.1f} mm beside the robot's, turned by "
                f"{math.degrees(angle):.2f} deg: its geometry, zero or sense is not {robot.name}'s"
            )
    moved = {}
    for j, name in names.items():
        link = frames[j + 1] @ own_frame(robot, j + 1)
        pose = placed[name].pose
        moved[j] = whole.links[j].body.moved(pose.R.T @ R @ link.R, pose.R.T @ (R @ link.p + t - pose.p))
    return moved


Lines = Mapping[int, tuple[Array, Array]]
"""Axes: a point and a direction each."""


def _aligned(own: Lines, theirs: Lines, slides: set[int]) -> tuple[Array, Array]:
    """Rotation and shift that lay the robot's axes on the model's, by least squares."""
    pairs = [(own[j][1], theirs[j][1]) for j in own]
    turning = [j for j in own if j not in slides]
    pairs += [(_between(own[i], own[j]), _between(theirs[i], theirs[j])) for i, j in combinations(turning, 2)]
    U, _, Vt = np.linalg.svd(sum(np.outer(b, a) for a, b in pairs))
    R = np.asarray(U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt)
    rows = [np.eye(3) - np.outer(theirs[j][1], theirs[j][1]) for j in turning]
    right = [P @ (theirs[j][0] - R @ own[j][0]) for P, j in zip(rows, turning, strict=True)]
    if not rows:
        return R, np.zeros(3)
    return R, np.asarray(np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0])


def _between(first: tuple[Array, Array], second: tuple[Array, Array]) -> Array:
    """Shortest vector from one axis to another [m]."""
    (p, a), (q, b) = first, second
    directions = np.column_stack([a, b])
    offset = q - p
    return np.asarray(offset - directions @ np.linalg.lstsq(directions, offset, rcond=1e-9)[0])
