"""Modified DH frames of a chain that is given by its joint axes at the zero pose.

This is how an arm is described on a data sheet and in a URDF: where each axis lies, which way is positive. Frames
follow Khalil and Kleinfinger: z_j along axis j, x_j along the common normal of the axes j and j + 1.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from ...common.arrays import Array
from ..pose import Pose
from ..robot import SNAP_ANGLE, SNAP_LENGTH, Joint, Limits


@dataclass(frozen=True)
class JointAxis:
    """A joint's axis at the zero pose, in the base's frame.

    Attributes:
        direction: along the positive sense (right-hand rule), of any length but zero.
        point: a point on the axis [m].
    """

    kind: Literal["revolute", "prismatic"]
    direction: tuple[float, float, float]
    point: tuple[float, float, float]
    limits: Limits = Limits()

    def __post_init__(self) -> None:
        """Refuse numbers that are not finite and an axis without direction."""
        if not all(math.isfinite(value) for value in (*self.direction, *self.point)):
            raise ValueError("direction and point of an axis must be finite")
        if math.hypot(*self.direction) < 1e-9:
            raise ValueError("an axis needs a direction")


class Reframed(NamedTuple):
    """A chain in modified DH.

    ``joints``; ``base``: the base in frame 0; ``frames``: frames 1 to n in the base at the zero pose;
    ``flange``: the flange in frame n.
    """

    joints: tuple[Joint, ...]
    base: Pose
    frames: tuple[Pose, ...]
    flange: Pose


_Frame = tuple[Array, Array, Array]
"""Frame as its directions x and z, and its origin."""


def modified_dh(axes: Sequence[JointAxis], flange: Pose) -> Reframed:
    """Modified DH parameters of a chain, with every freedom used for plain numbers.

    Frame 0 is the base wherever the first axis allows it, frame n the flange wherever the last one does; axes
    within 1e-4 rad of parallel, or 1e-6 m of meeting, are taken as such.

    Args:
        axes: of the joints 1 to n at the zero pose, in the base.
        flange: the flange at the zero pose, in the base.
    """
    lines = [_line(axis) for axis in axes]
    x, z, origin = zero = _frame_zero(*lines[0])
    frames: list[Pose] = []
    joints: list[Joint] = []
    for j, axis in enumerate(axes):
        direction, point = lines[j]
        # x of the frame before meets this axis at a right angle, so this is where.
        foot = _foot(origin, direction, point)
        after = lines[j + 1] if j + 1 < len(axes) else None
        new = _frame(x, direction, point, foot, after) if after else _last(x, direction, foot, flange)
        joints.append(
            Joint(
                axis.kind,
                alpha=_angle(z, direction, x),
                d=_along(foot - origin, x),
                theta=_angle(x, new[0], direction),
                r=_along(new[2] - foot, direction),
                limits=axis.limits,
            )
        )
        frames.append(_pose(*new))
        x, z, origin = new
    return Reframed(tuple(joints), _pose(*zero).inverse(), tuple(frames), frames[-1].inverse() @ flange)


def _line(axis: JointAxis) -> tuple[Array, Array]:
    direction = np.array(axis.direction, dtype=float)
    direction = direction / np.linalg.norm(direction)
    special = np.where(np.abs(direction) < SNAP_ANGLE, 0.0, direction)
    return special / np.linalg.norm(special), np.array(axis.point, dtype=float)


def _foot(origin: Array, direction: Array, point: Array) -> Array:
    """Point of an axis nearest to ``origin``."""
    return np.asarray(point + ((origin - point) @ direction) * direction)


def _frame_zero(direction: Array, point: Array) -> _Frame:
    """Choose frame 0: the base if its x axis meets the first joint's at a right angle, else on the first axis."""
    x = np.array([1.0, 0.0, 0.0])
    origin = np.zeros(3)
    foot = _foot(origin, direction, point)
    across = foot - (foot @ x) * x
    if abs(direction @ x) < SNAP_ANGLE and np.linalg.norm(across) < SNAP_LENGTH:
        return x, np.array([0.0, 0.0, 1.0]), origin
    return _perpendicular(direction, x), direction, foot


def _perpendicular(direction: Array, wish: Array) -> Array:
    """Unit vector at a right angle to ``direction``, near ``wish`` where that is possible."""
    across = wish - (wish @ direction) * direction
    if np.linalg.norm(across) < SNAP_ANGLE:
        across = np.eye(3)[int(np.argmin(np.abs(direction)))]
        across = across - (across @ direction) * direction
    return np.asarray(across / np.linalg.norm(across))


def _frame(x: Array, direction: Array, point: Array, foot: Array, after: tuple[Array, Array]) -> _Frame:
    """Frame on an axis with x along the common normal to the next one."""
    next_direction, there = after
    normal = np.cross(direction, next_direction)
    size = float(np.linalg.norm(normal))
    if size < SNAP_ANGLE:
        across = there - point - ((there - point) @ direction) * direction
        apart = float(np.linalg.norm(across))
        return x if apart < SNAP_LENGTH else _turned(across, x, direction, apart), direction, foot
    # Nearest point of this axis to the next one.
    along = float(np.cross(there - point, next_direction) @ normal) / size**2
    distance = float((there - point) @ normal) / size
    return _turned(normal, x, direction, distance), direction, point + along * direction


def _turned(normal: Array, x: Array, direction: Array, apart: float) -> Array:
    """Turn a normal towards x; if neither direction is near it, towards the next axis.

    Args:
        normal: along the common normal.
        apart: signed distance of the next axis along ``normal`` [m].
    """
    normal = np.asarray(normal / np.linalg.norm(normal))
    side = float(normal @ x)
    if abs(side) < 1e-9:
        side = apart if abs(apart) > SNAP_LENGTH else float(np.cross(x, normal) @ direction)
    return np.asarray(normal if side > 0.0 else -normal)


def _last(x: Array, direction: Array, foot: Array, flange: Pose) -> _Frame:
    """Choose frame n: the flange where its z axis lies on the last joint's, as near as can be elsewhere."""
    wish = flange.R[:, 0]
    x = x if np.linalg.norm(np.cross(wish, direction)) < SNAP_ANGLE else _perpendicular(direction, wish)
    return x, direction, _foot(flange.p, direction, foot)


def _pose(x: Array, z: Array, origin: Array) -> Pose:
    return Pose.of(np.column_stack([x, np.cross(z, x), z]), origin)


def _angle(before: Array, after: Array, axis: Array) -> float:
    return math.atan2(float(np.cross(before, after) @ axis), float(before @ after))


def _along(step: Array, direction: Array) -> float:
    return round(float(step @ direction), 12) + 0.0
