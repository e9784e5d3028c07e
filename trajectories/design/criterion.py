"""Criteria of the information that a motion gives, on its information matrix, with their spectral gradients.

G is W' diag(w) W, c x c. Each criterion is a number to be made small, with the symmetric M = dC/dG. The condition
number is not smooth where eigenvalues meet; its surrogate of order p,

    log cond(W) <= (log tr G^p + log tr G^-p) / (2 p),

is, and tends to it as p grows (a Schatten norm).
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ...common import Array

Kind = str  # name of a criterion: a key of ``CRITERIA``
_SINGULAR = 1e-15  # of the largest eigenvalue: smaller ones are rounding
ValueSlope = tuple[float, Array]  # value of a criterion, and M = dC/dG, c x c


class Criterion(NamedTuple):
    """Criterion that is to be made small, and rules by which it is searched for."""

    kind: Kind
    # value and slope by the criterion, G and the order p
    measure: Callable[["Criterion", Array, float], ValueSlope]
    weighted: bool  # whether the joints' torque noise weights the rows of W
    orders: tuple[float, ...]  # p of the surrogate, one after the other; 1 where there is none
    usual_starts: int  # random starts of a search, which ends at one of many local optima
    reference: Array | None = None  # values that standard deviations are relative to, shape (c,); for "a"
    # indices of the parameters that count for "d" and "a", the others being estimated besides them; None for all
    interest: Sequence[int] | None = None

    def __call__(self, G: Array, order: float = 1.0) -> ValueSlope:
        """Evaluate value and slope; ``order`` p of the surrogate. Value inf if G is not positive definite."""
        try:
            return self.measure(self, G, order)
        except np.linalg.LinAlgError:
            return np.inf, np.zeros_like(G)


def determinant(criterion: Criterion, G: Array, _: float) -> ValueSlope:
    """-log det of the information about those of interest, per parameter: twice the log of the mean sigma."""
    inverse, log_det = _inverted(G)
    if criterion.interest is None:
        return -log_det / len(G), inverse / -len(G)
    # The others estimated as well, the covariance of interest is its block of the inverse: value log det of it, and
    # by d(G^-1) = -G^-1 dG G^-1 the slope.
    own = list(criterion.interest)
    part = inverse[np.ix_(own, own)]
    scale = np.sqrt(np.diag(part))
    value = np.linalg.slogdet(part / np.outer(scale, scale))[1] + 2.0 * np.log(scale).sum()
    M = -inverse[:, own] @ np.linalg.solve(part, inverse[own]) / len(own)
    return float(value) / len(own), 0.5 * (M + M.T)


def relative_sigma(criterion: Criterion, G: Array, _: float) -> ValueSlope:
    """Log of the root mean square of sigma_k / reference_k."""
    inverse, _ = _inverted(G)
    own = list(range(len(G)) if criterion.interest is None else criterion.interest)
    reference = np.ones(len(G)) if criterion.reference is None else criterion.reference
    weight = np.zeros(len(G))
    weight[own] = 1.0 / (len(own) * reference[own] ** 2)
    total = float(weight @ np.diag(inverse))
    return 0.5 * float(np.log(total)), -(inverse * weight) @ inverse / (2.0 * total)


def _inverted(G: Array) -> tuple[Array, float]:
    scale = _sizes(G)
    factor = np.linalg.cholesky(G / np.outer(scale, scale))
    half = np.linalg.inv(factor) / scale
    return half.T @ half, 2.0 * float(np.log(np.diag(factor) * scale).sum())


def _sizes(G: Array) -> Array:
    scale = np.sqrt(np.diag(G))
    if not ((scale > 0.0) & (scale < np.inf)).all():
        raise np.linalg.LinAlgError("not positive definite")
    return scale


def condition(_: Criterion, G: Array, order: float) -> ValueSlope:
    """Surrogate of log cond(W) of order p, and its slope in G = W'W."""
    value, V = np.linalg.eigh(G)
    log = np.log(np.maximum(value, _SINGULAR * value[-1]))
    up, down = np.exp(order * (log - log[-1])), np.exp(order * (log[0] - log))
    level = (np.log(up.sum()) + np.log(down.sum())) / (2.0 * order) + 0.5 * (log[-1] - log[0])
    slope = 0.5 * (up / up.sum() - down / down.sum()) * np.exp(-log)
    return float(level), (V * slope) @ V.T


def scaled_condition(criterion: Criterion, G: Array, order: float) -> ValueSlope:
    """Surrogate of W with its columns scaled to norm 1."""
    scale = _sizes(G)
    D = np.outer(scale, scale)
    value, M = condition(criterion, G / D, order)
    # The chain rule through D, whose entries are those of G's diagonal.
    slope = M / D
    slope[np.diag_indices_from(slope)] -= np.einsum("ij,ij->i", M, G / D) / np.diag(G)
    return value, slope


SURROGATE = (1.0, 8.0, 24.0)
"""Orders p of the surrogate, one after the other: the last is near the condition number itself."""
CRITERIA = {
    "d": Criterion("d", determinant, weighted=True, orders=(1.0,), usual_starts=6),
    "a": Criterion("a", relative_sigma, weighted=True, orders=(1.0,), usual_starts=6),
    "cond": Criterion("cond", condition, weighted=False, orders=SURROGATE, usual_starts=3),
    "cond-scaled": Criterion("cond-scaled", scaled_condition, weighted=False, orders=SURROGATE, usual_starts=3),
}
"""Criteria by name: d: log det; a: relative standard deviations; cond: condition number of W in SI
units; cond-scaled: of W with its columns scaled to norm 1. To add one, add a row."""
