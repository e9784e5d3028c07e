"""Columns taken out of rows: what they explain is gone from all others."""

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
