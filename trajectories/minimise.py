"""Minimises a smooth number over a family's bounds by L-BFGS."""

from collections.abc import Callable

import numpy as np
from scipy.optimize import minimize

from ..common.arrays import Array
from .problem import DesignProblem

_MEMORY = 40  # pairs of steps and slopes that L-BFGS keeps
_LARGE = 1e6  # stands for inf: the line search then goes back


def minimised(
    function: Callable[[Array], tuple[float, Array]], x: Array, problem: DesignProblem, iterations: int
) -> tuple[Array, int]:
    """The best x found, and the number of evaluations."""

    def finite(y: Array) -> tuple[float, Array]:
        value, slope = function(y)
        return (value, slope) if np.isfinite(value) else (_LARGE, slope)

    family = problem.family
    answer = minimize(
        finite,
        x,
        jac=True,
        method="L-BFGS-B",
        bounds=np.column_stack([family.low, family.high]),
        options={"maxiter": iterations, "maxfun": 2 * iterations, "maxcor": _MEMORY, "ftol": 1e-8, "gtol": 1e-6},
    )
    return np.asarray(answer.x), int(answer.nfev)
