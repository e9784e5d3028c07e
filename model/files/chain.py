"""Picks the chain from base to flange out of a URDF tree and makes it a robot."""

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from ...common.errors import InputError
from ..inertia import InertialParameters
from ..motion import Processing, usual_slow_speed
from ..pose import Pose
from ..robot import Links, Robot
from .described import Source
from .reframe import JointAxis, Reframed, modified_dh
from .tree import UrdfJoint, UrdfTree, read_urdf

_FAR = 20.0  # m: no arm is as large
_DIGITS = 1e-3  # of the largest moment of inertia: what rounding in a file may do to the others
_MOVES = ("revolute", "continuous", "prismatic")
_FLANGES = (r"(.*[_-])?tool0", r"(.*[_-])?flange", r"(panda|fer|fr3|fp3)_link8")
"""Patterns of the names of the maker's flange: ROS-Industrial's, then Franka's; the first that fits counts."""


_Link = tuple[UrdfJoint, Pose]
"""Moving link: its joint, and where that joint's frame stands in the base at the zero position."""


def load_urdf(path: str | Path | Source, base: str | None = None, tip: str | None = None) -> Robot:
    """Read a serial robot from a URDF or xacro file.

    Fixed joints are merged, meshes are not read. Gravity points along -z of the base link. Joint positions count
    as in the file. Inertias are read into ``Robot.parameters``, as a prior.

    Args:
        base: first link of the chain; the root by default.
        tip: the flange's link; by default the only link at an end of the tree that a joint moves.

    Raises:
        InputError: if there is no such chain, or several, or a joint of it is of a kind that is not supported.
    """
    tree = read_urdf(path)
    file = Path(tree.source).name
    children = _children(tree)
    first = _base(tree, base)
    last, by_convention = _tip(tree, children, first, tip)
    links, flange = _down(tree, first, last)
    axes = [
        JointAxis(
            "prismatic" if joint.kind == "prismatic" else "revolute",
            tuple((pose.R @ np.array(joint.axis)).tolist()),
            pose.origin,
            joint.limits,
        )
        for joint, pose in links
    ]
    frames = modified_dh(axes, flange)
    parameters, left_out = _parameters(tree, children, links, frames)
    far = [
        f"axes {number - 1} and {number} are almost parallel (a calibrated description?): their common normal lies "
        f"{away:.3g} m away, and parameters lose digits; the nominal description has them parallel"
        for number, joint in enumerate(frames.joints, start=1)
        if (away := max(abs(joint.d), abs(joint.r))) > _FAR
    ]
    return Robot(
        name=re.sub(r"\s+", "_", tree.name.strip()) or "robot",
        joints=frames.joints,
        gravity=tuple((frames.base.R @ np.array([0.0, 0.0, -9.81]) + 0.0).tolist()),
        payload_frame=f"{_frame(last)} of {file}",
        flange=frames.flange,
        base=frames.base,
        links=_named(tree, children, links, frames, (first, last)),
        processing=Processing(slow_speed=usual_slow_speed([joint.revolute for joint in frames.joints])),
        parameters=parameters,
        title=f"{tree.name} ({file}, {first} to {last})",
        snapped=(*by_convention, *tree.notes, *left_out, *far),
    )


def _children(tree: UrdfTree) -> dict[str, list[UrdfJoint]]:
    children: dict[str, list[UrdfJoint]] = {name: [] for name in tree.links}
    moved: dict[str, str] = {}
    for joint in tree.joints:
        if joint.child in moved:
            raise InputError(
                f"{tree.source}: link {joint.child!r} is the child of joints {moved[joint.child]!r} and "
                f"{joint.name!r}: closed loops are not supported"
            )
        moved[joint.child] = joint.name
        children[joint.parent].append(joint)
    reached = [name for name in tree.links if name not in moved]
    for name in reached:  # grows while it is walked
        reached += [joint.child for joint in children[name]]
    if len(reached) < len(tree.links):
        ring = next(name for name in tree.links if name not in set(reached))
        raise InputError(f"{tree.source}: link {ring!r} is its own ancestor: closed loops are not supported")
    return children


def _base(tree: UrdfTree, base: str | None) -> str:
    if base is not None:
        return _known(tree, base, "chain = BASE:TIP")
    below = {joint.child for joint in tree.joints}
    roots = [name for name in tree.links if name not in below]
    if not roots:
        raise InputError(f"{tree.source}: no links in the file")
    if len(roots) > 1:
        raise InputError(
            f"{tree.source}: {len(roots)} links have no parent: set chain to BASE:, BASE one of {_list(roots)}"
        )
    return roots[0]


def _tip(
    tree: UrdfTree, children: Mapping[str, list[UrdfJoint]], base: str, tip: str | None
) -> tuple[str, tuple[str, ...]]:
    """Find the flange's link, and note where it was one of several by its name."""
    if tip is not None:
        return _known(tree, tip, "chain = BASE:TIP"), ()
    moved: list[str] = []
    stack = [(base, False)]
    while stack:
        link, moves = stack.pop()
        stack += [(joint.child, moves or joint.kind != "fixed") for joint in children[link]]
        moved += [link] if moves else []
    ends = sorted(link for link in moved if not children[link])
    if not ends:
        raise InputError(
            f"{tree.source}: no joint moves anything from link {base!r} on: give another BASE (chain BASE:TIP)"
        )
    if len(ends) == 1:
        return ends[0], ()
    for pattern in _FLANGES:
        if named := [link for link in moved if re.fullmatch(pattern, link)]:
            break
    if len(named) != 1:  # none, or several arms have one each
        raise InputError(
            f"{tree.source}: several chains end in a link: set chain to :TIP, TIP one of {_list(ends)}"
        )
    return named[0], (
        f"link {named[0]!r} is taken as the flange by its name; ends are {_list(ends)}: chain = :TIP chooses",
    )


def _frame(tip: str) -> str:
    """Name the payload's frame. The axes of a link "flange" are not the controller's: its x points out."""
    flange = any(re.fullmatch(pattern, tip) for pattern in (_FLANGES[0], _FLANGES[2]))
    return f"flange: link {tip}" if flange else f"link {tip}"


def _known(tree: UrdfTree, link: str, option: str) -> str:
    if link not in tree.links:
        raise InputError(f"{tree.source}: {option}: no link {link!r}: the links are {_list(list(tree.links))}")
    return link


def _list(names: Sequence[str]) -> str:
    return ", ".join(names[:30]) + (" and more" if len(names) > 30 else "")


def _down(tree: UrdfTree, base: str, tip: str) -> tuple[list[_Link], Pose]:
    """Find the moving links between base and tip, and the tip, all in the base at the zero position."""
    above = {joint.child: joint for joint in tree.joints}
    path: list[UrdfJoint] = []
    link = tip
    while link != base:
        if link not in above:
            raise InputError(f"{tree.source}: no chain leads from {base!r} down to {tip!r}: swap or change them")
        path.append(above[link])
        link = above[link].parent
    pose, links = Pose(), []
    for joint in reversed(path):
        if joint.kind not in (*_MOVES, "fixed"):
            raise InputError(
                f"{tree.source}: joint {joint.name!r} is {joint.kind or 'of no kind'!r}: a chain of revolute, "
                "continuous, prismatic and fixed joints is needed; choose another chain BASE:TIP"
            )
        if joint.mimics and joint.kind != "fixed":
            raise InputError(
                f"{tree.source}: joint {joint.name!r} mimics {joint.mimics!r}: coupled joints of a URDF are not "
                "supported; choose another chain BASE:TIP"
            )
        pose = pose @ joint.origin
        if joint.kind in _MOVES:
            links.append((joint, pose))
    if not links:
        raise InputError(f"{tree.source}: no joint moves between base and tip: choose another chain BASE:TIP")
    return links, pose


def _named(
    tree: UrdfTree,
    children: Mapping[str, list[UrdfJoint]],
    links: Sequence[_Link],
    frames: Reframed,
    ends: tuple[str, str],
) -> Links:
    """Collect names, frames and looks of the links; ``ends``: the first link and the flange's."""
    names = tuple(joint.child for joint, _ in links)
    poses = tuple(frame.inverse() @ pose for frame, (_, pose) in zip(frames.frames, links, strict=True))
    looks = tuple(
        tuple(
            mesh._replace(pose=at @ mesh.pose)
            for fixed, at in _fixed_to(children, link, pose)
            for mesh in tree.meshes[fixed]
        )
        for link, pose in zip((ends[0], *names), (frames.base, *poses), strict=True)
    )
    return Links(names, poses, tuple(joint.name for joint, _ in links), *ends, looks)


def _fixed_to(children: Mapping[str, list[UrdfJoint]], link: str, pose: Pose) -> Iterator[tuple[str, Pose]]:
    """Go through a link and all that is fixed to it, with their frames where the link's is at ``pose``."""
    waiting = [(link, pose)]
    while waiting:
        name, at = waiting.pop()
        yield name, at
        waiting += [(joint.child, at @ joint.origin) for joint in children[name] if joint.kind == "fixed"]


def _impossible(name: str, body: InertialParameters) -> list[str]:
    """Name what no body can have; a link without mass and inertia only carries others."""
    if body.mass < 0.0 or (body.mass == 0.0 and body.vector.any()):
        return [f"link {name!r}: no body has a mass of {body.mass:g} kg and this inertia: correct the file"]
    moments = np.linalg.eigvalsh(body.inertia_com) if body.mass else np.zeros(3)
    if moments[0] + moments[1] >= (1.0 - _DIGITS) * moments[2] and moments[0] >= -_DIGITS * moments[2]:
        return []
    shown = ", ".join(f"{moment:.3g}" for moment in moments)
    return [
        f"link {name!r}: no body has these principal moments of inertia: {shown} kg m^2 (the largest exceeds the "
        "sum of the others, or one is negative): correct the file"
    ]


def _parameters(
    tree: UrdfTree, children: Mapping[str, list[UrdfJoint]], links: Sequence[_Link], frames: Reframed
) -> tuple[dict[str, float], list[str]]:
    """Collect standard parameters of the links whose bodies the file gives, and note what is left out."""
    values: dict[str, float] = {}
    notes: list[str] = []
    own = {joint.name for joint, _ in links}
    for j, ((moving, at), frame) in enumerate(zip(links, frames.frames, strict=True), start=1):
        total, massive = np.zeros(10), False
        for name, pose in _fixed_to(children, moving.child, frame.inverse() @ at):
            body = tree.links[name]
            if body is not None:
                total, massive = total + body.moved(pose.R, pose.p).vector, True
                notes += _impossible(name, body)
            notes += [
                f"joint {joint.name!r} is not of the chain: it and what hangs on it are left out"
                for joint in children[name]
                if joint.kind != "fixed" and joint.name not in own
            ]
        if massive:
            values |= InertialParameters(total).named(str(j))
        if moving.damping is not None:
            values[f"FV{j}"] = moving.damping
        if moving.friction is not None:
            values[f"FS{j}"] = moving.friction
    return values, notes
