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
        remaining: rows in the columns that stay, then the torque and what else goes with it.
        eliminated: the same rows in the columns that are eliminated.
        place: where among ``remaining`` the levels' columns go.
        gone: names of the columns of ``eliminated``.
        anchors: of all joints; each has a level.
        joint: whose rows they are, from 0.
    """
    own = [k for k, anchor in enumerate(anchors) if anchor.joint == joint]
    (rows, width), columns = remaining.shape, list(gone)
    beside = np.zeros((rows + len(own), width + len(anchors)))
    beside[:rows, :place], beside[:rows, place + len(anchors) :] = remaining[:, :place], remaining[:, place:]
    off = np.zeros((rows + len(own), eliminated.shape[1]))
    off[:rows] = eliminated
    for row, k in enumerate(own, start=rows):
        # stiffness (parameter - level) = 0, one more row.
        beside[row, place + k] = -anchors[k].stiffness
        off[row, columns.index(anchors[k].column)] = anchors[k].stiffness
    return beside, off
