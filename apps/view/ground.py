"""What an arm stands on: the plane below it, and a foot down to that plane where the first frame is above it."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model import Pose, Robot
from ...model.stand_in import cylinder_radius
from ...trajectories import Scene
from .shapes import Colour, Shape, capsule

_FOOT: Colour = (150, 150, 150)
_LEVEL = 1e-6  # of a unit normal: what a floor may lie off the base's plane


class Ground(NamedTuple):
    """The plane z = ``height`` [m] of the base, and what the arm stands on there, in frame 0."""

    height: float
    foot: tuple[Shape, ...] = ()


def ground_of(robot: Robot, frames: Sequence[tuple[Pose, ...]], scene: Scene | None) -> Ground:
    """The scene's floor; without one the base's own plane, or the lowest place of the arm that is below it.

    Args:
        robot: the robot; its description does not say what it is bolted to.
        frames: poses of frames 0 to n and the payload's, in the base, at each time.
        scene: with a floor, or without.
    """
    first = frames[0][0]
    radius = cylinder_radius(robot)
    lowest = min(float(pose.p[2]) for poses in frames for pose in poses)
    floor = _floor(scene, first)
    height = floor if floor is not None else lowest - radius if lowest < -radius else 0.0
    if height > -radius:
        return Ground(height)
    top, end = (first.R.T @ (np.array([0.0, 0.0, z]) - first.p) for z in (0.0, height))
    unknown = "neither its height nor its shape is known" if floor is None else "its shape is not known"
    return Ground(height, (Shape(f"foot, {unknown}", 0, *capsule(top, end, 0.5 * radius), _FOOT, 0.3),))


def _floor(scene: Scene | None, first: Pose) -> float | None:
    """Height of the highest level surface under the base's origin [m]; None without one."""
    heights = []
    for surface in scene.surfaces if scene is not None else ():
        normal: Array = np.array(surface.normal) / np.linalg.norm(surface.normal)
        up = first.R @ normal
        height = surface.offset + float(up @ first.p)
        if up[2] > 1.0 - _LEVEL and height <= 0.0:
            heights.append(height)
    return max(heights, default=None)
