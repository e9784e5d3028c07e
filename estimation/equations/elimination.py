"""Columns taken out of rows: what they explain is gone from all others; equations may hold them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from ...common.arrays import Array
from ...common.linear import independent, rank, upper, without
from .shared_torque import compressed


def eliminated_from(remaining: Array, off: Array, beside: int) -> tuple[Array, Array, int]:
    """Triangular factor of some columns less what others explain, the last ones beside it, and the others' rank.

    Of clearly independent columns one QR of all that are not zero says it.

    Args:
        remaining: N x c.
        off: what is taken out, N x k.
        beside: number of the last columns of ``remaining`` that take no part in the factor.
    """
    off, width = off[:, off.any(axis=0)], remaining.shape[1] - beside
    if not len(remaining):
        return remaining[:, :width], remaining[:, width:], 0
    touched = np.append(
        np.flatnonzero(remaining[:, : width - 1].any(axis=0)), np.arange(width - 1, remaining.shape[1])
    )
    k, c = off.shape[1], len(touched) - beside
    R = upper(lapack.dgeqrf(np.column_stack([off, remaining[:, touched]]))[0][: k + c])
    if not independent(off, R):
        return *compressed(without(remaining, off), beside), rank(off)
    factor = np.zeros((len(R) - k, remaining.shape[1]))
    factor[:, touched] = R[k:, k:]
    return factor[:, :width], factor[:, width:], k


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
