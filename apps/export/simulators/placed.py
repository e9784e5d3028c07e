"""A user's own model as it is read: where its joints stand at zero, and which bodies are fixed to others."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ....common.arrays import Array
from ....common.errors import InputError
from ....model import Pose
from ....model.files.tree import read_urdf


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


READERS: dict[str, Callable[[str], tuple[dict[str, Placed], Extra]]] = {"mjcf": _read_mjcf, "urdf": _read_urdf}
"""By the kind of file."""
