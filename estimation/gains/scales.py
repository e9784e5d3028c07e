"""Relative scales of the joints' torques, from one recording without payload."""

from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ..equations.problem import ReducedProblem
from .current_side import current_weights, gauss_newton

_TOLD = 0.2
"""Standard deviation of a scale's logarithm above which the recording does not tell it."""


class RelativeScales(NamedTuple):
    """What joint j's signal must be multiplied by to agree with joint ``held``'s (from 0).

    ``ratio`` (n,), ``sigma`` of its logarithm (n,), for white noise; 1 and 0 at ``held``. A last joint that carries
    next to nothing has a scale that nothing tells: its ratio is 1 and its sigma infinite.
    """

    ratio: Array
    sigma: Array
    held: int


def relative_scales(problem: ReducedProblem) -> RelativeScales:
    """Scales by the links whose parameters several joints' torques show, fitted on the signals' side.

    Args:
        problem: W and any signals proportional to torques, joint by joint.

    Raises:
        InputError: if the recording does not determine them.
    """
    weights = current_weights(problem)
    held = int(np.argmax(problem.torque_norms * weights))
    c = len(problem.columns)
    found = gauss_newton(problem, weights, range(c), np.zeros(c), held)
    sigma = np.sqrt(np.diag(found.covariance))
    told = (found.k > 0.0) & (sigma < _TOLD)
    return RelativeScales(1.0 / np.where(told, found.k, 1.0), np.where(told, sigma, np.inf), held)
