"""Equations that hold parameters which are eliminated."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array


class Anchor(NamedTuple):
    """One more equation for a column that is eliminated: its parameter is ``level``, with ``stiffness``.

    ``column``: which; ``joint``: among whose rows (from 0) the equation stands; ``stiffness``: its weight in units
    of those rows; ``level``: the new column's name.
    """

    column: str
    joint: int
    stiffness: float
    level: str


def anchored(
    remaining: Array, eliminated: Array, place: int, gone: Sequence[str], anchors: Sequence[Anchor], joint: int
) -> tuple[Array, Array]:
    """Rows of one joint with columns for the anchors' levels, and its anchors' equations below.

    Args:
        kept: rows in the columns that stay, then the torque and what else goes with it.
        off: the same rows in the columns that are eliminated.
        place: where among ``kept`` the levels' columns go.
        gone: names of the columns of ``off``.
        anchors: of all joints; each has a level.
        joint: whose rows they are, from 0.
    """
    remaining = np.insert(remaining, [place] * len(anchors), 0.0, axis=1)
    for k, anchor in enumerate(anchors):
        if anchor.joint == joint:
            # stiffness (parameter - level) = 0, one more row.
            level, parameter = np.zeros((1, remaining.shape[1])), np.zeros((1, eliminated.shape[1]))
            level[0, place + k] = -anchor.stiffness
            parameter[0, list(gone).index(anchor.column)] = anchor.stiffness
            remaining, eliminated = np.vstack([remaining, level]), np.vstack([eliminated, parameter])
    return remaining, eliminated
