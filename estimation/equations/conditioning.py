"""How well a matrix determines parameters: condition numbers, and directions that it leaves open."""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import lapack

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import RANK_TOLERANCE, decomposed


def check_rank(W: Array, columns: Sequence[str], rows: int) -> None:
    """Refuse data that leave a direction of the parameters undetermined.

    Args:
        W: observation matrix or its triangular factor, k x c.
        columns: names of the parameters.
        rows: number of equations behind it.
    """
    if rows < len(columns):
        raise InputError(
            f"{rows} equations for {len(columns)} parameters: fewer samples than parameters; record longer "
            "or decimate less"
        )
    if _clearly_determined(scaled(W)):
        return
    undetermined = decomposed(W).null
    if undetermined.size:
        weight = np.abs(undetermined).max(axis=1)
        named = [name for name, w in zip(columns, weight, strict=True) if w > 0.05]
        raise InputError(
            f"the recorded motion leaves {undetermined.shape[1]} of {len(columns)} directions undetermined, in "
            f"{', '.join(named)}: move more joints, faster and over a wider range"
        )


def _clearly_determined(W: Array) -> bool:
    """By LAPACK's condition estimate of a triangle, which costs nothing beside singular values; False if in doubt.

    The estimate is rarely off by more than 3, and the 1-norm's condition within c of the 2-norm's.
    """
    c = W.shape[1]
    if len(W) < c or np.any(np.tril(W, -1)):
        return False
    reciprocal, failed = lapack.dtrcon(W[:c])
    return not failed and bool(reciprocal > 10.0 * c * RANK_TOLERANCE)


def scaled(W: Array) -> Array:
    """Columns of norm 1; columns of zeros as they are."""
    norms = np.linalg.norm(W, axis=0)
    return np.asarray(W / np.where(norms > 0.0, norms, 1.0))


def condition(W: Array) -> float:
    """Condition number; infinite for a rank-deficient matrix."""
    singular = np.linalg.svd(W, compute_uv=False)
    if len(singular) < W.shape[1] or singular[-1] <= 1e-14 * singular[0]:
        return float("inf")
    return float(singular[0] / singular[-1])
