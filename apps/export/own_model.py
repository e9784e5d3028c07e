"""Identified numbers in a user's own model, matched by names of joints and moved into its frames."""

import math
from collections.abc import Iterable, Mapping
from itertools import combinations
from typing import Any, NamedTuple
from xml.etree.ElementTree import Comment

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...estimation.possible.whole_robot import WholeRobot
from ...model import InertialParameters, Pose
from ...model.files.urdf import read_urdf
from ...model.frames import frames_at
from .format import plain
from .robot import drive_attributes, link_marks, mark_comment, moved_links
from .simulators import mjcf
from .xml import element, mjcf_inertial, urdf_inertial
from .xml_edits import XmlEdits


class Placed(NamedTuple):
    """A joint of a model at zero, in its world: a point on its axis, the axis, and the body that it moves."""

    point: Array
    axis: Array
    body: str
    pose: Pose


Extra = dict[str, tuple[str, float]]
"""Bodies fixed to others: the moving body that carries them, and their mass [kg]."""


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
    for k, body in enumerate(map(int, model.jnt_bodyid)):
        pose, name = Pose.of(data.xmat[body].reshape(3, 3), data.xpos[body]), model.body(body).name
        placed[model.joint(k).name] = Placed(data.xanchor[k].copy(), data.xaxis[k].copy(), name, pose)
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

    def moving(link: str) -> str:
        joint = children.get(link)
        return moving(joint.parent) if joint is not None and joint.kind == "fixed" else link

    placed, fixed = {}, {}
    for joint in tree.joints:
        there, body = pose(joint.child), tree.links[joint.child]
        if joint.kind == "fixed":
            fixed[joint.child] = (moving(joint.parent), body.mass if body is not None else 0.0)
        else:
            axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
            placed[joint.name] = Placed(there.p, there.R @ axis, joint.child, there)
    return placed, fixed


FAR = 0.005
"""m: how far a joint's axis may lie beside the robot's own; descriptions round lengths to a millimetre."""
TURNED = math.radians(0.5)
"""rad: by how much it may be turned."""


def into(kind: str, path: str, whole: WholeRobot, head: Iterable[str]) -> tuple[str, list[str]]:
    """Put a robot's numbers, below lines at the head, into an MJCF or URDF file ("mjcf" or "urdf").

    Returns:
        The model's text; what did not match, and what must be known.

    Raises:
        InputError: if the file cannot be used, no joint matches, or its geometry is not the robot's.
    """
    of_mujoco = kind == "mjcf"
    model = XmlEdits(path)
    placed, extra = _read_mjcf(path) if of_mujoco else _read_urdf(path)
    if of_mujoco and any(spot.values.get("inertiafromgeom") == "true" for spot in model.spots):
        raise InputError(f'{path}: inertiafromgeom="true" makes MuJoCo pass over inertials: set it to auto')
    names, moved = _matched(whole, placed, path)
    root, coupled = model.spots[0], whole.robot.coupling
    model.put(root, [Comment(f" {plain(line)} ") for line in head])
    both = of_mujoco and coupled is not None and {joint - 1 for joint in coupled.joints} <= names.keys()
    drives = whole.drives if both else whole.apart
    for j, name in names.items():
        body, joint = moved[j], model.named("joint", name)
        marks = mark_comment(link_marks(whole.links[j], drives[j]))
        if of_mujoco:
            link = joint.above
            if link is None or link.tag != "body":
                raise InputError(f"{path}: joint {name!r} is in no body")
            model.set(joint, drive_attributes(drives[j], mjcf.DRIVE))
            inertial = mjcf_inertial(body.mass, body.com, body.inertia_com)
        else:
            link, values = model.named("link", placed[name].body), drive_attributes(drives[j])
            inertial = urdf_inertial(body.mass, body.com, body.inertia_com)
            if dynamics := model.within(joint, "dynamics"):
                model.set(dynamics, values)
            elif values:
                model.add(joint, [element("dynamics", values)])
        model.put(link, [marks, inertial], model.within(link, "inertial"))
    if of_mujoco:
        joints = tuple(names.get(j, "") for j in range(whole.robot.n))
        tendon = [element("tendon", {}, *mjcf.coupled_tendon(whole, joints))] if both else []
        model.add(root, [mjcf.custom(whole), *tendon])
    notes = list[str]()
    if missing := [joint for j, joint in enumerate(whole.joint_names) if j not in names]:
        notes.append(f"Joints of {whole.robot.name} that are not in {path}: {', '.join(missing)}.")
    if others := [name for name in placed if name not in names.values()]:
        notes.append(f"Joints of {path} that are left alone: {', '.join(others)}.")
    links = {placed[name].body for name in names.values()}
    for name, (fixed, mass) in extra.items():
        if fixed not in links or mass <= 0.0:
            continue
        nothing = [mjcf_inertial(0.0, np.zeros(3), np.zeros((3, 3)))] if of_mujoco else []
        link = model.named("body" if of_mujoco else "link", name)
        model.put(link, nothing, model.within(link, "inertial"))
        notes.append(
            f"Taken out: the {mass:.4g} kg of {name}, for what is fixed to a link is part of its numbers; put them "
            "back if it was not there in the recording."
        )
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
    slides = {j for j in names if not robot.joints[j].revolute}
    R, t = _aligned(own, there, slides)
    moved, links = {}, moved_links(whole)
    for j, name in names.items():
        (p, z), (point, axis) = own[j], there[j]
        angle = math.atan2(float(np.linalg.norm(np.cross(R @ z, axis))), float((R @ z) @ axis))
        beside = 0.0 if j in slides else float(np.linalg.norm(np.cross(R @ p + t - point, axis)))
        if angle > TURNED or beside > FAR:
            raise InputError(
                f"{path}: at zero the axis of {name} lies {1e3 * beside:.1f} mm beside the robot's, turned by "
                f"{math.degrees(angle):.2f} deg: its geometry, zero or sense is not {robot.name}'s"
            )
        link, pose = frames[j + 1] @ links[j].own, placed[name].pose
        moved[j] = whole.links[j].body.moved(pose.R.T @ R @ link.R, pose.R.T @ (R @ link.p + t - pose.p))
    return names, moved


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
    shift = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0] if rows else np.zeros(3)
    return R, np.asarray(shift)


def _between(first: tuple[Array, Array], second: tuple[Array, Array]) -> Array:
    (p, a), (q, b) = first, second
    directions, offset = np.column_stack([a, b]), q - p
    return np.asarray(offset - directions @ np.linalg.lstsq(directions, offset, rcond=1e-9)[0])
