"""Numbers as they are written: with as many digits as their uncertainty allows or all, entries, axes and turns."""

import math
from collections.abc import Iterable
from itertools import permutations, product

import numpy as np
from numpy.typing import ArrayLike

from ..common.arrays import Array
from ..model import Pose

_UNKNOWN = 4  # decimals where no uncertainty is known
_MOST = 9


def interval_digits(width: float) -> int:
    """Decimals that show two digits of half an interval of that width."""
    if not np.isfinite(width) or width <= 0.0:
        return _UNKNOWN
    return min(max(0, 1 - int(np.floor(np.log10(width / 2.0)))), _MOST)


def rounded(value: float, digits: int, missing: str = "-") -> str:
    """A number to so many decimals, zero without a sign; ``missing`` where there is none."""
    return f"{round(value, digits) + 0.0:.{digits}f}" if np.isfinite(value) else missing


def with_interval(value: float, low: float, high: float) -> tuple[str, str]:
    """Value and interval as texts, to the same place; a dash where there is none."""
    if not np.isfinite([value, low, high]).all():
        return f"{value + 0.0:.4g}" if np.isfinite(value) else "-", "-"
    digits = interval_digits(high - low)
    return rounded(value, digits), f"{rounded(low, digits)} to {rounded(high, digits)}"


def with_sigma(value: float, sigma: float) -> str:
    """Value and standard deviation in one cell: two digits of sigma, the value to the same place."""
    if not np.isfinite(sigma) or sigma <= 0.0:
        return f"{value:.6g}"
    digits = interval_digits(2.0 * sigma)
    return f"{value:.{digits}f}±{sigma:.{digits}f}"


def joined(values: Iterable[float], form: str, separator: str = ", ") -> str:
    """Numbers in a format, one after the other."""
    return separator.join(format(value, form) for value in values)


def percent(share: float) -> str:
    """A share in percent, three digits; a dash where there is none."""
    return f"{100.0 * share:.3g} %" if np.isfinite(share) else "-"


def placed(pose: Pose) -> str:
    """Origin and roll, pitch, yaw of a frame as they are typed: metres and degrees."""
    turn = joined((math.degrees(angle) + 0.0 for angle in pose.rpy), "g")
    return f"({joined((x + 0.0 for x in pose.origin), 'g')}) m, ({turn}) deg"


def exact(values: ArrayLike, separator: str = " ") -> str:
    """Numbers with all their digits, for a program to read."""
    return separator.join(repr(float(value) + 0.0) for value in np.ravel(values))


SIX = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Places of the entries of a symmetric matrix, as Universal Robots, MuJoCo and Drake take them."""

ENTRIES = ((0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2))
"""Rows and columns of them: what takes all six from a matrix."""


def inertia_entries(J: Array) -> dict[str, str]:
    """Entries ixx, ixy, ixz, iyy, iyz, izz of an inertia matrix, as URDF and SDFormat call them."""
    return {f"i{'xyz'[i]}{'xyz'[k]}": exact(J[i, k]) for i, k in zip(*np.triu_indices(3), strict=True)}


def principal_axes(inertia: Array) -> tuple[Array, Array]:
    """Moments (3,) and axes (columns, 3 x 3) with inertia = R diag(moments) R', det R = +1.

    Of the 24 right-handed choices the one that turns least against the frame's own axes, so that a diagonal inertia
    keeps its order and gets no rotation.
    """
    if not (inertia - np.diag(np.diag(inertia))).any():
        return np.diag(inertia).copy(), np.eye(3)
    moments, axes = np.linalg.eigh(inertia)
    turned = product(map(list, permutations(range(3))), product((1.0, -1.0), repeat=3))
    choices = ((order, np.array(signs) * axes[:, order]) for order, signs in turned)
    right_handed = [(order, R) for order, R in choices if np.linalg.det(R) > 0.0]
    order, R = max(right_handed, key=lambda choice: float(np.trace(choice[1])))
    return moments[order], R


def quaternion(R: Array) -> Array:
    """Unit quaternion (w, x, y, z) of a rotation matrix, w >= 0, shape (4,)."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(R).as_quat(canonical=True, scalar_first=True)) + 0.0
