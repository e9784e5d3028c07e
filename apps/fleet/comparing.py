"""Parameters by several recordings side by side, and the odd one among them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import stdtrit

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.schema import Document
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


@dataclass(frozen=True)
class Compared:
    """Parameters by several recordings, one beside the other.

    Values and standard deviations are k recordings x c parameters, degrees of freedom the fewest of the recordings.
    """

    recordings: tuple[str, ...]
    parameters: tuple[str, ...]
    values: Array
    sigma: Array
    degrees_of_freedom: float

    @cached_property
    def pooled(self) -> Array:
        """Values by all of them, weighted by their variances, shape (c,)."""
        weights = 1.0 / self.sigma**2
        return np.asarray((weights * self.values).sum(axis=0) / weights.sum(axis=0))

    @cached_property
    def scatter(self) -> Array:
        """Chi2 of the values about the pooled one over its degrees of freedom, shape (c,)."""
        squares = (self.values - self.pooled) ** 2 / self.sigma**2
        return np.asarray(squares.sum(axis=0) / (len(self.values) - 1))

    @property
    def pooled_interval95(self) -> Array:
        """95 % intervals of the pooled values, with the scatter where it is more than the sigmas say, c x 2."""
        sigma = np.sqrt(np.maximum(self.scatter, 1.0) / (1.0 / self.sigma**2).sum(axis=0))
        half = student95(self.degrees_of_freedom) * sigma
        return np.column_stack([self.pooled - half, self.pooled + half])

    @property
    def apart(self) -> Array:
        """Each recording's value less what all others say, in sigmas of the difference, k x c."""
        weights = 1.0 / self.sigma**2
        total, rest = weights.sum(axis=0), weights.sum(axis=0) - weights
        others = (total * self.pooled - weights * self.values) / rest
        return np.asarray((self.values - others) / np.sqrt(self.sigma**2 + 1.0 / rest))

    @property
    def bound(self) -> float:
        """Sigmas that none exceeds but with probability ``CHANCE``, all together (Bonferroni)."""
        return float(stdtrit(max(self.degrees_of_freedom, 1.0), 1.0 - 0.5 * CHANCE / self.values.size))

    @property
    def odd(self) -> tuple[OddDocument, ...]:
        """Recordings that differ from the others beyond ``bound``, the worst first.

        Of each parameter the worst one: what it pulls along is not told.
        """
        apart = self.apart
        worst = np.argmax(np.abs(apart), axis=0)
        far = [
            OddDocument(self.recordings[k], self.parameters[c], float(apart[k, c]))
            for c, k in enumerate(worst)
            if abs(apart[k, c]) > self.bound
        ]
        return tuple(sorted(far, key=lambda odd: -abs(odd.sigmas)))


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
    first = estimates[0]
    if any(estimate.names != first.names for estimate in estimates):
        raise InputError("the recordings show different parameters: nothing can be compared")
    values = np.array([estimate.values for estimate in estimates])
    sigma = np.maximum(np.array([estimate.sigma for estimate in estimates]), TINY)
    degrees = min(estimate.degrees_of_freedom for estimate in estimates)
    return Compared(tuple(recordings), first.names, values, sigma, degrees)


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
