"""Recordings side by side: whether they say the same, and what differs."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtrit

from ...common.arrays import Array
from ...common.errors import InputError
from ...estimation.answers.identification import Identification
from ...estimation.fit.estimate import Estimate
from ...estimation.fit.robust import student95

TINY = np.finfo(float).tiny ** 0.25
"""No standard deviation of anything measured is smaller."""
CHANCE = 1e-3
"""Probability that recordings of one and the same thing are said to differ."""


@dataclass(frozen=True)
class Compared:
    """Parameters by several recordings, one beside the other.

    Attributes:
        sources: names of the recordings, k.
        names: of the parameters, c.
        values: k x c.
        sigma: own standard deviations, k x c.
        pooled: values by all of them, weighted by their variances, shape (c,).
        pooled_sigma: standard deviations of those, with the scatter where it is more than they say, shape (c,).
        scatter: chi2 of the values about the pooled one over its degrees of freedom, shape (c,).
        degrees_of_freedom: the fewest of the recordings.
    """

    sources: tuple[str, ...]
    names: tuple[str, ...]
    values: Array
    sigma: Array
    pooled: Array
    pooled_sigma: Array
    scatter: Array
    degrees_of_freedom: float

    @property
    def interval95(self) -> Array:
        """95 % intervals of the pooled values, c x 2."""
        half = student95(self.degrees_of_freedom) * self.pooled_sigma
        return np.column_stack([self.pooled - half, self.pooled + half])

    @property
    def apart(self) -> Array:
        """Each recording's value less what all others say, in sigmas of the difference, k x c."""
        weights = 1.0 / self.sigma**2
        total, rest = weights.sum(axis=0), weights.sum(axis=0) - weights
        others = (total * (weights * self.values).sum(axis=0) / total - weights * self.values) / rest
        return np.asarray((self.values - others) / np.sqrt(self.sigma**2 + 1.0 / rest))

    @property
    def bound(self) -> float:
        """Sigmas that none exceeds but with probability ``CHANCE``, all together (Bonferroni)."""
        return float(stdtrit(max(self.degrees_of_freedom, 1.0), 1.0 - 0.5 * CHANCE / self.values.size))

    @property
    def odd(self) -> tuple[tuple[str, str, float], ...]:
        """Recordings that differ from the others beyond ``bound``: recording, parameter, sigmas; the worst first.

        Of each parameter the worst one: what it pulls along is not told.
        """
        apart = self.apart
        worst = [(int(np.argmax(np.abs(apart[:, c]))), c) for c in range(len(self.names))]
        far = [(self.sources[k], self.names[c], float(apart[k, c])) for k, c in worst]
        return tuple(
            sorted(
                (deviation for deviation in far if abs(deviation[2]) > self.bound),
                key=lambda deviation: -abs(deviation[2]),
            )
        )


def compared(sources: Sequence[str], results: Sequence[Identification]) -> Compared:
    """Parameters of one robot by several recordings, side by side; ``sources``: their names.

    Raises:
        InputError: if the recordings show different parameters.
    """
    return side_by_side(sources, list(map(free_estimate, results)))


def side_by_side(sources: Sequence[str], estimates: Sequence[Estimate]) -> Compared:
    """Independent estimates of the same parameters, and what they say together.

    Raises:
        InputError: if they are of different parameters.
    """
    first = estimates[0]
    if any(estimate.names != first.names for estimate in estimates):
        raise InputError("the recordings show different parameters: nothing can be compared")
    values = np.array([estimate.values for estimate in estimates])
    sigma = np.maximum(np.array([estimate.sigma for estimate in estimates]), TINY)
    weights = 1.0 / sigma**2
    pooled_values = (weights * values).sum(axis=0) / weights.sum(axis=0)
    scatter = (weights * (values - pooled_values) ** 2).sum(axis=0) / (len(values) - 1)
    wide = np.sqrt(np.maximum(scatter, 1.0) / weights.sum(axis=0))
    degrees = min(estimate.degrees_of_freedom for estimate in estimates)
    return Compared(tuple(sources), first.names, values, sigma, pooled_values, wide, scatter, degrees)


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
