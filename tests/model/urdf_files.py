"""Writes URDF files of known arms, dressed as descriptions come: turned link frames, any axis, fixed joints."""

import itertools
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.model import Drives, Robot, robot_names
from dynident.model.inertia import Pose

AXES = ("0 0 1", "0 0 -1", "0 1 0", "0 -1 0", "1 0 0", "-1 0 0")
_QUARTERS = (0.0, math.pi / 2, -math.pi / 2, math.pi)


def dressed_urdf(robot: Robot, seed: int, inertials: bool = True, limits: bool = True) -> str:
    """URDF of a robot by modified DH; every link frame stands turned and shifted on its axis.

    Each moving joint is preceded by a fixed one, and the flange "tool0" is fixed to the last link.
    """
    draw = np.random.default_rng(seed)
    body = _inertial(draw) if inertials else ""
    lines = [f'<robot name="{robot.name}">', f'<link name="base">{body}</link>']
    parent, pose, before = "base", Pose(), Pose()
    for j, joint in enumerate(robot.joints, start=1):
        pose = pose @ Pose.from_rpy((joint.d, 0.0, 0.0), (joint.alpha, 0.0, 0.0))
        pose = pose @ Pose.from_rpy((0.0, 0.0, joint.r), (0.0, 0.0, joint.theta))
        axis = AXES[(seed + j) % 6]
        along = (0.0, 0.0, float(draw.uniform(-0.2, 0.2)))
        about = draw.choice(_QUARTERS) if j < robot.n else draw.uniform(-3, 3)
        link = pose @ Pose.from_rpy(along, (0.0, 0.0, float(about))) @ turns_to(axis)
        half = Pose(origin=(0.0, 0.0, 0.05 * j))  # the fixed joint's part of the way
        for name in (f"mid{j}", f"link{j}"):
            lines.append(f'<link name="{name}">{_inertial(draw) if inertials else ""}</link>')
        lines.append(_joint(f"fix{j}", "fixed", parent, f"mid{j}", half, ""))
        kind = "prismatic" if not joint.revolute else "revolute" if limits else "continuous"
        limit = "" if kind == "continuous" else '<limit lower="-2" upper="1.5" velocity="3" effort="40"/>'
        rest = half.inverse() @ before.inverse() @ link
        lines.append(_joint(f"joint{j}", kind, f"mid{j}", f"link{j}", rest, f'<axis xyz="{axis}"/>{limit}'))
        parent, before = f"link{j}", link
    lines.append('<link name="tool0"/>')
    lines.append(_joint("flange", "fixed", parent, "tool0", Pose.from_rpy((0.02, 0.0, 0.1), (0.3, 0.2, -1.0)), ""))
    return "\n".join([*lines, "</robot>"])


def turns_to(axis: str) -> Pose:
    """A frame of which ``axis`` lies along z of the frame it stands in."""
    along = np.array([float(word) for word in axis.split()])
    for rpy in itertools.product(_QUARTERS, repeat=3):
        pose = Pose.from_rpy((0.0, 0.0, 0.0), rpy)
        if np.allclose(pose.R @ along, [0.0, 0.0, 1.0]):
            return pose
    raise ValueError(axis)


def _inertial(draw: np.random.Generator) -> str:
    mass = float(draw.uniform(0.5, 8.0))
    com, rpy = draw.uniform(-0.1, 0.1, 3), draw.uniform(-1.0, 1.0, 3)
    xx, yy = draw.uniform(0.02, 0.03, 2).tolist()
    return (
        f'<inertial><origin xyz="{numbers(com)}" rpy="{numbers(rpy)}"/><mass value="{mass!r}"/><inertia '
        f'ixx="{xx!r}" ixy="0.001" ixz="-0.002" iyy="{yy!r}" iyz="0.0015" izz="0.028"/></inertial>'
    )


def _joint(name: str, kind: str, parent: str, child: str, pose: Pose, more: str) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{numbers(pose.p)}" rpy="{numbers(np.array(pose.rpy))}"/>{more}</joint>'
    )


def numbers(values: Array) -> str:
    """Numbers as text that loses no digit."""
    return " ".join(repr(float(value)) for value in values)


Write = Callable[[str], Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """``write(text)``: a file of a robot with this text, a URDF where it begins as one."""

    def make(text: str) -> Path:
        path = tmp_path / ("arm.urdf" if text.startswith("<") else "own.toml")
        path.write_text(text, encoding="utf-8")
        return path

    return make


REFERENCE = sorted((Path(__file__).parents[1] / "reference/robots").glob("*.toml"))
ARMS = [*REFERENCE, *(Path(__file__).parents[2] / f"model/robots/{name}.toml" for name in robot_names())]


def rigid(robot: Robot) -> Robot:
    return replace(robot, drives=Drives(rotor_inertia=False, friction=()))
