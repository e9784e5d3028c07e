"""Identified numbers in a user's own model, matched by names of joints and moved into its frames."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ....common.arrays import Array
from ....common.errors import InputError
from ....estimation.possible.whole_robot import Labelled, WholeRobot
from ....model import InertialParameters
from ....model.frames import frames_at
from . import mjcf, urdf
from .form import attributes, comment, link_marks
from .frames import own_frame
from .placed import READERS, Extra, Placed
from .xml_text import Element, XmlText

FAR = 0.005
"""m: how far a joint's axis may lie beside the robot's own; descriptions round lengths to a millimetre."""
TURNED = math.radians(0.5)
"""rad: by how much it may be turned."""


class Part(NamedTuple):
    """What a joint of the model and the body that it moves get."""

    joint: str
    link: str
    body: InertialParameters
    drive: dict[str, Labelled]
    lines: list[str]


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
    placed, extra = READERS[kind](path)
    text = XmlText(Path(path).read_bytes(), path)
    names = _matching(whole, placed, path)
    moved = _bodies(whole, names, placed, path)
    text.insert(text.root, comment(head))
    coupled = whole.robot.coupling
    both = kind == "mjcf" and coupled is not None and {joint - 1 for joint in coupled.joints} <= names.keys()
    drives = whole.drives if both else whole.apart
    for j, name in names.items():
        lines = list(urdf.link_comment(link_marks(whole.links[j], drives[j]), ""))
        _WRITERS[kind](text, Part(name, placed[name].body, moved[j], drives[j], lines), path)
    if kind == "mjcf":
        text.insert(text.root, _mjcf_beside(whole, names, both), last=True)
    notes = [*_unmatched(whole, names, placed, path)]
    for body, mass in _carried(extra, {placed[name].body for name in names.values()}):
        _take_out(kind, text, body, path)
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


def _take_out(kind: str, text: XmlText, body: str, path: str) -> None:
    """Leave a body without mass."""
    element = _named(text, "body" if kind == "mjcf" else "link", body, path)
    inertial = element.child("inertial")
    if kind == "mjcf":
        nothing = '<inertial pos="0 0 0" mass="0" diaginertia="0 0 0"/>'
        _set_inertial(text, element, [nothing])
    elif inertial is not None:
        text.replace(inertial, "")


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


def _named(text: XmlText, tag: str, name: str, path: str) -> Element:
    for element in text.root.walk():
        if element.tag == tag and element.attributes.get("name") == name:
            return element
    raise InputError(f"{path}: {tag} {name!r} does not stand in this file: give the file that it is included from")


def _write_mjcf(text: XmlText, part: Part, path: str) -> None:
    if any(element.attributes.get("inertiafromgeom") == "true" for element in text.root.walk()):
        raise InputError(f'{path}: inertiafromgeom="true" makes MuJoCo pass over inertials: set it to auto')
    joint = _named(text, "joint", part.joint, path)
    text.set_attributes(joint, mjcf.drive_attributes(part.drive))
    if joint.parent is None or joint.parent.tag != "body":
        raise InputError(f"{path}: joint {part.joint!r} stands in no body")
    _set_inertial(text, joint.parent, [*part.lines, mjcf.inertial(part.body)])


def _write_urdf(text: XmlText, part: Part, path: str) -> None:
    joint = _named(text, "joint", part.joint, path)
    values, dynamics = urdf.drive_attributes(part.drive), joint.child("dynamics")
    if dynamics is not None:
        text.set_attributes(dynamics, values)
    elif values:
        text.insert(joint, [f"<dynamics {attributes(values)}/>"], last=True)
    _set_inertial(text, _named(text, "link", part.link, path), [*part.lines, *urdf.inertial(part.body)])


def _set_inertial(text: XmlText, parent: Element, lines: list[str]) -> None:
    inertial = parent.child("inertial")
    if inertial is None:
        text.insert(parent, lines)
    else:
        text.replace(inertial, "\n".join(lines))


_WRITERS = {"mjcf": _write_mjcf, "urdf": _write_urdf}
