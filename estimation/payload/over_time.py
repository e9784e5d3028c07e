"""The payload in each stretch of the loaded recordings: whether it stayed the same all the while."""

from dataclasses import dataclass

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ..equations.names import PAYLOAD
from ..equations.problem import ReducedProblem
from ..fit.least_squares import solve, weighted
from .problem import FixedWeights, PayloadProblem


@dataclass(frozen=True)
class Stretch:
    """The payload by one stretch of time, the robot's parameters as known.

    Attributes:
        values: the ten, shape (10,).
        covariance: by the formula, 10 x 10.
    """

    values: Array
    covariance: Array


def payload_over_time(problem: PayloadProblem, weights: FixedWeights) -> tuple[Stretch, ...]:
    """Method 1 on the stretches of the loaded recordings, in the order of time.

    Stretches that leave parameters undetermined are left out; none without blocks of time.
    """
    known = problem.known
    if known is None and problem.unloaded is not None:
        known = weighted(problem.unloaded, weights.robot)
    if problem.blocks is None or known is None:
        return ()
    found = [_stretch(part, known.values, weights.own) for part in problem.blocks.stretches]
    return tuple(stretch for stretch in found if stretch is not None)


def _stretch(part: ReducedProblem, chi: Array, weights: Array) -> Stretch | None:
    k = len(chi)
    factor = part.stacked(weights)
    own = np.column_stack([factor[:, k:-1], factor[:, -1] - factor[:, :k] @ chi])
    try:
        solution = solve(own, PAYLOAD, part.equations, sum(part.effective_rows))
    except InputError:
        return None
    return Stretch(solution.values, solution.covariance)
