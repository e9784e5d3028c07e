"""How the joint columns of a log are read: their order, senses of rotation and zeros."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi

import numpy as np

from ...common.arrays import Array
from .states import States


@dataclass(frozen=True, order=True)
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

    def swapped(self, i: int, j: int) -> "Reading":
        """The columns of two joints exchanged."""
        order = list(self.order)
        order[i], order[j] = order[j], order[i]
        return replace(self, order=tuple(order))

    def turned(self, *joints: int) -> "Reading":
        """Some joints counted the other way."""
        return replace(self, sign=_flipped(self.sign, joints))

    def pushed(self, j: int) -> "Reading":
        """The torque of one joint alone with the other sign."""
        return replace(self, torque=_flipped(self.torque, (j,)))

    def moved(self, j: int, quarters: int) -> "Reading":
        """The zero of one joint moved."""
        there = (self.quarters[j] + quarters) % 4
        return replace(self, quarters=(*self.quarters[:j], there, *self.quarters[j + 1 :]))

    def positions(self, q: Array) -> Array:
        """Joint positions [rad or m] from a log's, N x n."""
        return np.asarray(q[:, list(self.order)] * np.array(self.sign) + np.array(self.quarters) * (pi / 2))

    def of(self, states: States) -> States:
        """Read the states of a log."""
        order, sign = list(self.order), np.array(self.sign)
        return replace(
            states,
            q=self.positions(states.q),
            qd=states.qd[:, order] * sign,
            qdd=states.qdd[:, order] * sign,
            torque=states.torque[:, order] * (sign * np.array(self.torque)),
            slope=states.slope[:, order] * (sign * np.array(self.torque)),
            keep=states.keep[:, order],
        )

    @property
    def changes(self) -> int:
        """Number of joints and columns that are not taken as they stand."""
        moved = sum(column != j for j, column in enumerate(self.order))
        signs = sum(sign < 0 for sign in (*self.sign, *self.torque))
        return moved + signs + sum(quarter != 0 for quarter in self.quarters)

    def told(self) -> str:
        """Describe the reading, joints counted from 1; "as recorded" if nothing is changed."""
        parts = []
        for j in range(len(self.order)):
            changes = []
            if self.order[j] != j:
                changes.append(f"from column {self.order[j] + 1}")
            if self.sign[j] < 0:
                changes.append("turned round (position and torque)")
            if self.quarters[j]:
                changes.append(f"zero moved by {(90, 180, -90)[self.quarters[j] - 1]} degrees")
            if self.torque[j] < 0:
                changes.append("torque turned round")
            if changes:
                parts.append(f"joint {j + 1} {', '.join(changes)}")
        return "; ".join(parts) or "as recorded"


def _flipped(signs: tuple[int, ...], joints: Sequence[int]) -> tuple[int, ...]:
    return tuple(-sign if j in joints else sign for j, sign in enumerate(signs))
