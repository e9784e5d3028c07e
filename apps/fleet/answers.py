"""Standard deviations by which recordings of one arm are compared."""

from dataclasses import replace

import numpy as np

from ...common.arrays import Array
from ...estimation.answers.identification import Identification
from ...estimation.fit.estimate import Estimate

TINY = np.finfo(float).tiny ** 0.25
"""No standard deviation of anything measured is smaller."""


def free_estimate(answer: Identification) -> Estimate:
    """The estimate to compare with others of one arm: without the drive gains' errors, which all share."""
    own = answer.estimate
    ratio = compared_sigma(own, own.sigma_robust) / np.maximum(own.sigma, TINY)
    return replace(own, covariance=own.covariance * np.outer(ratio, ratio), robust=None, gain_covariance=None)


def compared_sigma(estimate: Estimate, robust: Array | None) -> Array:
    """Standard deviations to compare recordings by, shape (c,), with the formula's degrees of freedom.

    From a dozen blocks the jackknife knows no single standard deviation well, but well by how much they are larger
    than the formula's on the whole. The larger of its own and of the formula's, so scaled, is taken.

    Args:
        estimate: with the formula's.
        robust: the jackknife's, shape (c,); None without.
    """
    if robust is None:
        return estimate.sigma
    excess = float(np.sqrt(np.mean((robust / np.maximum(estimate.sigma, TINY)) ** 2)))
    return np.asarray(np.maximum(robust, max(1.0, excess) * estimate.sigma))
