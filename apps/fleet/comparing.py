"""Parameters by several recordings side by side, and the odd one among them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import stdtrit

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.schema import Document, Matrix, Vector
from ...estimation.answers.identification import Identification
from ...estimation.fit.covariance import student95
from ...estimation.fit.estimate import Estimate

TINY = np.finfo(float).tiny ** 0.25
"""No standard deviation of anything measured is smaller."""
CHANCE = 1e-3
"""Probability that recordings of one and the same thing are said to differ."""


class OddDocument(Document, frozen=True):
    """A recording that differs from all others in a parameter, in standard deviations of the difference."""

    recording: str
    parameter: str
    sigmas: float


class Compared(Document, frozen=True, eq=False):
    """Parameters by k recordings, one beside the other: k x c, of all recordings together c each.

    Attributes:
        pooled: by all recordings, weighted by their variances; its intervals are wider where the scatter is more
            than the sigmas say.
        scatter: chi2 of the values about the pooled one over its degrees of freedom.
        apart: each recording's value less what all others say, in sigmas of the difference.
        bound: sigmas that none exceeds but with probability ``CHANCE``, all together (Bonferroni).
        odd: recordings beyond it, the worst first; of each parameter the worst: what it pulls along is not told.
    """

    recordings: tuple[str, ...]
    parameters: tuple[str, ...]
    values: Matrix
    sigma: Matrix
    pooled: Vector
    pooled_interval95: Matrix
    scatter: Vector
    apart: Matrix
    bound: float
    odd: tuple[OddDocument, ...]


def compared(recordings: Sequence[str], results: Sequence[Identification]) -> Compared:
    """Parameters of one robot by several recordings, whose drive gains' errors, which all share, are left out.

    Raises:
        InputError: if the recordings show different parameters.
    """
    estimates = [result.estimate for result in results]
    return side_by_side(recordings, [widened(own, excess(own, own.sigma_robust)) for own in estimates])


def side_by_side(recordings: Sequence[str], estimates: Sequence[Estimate]) -> Compared:
    """Independent estimates of the same parameters.

    Raises:
        InputError: if they are of different parameters.
    """
    names, degrees = estimates[0].names, min(estimate.degrees_of_freedom for estimate in estimates)
    if any(estimate.names != names for estimate in estimates):
        raise InputError("the recordings show different parameters: nothing can be compared")
    values = np.array([estimate.values for estimate in estimates])
    sigma = np.maximum(np.array([estimate.sigma for estimate in estimates]), TINY)
    weights = sigma**-2.0
    total, others = weights.sum(axis=0), weights.sum(axis=0) - weights
    pooled = (weights * values).sum(axis=0) / total
    scatter = (weights * (values - pooled) ** 2).sum(axis=0) / (len(values) - 1)
    half = student95(degrees) * np.sqrt(np.maximum(scatter, 1.0) / total)
    by_others = (total * pooled - weights * values) / others
    apart = (values - by_others) / np.sqrt(sigma**2 + 1.0 / others)
    bound = float(stdtrit(max(degrees, 1.0), 1.0 - 0.5 * CHANCE / values.size))
    odd = [
        OddDocument(recordings[k], names[c], float(apart[k, c]))
        for c, k in enumerate(np.argmax(np.abs(apart), axis=0))
        if abs(apart[k, c]) > bound
    ]
    interval95 = np.column_stack([pooled - half, pooled + half])
    odd.sort(key=lambda each: -abs(each.sigmas))
    own = (tuple(recordings), names, values, sigma)
    return Compared(*own, pooled, interval95, scatter, apart, bound, tuple(odd))


def excess(estimate: Estimate, robust: Array | None) -> Array:
    """Ratio of the standard deviations that recordings are compared by to the formula's, shape (c,).

    From a dozen blocks the jackknife (``robust``) knows no single standard deviation well, but well how much larger
    than the formula's they are on the whole. The larger of its own and of the formula's, so scaled, is taken.
    """
    if robust is None:
        return np.ones(len(estimate.values))
    ratio = robust / np.maximum(estimate.sigma, TINY)
    return np.maximum(ratio, max(1.0, float(np.sqrt(np.mean(ratio**2)))))


def widened(estimate: Estimate, ratio: Array) -> Estimate:
    """An estimate whose standard deviations are so many times as large, without errors that all share."""
    C = estimate.covariance * np.outer(ratio, ratio)
    return replace(estimate, covariance=C, robust=None, gain_covariance=None)
