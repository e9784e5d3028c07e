"""Modified DH frames of a chain that is given by its joint axes at the zero pose.

This is how an arm is described on a data sheet and in a URDF: where each axis lies, which way is positive. Frames
follow Khalil and Kleinfinger: z_j along axis j, x_j along the common normal of the axes j and j + 1.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...common import Array
from ..frames import with_gravity
from ..pose import Pose
from ..robot import SNAP_ANGLE, SNAP_LENGTH, Joint, Limits, Robot


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
        if not all(math.isfinite(value) for value in (*self.direction, *self.point)):
            raise ValueError("direction and point of an axis must be finite")
        if math.hypot(*self.direction) < 1e-9:
            raise ValueError("an axis needs a direction")


_Line = tuple[Array, Array]  # axis as its direction, of length 1, and a point on it


def modified_dh(axes: Sequence[JointAxis], flange: Pose) -> Robot:
    """Robot of a chain's axes, gravity along -z of its base, with every freedom used for plain numbers.

    Frame 0 is the base wherever the first axis allows it, frame n the flange wherever the last one does; axes
    within 1e-4 rad of parallel, or 1e-6 m of meeting, are taken as such.

    Args:
        axes: of the joints 1 to n at the zero pose, in the base.
        flange: the flange at the zero pose, in the base.
    """
    lines = list[_Line]()
    for axis in axes:
        direction = np.array(axis.direction) / np.linalg.norm(axis.direction)
        special = np.where(np.abs(direction) < SNAP_ANGLE, 0.0, direction)
        lines.append((special / np.linalg.norm(special), np.array(axis.point, dtype=float)))
    # Frame 0 is the base, if its x axis meets the first joint's at a right angle.
    x, z, origin = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]), np.zeros(3)
    first, foot = lines[0][0], _foot(origin, *lines[0])
    if abs(first @ x) >= SNAP_ANGLE or np.linalg.norm(foot[1:]) >= SNAP_LENGTH:
        x, z, origin = _perpendicular(first, x), first, foot
    base, joints = _pose(x, z, origin).inverse(), list[Joint]()
    for j, (axis, line) in enumerate(zip(axes, lines, strict=True)):
        direction = line[0]
        # x of the frame before meets this axis at a right angle, so this is where.
        foot = _foot(origin, *line)
        if j + 1 < len(axes):
            new_x, new_origin = _common_normal(x, line, lines[j + 1], foot)
        else:  # the flange where its z axis lies on the last joint's, as near as can be elsewhere
            wish = flange.R[:, 0]
            across = np.linalg.norm(np.cross(wish, direction)) > SNAP_ANGLE
            new_x, new_origin = _perpendicular(direction, wish) if across else x, _foot(flange.p, direction, foot)
        joints.append(
            Joint(
                axis.kind,
                alpha=_angle(z, direction, x),
                d=_along(foot - origin, x),
                theta=_angle(x, new_x, direction),
                r=_along(new_origin - foot, direction),
                limits=axis.limits,
            )
        )
        x, z, origin = new_x, direction, new_origin
    robot = Robot("robot", tuple(joints), flange=_pose(x, z, origin).inverse() @ flange, base=base)
    return with_gravity(robot, (0.0, 0.0, -9.81))


def _foot(origin: Array, direction: Array, point: Array) -> Array:
    return np.asarray(point + ((origin - point) @ direction) * direction)


def _perpendicular(direction: Array, wish: Array) -> Array:
    """Unit vector at a right angle to ``direction``, near ``wish`` where that is possible."""
    across = wish - (wish @ direction) * direction
    if np.linalg.norm(across) < SNAP_ANGLE:
        across = np.eye(3)[int(np.argmin(np.abs(direction)))]
        across = across - (across @ direction) * direction
    return np.asarray(across / np.linalg.norm(across))


def _common_normal(x: Array, axis: _Line, after: _Line, foot: Array) -> tuple[Array, Array]:
    """Choose x, along the common normal of an axis and the next one, and origin of the axis's frame.

    Of both directions it takes the one near the ``x`` before, which meets the axis at its ``foot``; if neither is
    near it, the one towards the next axis.
    """
    (direction, point), (next_direction, there) = axis, after
    normal, between = np.cross(direction, next_direction), there - point
    size = float(np.linalg.norm(normal))
    if size < SNAP_ANGLE:
        normal, origin = between - (between @ direction) * direction, foot
        size = apart = float(np.linalg.norm(normal))
        if apart < SNAP_LENGTH:
            return x, foot
    else:  # the nearest point to the next axis
        origin = point + np.cross(between, next_direction) @ normal / size**2 * direction
        apart = float(between @ normal) / size
    normal = normal / size
    side = float(normal @ x)
    if abs(side) < 1e-9:
        side = apart if abs(apart) > SNAP_LENGTH else float(np.cross(x, normal) @ direction)
    return (normal if side > 0.0 else -normal), origin


def _pose(x: Array, z: Array, origin: Array) -> Pose:
    return Pose.of(np.column_stack([x, np.cross(z, x), z]), origin)


def _angle(before: Array, after: Array, axis: Array) -> float:
    return math.atan2(float(np.cross(before, after) @ axis), float(before @ after))


def _along(step: Array, direction: Array) -> float:
    return round(float(step @ direction), 12) + 0.0
