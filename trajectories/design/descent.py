"""A descent to the nearest minimum: BFGS that goes on from the curvature it knows, L-BFGS where that cannot be."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from ...common.arrays import Array
from ..motions.samples import Family

Smooth = Callable[[Array], tuple[float, Array]]
"""A smooth number of a motion, and its gradient."""
_MEMORY = 40  # pairs of steps and slopes that L-BFGS keeps
_LARGE = 1e6  # stands for inf: the line search then goes back
_MOST = 150  # numbers whose curvature is kept: above it the matrix takes longer than the motion
_FLAT = 1e-6  # slope at which a descent ends


class Minimum(NamedTuple):
    """Where a descent ended.

    Attributes:
        x: the motion.
        evaluations: of the number and its gradient.
        curvature: inverse of the second derivatives as the steps showed them; None where it is not kept.
    """

    x: Array
    evaluations: int
    curvature: Array | None = None


def keeps_curvature(family: Family) -> bool:
    """Whether descents of a family go on from each other's curvature: few numbers without bounds."""
    return family.size <= _MOST and not np.isfinite(np.concatenate([family.low, family.high])).any()


def minimised(
    function: Smooth, x: Array, family: Family, iterations: int, curvature: Array | None = None
) -> Minimum:
    """Minimise a smooth number within a family's bounds.

    Args:
        function: gives the number and its gradient; inf where there is none.
        x: where the descent begins.
        family: bounds x.
        iterations: at most.
        curvature: of an earlier descent whose minimum is near; None without.
    """

    def finite(y: Array) -> tuple[float, Array]:
        value, slope = function(y)
        return (value, slope) if np.isfinite(value) else (_LARGE, slope)

    if not keeps_curvature(family):
        bounds = np.column_stack([family.low, family.high])
        options = {"maxiter": iterations, "maxfun": 2 * iterations, "maxcor": _MEMORY, "ftol": 1e-8, "gtol": _FLAT}
        answer = minimize(finite, x, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
        return Minimum(np.asarray(answer.x), int(answer.nfev))
    known = {} if curvature is None else {"hess_inv0": curvature}
    answer = minimize(finite, x, jac=True, method="BFGS", options={"maxiter": iterations, "gtol": _FLAT, **known})
    if curvature is not None and answer.nit == 0:  # what was known leads nowhere here
        again = minimised(function, x, family, iterations)
        return again._replace(evaluations=again.evaluations + int(answer.nfev))
    return Minimum(np.asarray(answer.x), int(answer.nfev), _definite(np.asarray(answer.hess_inv)))


def _definite(matrix: Array) -> Array | None:
    """The matrix, symmetric to the last bit; None unless it is positive definite."""
    matrix = 0.5 * (matrix + matrix.T)
    try:
        np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        return None
    return matrix
