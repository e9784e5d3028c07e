"""What makes a motion informative: criteria on the information matrix, with their spectral gradients.

G is W' diag(w) W, c x c. Each criterion is a number to be made small, with the symmetric M = dC/dG. The condition
number is not smooth where eigenvalues meet; its surrogate of order p,

    log cond(W) <= (log tr G^p + log tr G^-p) / (2 p),

is, and tends to it as p grows (a Schatten norm).
"""

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.linear import RANK_TOLERANCE

Kind = Literal["d", "a", "cond", "cond-scaled"]
"""d: log det; a: relative standard deviations; cond: condition number of W in SI units; cond-scaled: of W with its
columns scaled to norm 1."""

ORDERS: dict[str, tuple[float, ...]] = {"d": (1.0,), "a": (1.0,), "cond": (1.0, 8.0, 24.0)}
ORDERS["cond-scaled"] = ORDERS["cond"]
"""Orders p of the surrogate, one after the other."""
STARTS: dict[str, int] = {"d": 6, "a": 6, "cond": 3, "cond-scaled": 3}
"""Random starts of a search, which ends at one of many local optima."""

_SINGULAR = 1e-15  # of the largest eigenvalue: smaller ones are rounding


ValueSlope = tuple[float, Array]
"""A criterion's value and M = dC/dG, c x c."""


class Criterion(NamedTuple):
    """What is to be made small.

    Attributes:
        reference: values that standard deviations are relative to, shape (c,); for "a".
        interest: positions of the parameters that count for "d" and "a", the others being estimated beside
            them; None for all.
    """

    kind: Kind = "d"
    reference: Array | None = None
    interest: Sequence[int] | None = None

    @property
    def weighted(self) -> bool:
        """Whether the joints' torque noise weights the rows of W."""
        return self.kind in ("d", "a")

    def __call__(self, G: Array, order: float = 1.0) -> ValueSlope:
        """Value and slope; ``order`` p of the surrogate for condition numbers.

        d: -log det of the information about the parameters of interest, per parameter, so that exp(value / 2)
        is the geometric mean of their uncertainty; a: log of the root mean square of sigma_k / reference_k;
        cond: log of the surrogate. A matrix that is not positive definite has the value inf.
        """
        if self.kind == "cond":
            return schatten_condition(G, order)
        scale = np.sqrt(np.diag(G))
        if not ((scale > 0.0) & (scale < np.inf)).all():
            return np.inf, np.zeros_like(G)
        if self.kind == "cond-scaled":
            D = np.outer(scale, scale)
            value, M = schatten_condition(G / D, order)
            slope = M / D
            slope[np.diag_indices_from(slope)] -= np.einsum("ij,ij->i", M, G / D) / np.diag(G)
            return value, slope
        try:
            factor = np.linalg.cholesky(G / np.outer(scale, scale))
        except np.linalg.LinAlgError:
            return np.inf, np.zeros_like(G)
        half = np.linalg.inv(factor) / scale
        inverse = half.T @ half
        own = list(range(len(G)) if self.interest is None else self.interest)
        if self.kind == "a":
            reference, weight = np.ones(len(G)) if self.reference is None else self.reference, np.zeros(len(G))
            weight[own] = 1.0 / (len(own) * reference[own] ** 2)
            total = float(weight @ np.diag(inverse))
            return 0.5 * float(np.log(total)), -(inverse * weight) @ inverse / (2.0 * total)
        if self.interest is None:
            log_det = 2.0 * float(np.log(np.diag(factor) * scale).sum())
            return -log_det / len(G), inverse / -len(G)
        part = inverse[np.ix_(own, own)]
        scale = np.sqrt(np.diag(part))
        value = np.linalg.slogdet(part / np.outer(scale, scale))[1] + 2.0 * np.log(scale).sum()
        M = -inverse[:, own] @ np.linalg.solve(part, inverse[own]) / len(own)
        return float(value) / len(own), 0.5 * (M + M.T)


def schatten_condition(G: Array, order: float) -> ValueSlope:
    """Surrogate of log cond(W) of order p, and its slope in G = W'W."""
    value, V = np.linalg.eigh(G)
    log = np.log(np.maximum(value, _SINGULAR * value[-1]))
    up, down = np.exp(order * (log - log[-1])), np.exp(order * (log[0] - log))
    level = (np.log(up.sum()) + np.log(down.sum())) / (2.0 * order) + 0.5 * (log[-1] - log[0])
    slope = 0.5 * (up / up.sum() - down / down.sum()) * np.exp(-log)
    return float(level), (V * slope) @ V.T


def condition_numbers(W: Array) -> tuple[float, float]:
    """Condition number of W as it is, and with its columns scaled to norm 1; inf where W has not full rank.

    By singular values of W itself: those of W'W lose half of the digits.
    """
    R = np.asarray(np.linalg.qr(W, mode="r"))
    size = np.linalg.norm(R, axis=0)
    if R.shape[0] < R.shape[1] or not (size > 0.0).all():
        return np.inf, np.inf
    scaled = np.linalg.svd(R / size, compute_uv=False)
    if scaled[-1] < RANK_TOLERANCE * scaled[0]:
        return np.inf, np.inf
    plain = np.linalg.svd(R, compute_uv=False)
    return float(plain[0] / plain[-1]), float(scaled[0] / scaled[-1])
