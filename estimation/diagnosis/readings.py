"""Ways to read a log's joint columns: in another order, turned, counted from another zero."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations, pairwise, product
from math import pi

import numpy as np

from ...common.arrays import Array
from ...model import Robot


@dataclass(frozen=True)
class Reading:
    """How joint j of the robot is read: q_j = sign_j q_log[order_j] + quarters_j 90 degrees.

    Attributes:
        order: for each joint the column of the log, counted from 0.
        sign: +1 or -1: the log's sense of rotation, torque included.
        quarters: quarter turns to add, 0 to 3.
        torque: +1 or -1: sign of the torque alone.
    """

    order: tuple[int, ...]
    sign: tuple[int, ...]
    quarters: tuple[int, ...]
    torque: tuple[int, ...]

    @staticmethod
    def as_recorded(n: int) -> "Reading":
        """Every column as it stands."""
        return Reading(tuple(range(n)), (1,) * n, (0,) * n, (1,) * n)

    def positions(self, q: Array) -> Array:
        """Joint positions [rad or m] from a log's, N x n."""
        return np.asarray(self.rates(q) + np.array(self.quarters) * (pi / 2))

    def rates(self, values: Array) -> Array:
        """Speeds or accelerations from a log's, N x n."""
        return np.asarray(values[:, list(self.order)] * np.array(self.sign))

    def torques(self, values: Array) -> Array:
        """Joint torques [N·m or N] from a log's, N x n."""
        return np.asarray(self.rates(values) * np.array(self.torque))

    @property
    def changes(self) -> int:
        """Number of joints and columns that are not taken as they stand."""
        moved = sum(column != j for j, column in enumerate(self.order))
        signs = sum(sign < 0 for sign in (*self.sign, *self.torque))
        return moved + signs + sum(quarter != 0 for quarter in self.quarters)

    def told(self) -> str:
        """In words, joints counted from 1; "as recorded" if nothing is changed."""
        parts = []
        for j in range(len(self.order)):
            words = []
            if self.order[j] != j:
                words.append(f"from column {self.order[j] + 1}")
            if self.sign[j] < 0:
                words.append("turned round (position and torque)")
            if self.quarters[j]:
                words.append(f"zero moved by {(90, 180, -90)[self.quarters[j] - 1]} degrees")
            if self.torque[j] < 0:
                words.append("torque turned round")
            if words:
                parts.append(f"joint {j + 1} {', '.join(words)}")
        return "; ".join(parts) or "as recorded"


def neighbours(robot: Robot, reading: Reading, torques: bool = True) -> Iterator[Reading]:
    """Readings one or two changes away, in a fixed order.

    Single changes of order (two columns swapped), sense, torque sign and zero; then two joints' senses, one
    joint's sense and zero, and the zeros of two joints in a row.

    Args:
        robot: zeros of its revolute joints are changed by quarter turns.
        reading: where to start.
        torques: whether the torque's sign alone is in question.
    """
    joints = range(robot.n)
    turning = [j for j in joints if robot.joints[j].revolute]
    for i, j in combinations(joints, 2):
        order = list(reading.order)
        order[i], order[j] = order[j], order[i]
        yield replace(reading, order=tuple(order))
    for j in joints:
        yield replace(reading, sign=_flipped(reading.sign, j))
        if torques:
            yield replace(reading, torque=_flipped(reading.torque, j))
    for j, step in product(turning, (1, 2, 3)):
        yield replace(reading, quarters=_turned(reading.quarters, j, step))
    for i, j in combinations(joints, 2):
        yield replace(reading, sign=_flipped(_flipped(reading.sign, i), j))
    for j, step in product(turning, (1, 2, 3)):
        flipped = _flipped(reading.sign, j)
        yield replace(reading, sign=flipped, quarters=_turned(reading.quarters, j, step))
    for i, j in pairwise(turning):
        for a, b in product((1, 2, 3), repeat=2):
            yield replace(reading, quarters=_turned(_turned(reading.quarters, i, a), j, b))


def _flipped(signs: tuple[int, ...], j: int) -> tuple[int, ...]:
    return (*signs[:j], -signs[j], *signs[j + 1 :])


def _turned(quarters: tuple[int, ...], j: int, step: int) -> tuple[int, ...]:
    return (*quarters[:j], (quarters[j] + step) % 4, *quarters[j + 1 :])
