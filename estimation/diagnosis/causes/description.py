"""A robot that is not the one described: mounted otherwise, other lengths, coupled drives, another arm."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ....common.arrays import Array
from ....model import Coupling, Robot, load_robot, robot_names
from .misfit import Model
from .sample import Sample
from .suspect import Suspect


def gravity(robot: Robot, sample: Sample) -> Iterator[Suspect]:
    """Gravity missing from the torques, or along another axis."""
    usual = np.array(robot.gravity)
    size = float(np.linalg.norm(usual)) or 9.81
    yield _mounted(robot, sample, np.zeros(3), "the torques hold no gravity (they are gravity-compensated)")
    yield _mounted(robot, sample, -usual, "gravity points the other way (the robot is mounted upside down)")
    for axis in range(3):
        if abs(usual[axis]) > 0.9 * size:
            continue
        for sign in (1.0, -1.0):
            words = (
                f"gravity points along {'-' * (sign < 0)}{'xyz'[axis]} of frame 0 (the robot is mounted on a wall)"
            )
            yield _mounted(robot, sample, sign * size * np.eye(3)[axis], words)


def coupled(robot: Robot, sample: Sample) -> Iterator[Suspect]:
    """The last two drives coupled, where the description knows nothing of it."""
    if robot.coupling is None and robot.n > 1:
        pair = (robot.n - 1, robot.n)
        other = replace(robot, drives=replace(robot.drives, coupling=Coupling(pair)))
        words = f"the drives of joints {pair[0]} and {pair[1]} are coupled, which the description leaves out"
        yield Suspect(words, Model.of(other, sample).misfit())


def lengths(robot: Robot, sample: Sample) -> Iterator[Suspect]:
    """A length that is a tenth off."""
    for j, joint in enumerate(robot.joints):
        for name in ("d", "r"):
            length = getattr(joint, name)
            if length == 0.0:
                continue
            for factor in (0.9, 1.1):
                changed = replace(joint, **{name: factor * length})
                other = replace(robot, joints=(*robot.joints[:j], changed, *robot.joints[j + 1 :]))
                word = "shorter" if factor < 1.0 else "longer"
                yield Suspect(
                    f"the length {name}{j + 1} is {word} than the {length:g} m of the description",
                    Model.of(other, sample).misfit(),
                )


def other_robots(robot: Robot, sample: Sample) -> Iterator[Suspect]:
    """The recording of another robot that comes with the package."""
    for name in robot_names():
        other = load_robot(name)
        if name != robot.name and other.n == robot.n:
            yield Suspect(f"it is a recording of robot {name!r}", Model.of(other, sample).misfit())


def _mounted(robot: Robot, sample: Sample, g: Array, words: str) -> Suspect:
    other = replace(robot, gravity=(float(g[0]), float(g[1]), float(g[2])))
    return Suspect(words, Model.of(other, sample).misfit())
