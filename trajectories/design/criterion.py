"""Information that a motion gives: the observation matrix on its samples, its Gram matrix G, and criteria of that.

G is W' diag(w) W, c x c. Each criterion is a number to be made small, with the symmetric M = dC/dG. The condition
number is not smooth where eigenvalues meet; its surrogate of order p,

    log cond(W) <= (log tr G^p + log tr G^-p) / (2 p),

is, and tends to it as p grows (a Schatten norm). With M, dC/dW = 2 w W M. Torques are linear in W as well, so that
the slopes of torque limits join the same seed; reverse mode of the regressor then gives the slopes in q, qd and qdd
at about the cost of a few evaluations. W'W itself is never differentiated.
"""

import functools
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import casadi as ca
import numpy as np

from ...common import Array
from ...model import Robot
from ...model.drives import SPRING, smooth_sign
from ...model.kernel.kernel import Kernel
from ...model.regressors import own_regressor
from ..motions.family import Samples

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
    """-log det of the information about the parameters of interest, per one: twice the log of their mean sigma.

    The mean is the geometric one.
    """
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


class RegressorKernel:
    """Evaluates the regressor's non-zero entries, joint by joint, and their adjoint; ``SPRING`` may be a column."""

    def __init__(self, robot: Robot, columns: Sequence[str]) -> None:
        self._robot, self.columns = robot, tuple(columns)
        own = [name for name in columns if name != SPRING]
        width, spring = ca.SX.sym("width"), ca.SX(robot.n, 1)
        (q, qd, qdd, _), exact = own_regressor(robot, own)
        _, smooth = own_regressor(robot, own, smooth_sign(width))
        if robot.spring is not None:
            spring[robot.spring.joint - 1] = robot.spring.torque_symbol(q[robot.spring.joint - 1])
        order = [[*own, SPRING].index(name) for name in columns]
        smooth, exact = (ca.horzcat(phi, spring)[:, order].T for phi in (smooth, exact))
        seed, state = ca.SX.sym("seed", smooth.nnz()), ca.vertcat(q, qd, qdd)
        slope = ca.cse(ca.densify(ca.jtimes(smooth.nz[:], state, seed, True)))
        self._smooth = Kernel(ca.Function("smooth_entries", [q, qd, qdd, width], [ca.cse(smooth)]))
        self._exact = Kernel(ca.Function("exact_entries", [q, qd, qdd], [ca.cse(exact)]))
        self._adjoint = Kernel(ca.Function("adjoint", [q, qd, qdd, width, seed], [slope]))
        # The matrix is transposed: column-major order then holds joint after joint, its entries and their columns.
        ends = np.searchsorted(self._smooth.columns, np.arange(robot.n + 1))
        self.parts = tuple((slice(int(a), int(b)), self._smooth.rows[a:b]) for a, b in pairwise(ends))
        self._blocks = tuple(np.ix_(own, own) for _, own in self.parts)

    def __reduce__(self) -> tuple[Callable[..., "RegressorKernel"], tuple[Robot, tuple[str, ...]]]:
        """Pickle and copy by what it is made from: code is compiled, or kept already, where it is used."""
        return regressor_kernel, (self._robot, self.columns)

    def state(self, samples: Samples, width: float = 0.0) -> Samples:
        """Evaluate the non-zero entries on samples, their sign smoothed over ``width``, 0 for the exact one."""
        states = (*samples[1:4], np.array([width]))
        entries = self._smooth(*states) if width > 0.0 else self._exact(*states[:3])
        return samples._replace(entries=entries, width=states[3])

    def gram(self, entries: Array, weights: Array) -> Array:
        """Gram matrix W' diag(w) W, c x c, with ``weights`` (n, N)."""
        G = np.zeros((len(self.columns), len(self.columns)))
        for (part, _), block, w in zip(self.parts, self._blocks, weights, strict=True):
            W = entries[part]
            G[block] += (W * w) @ W.T
        return G

    def gram_slope(self, entries: Array, weights: Array, M: Array, seed: Array) -> Array:
        """Slopes of tr(M G), M symmetric and fixed, in the weights (n, N); those in the entries into ``seed``."""
        by_weight = np.empty_like(weights)
        for j, ((part, _), block) in enumerate(zip(self.parts, self._blocks, strict=True)):
            MW = M[block] @ entries[part]
            by_weight[j] = np.einsum("kn,kn->n", MW, entries[part])
            MW *= 2.0 * weights[j]
            seed[part] += MW
        return by_weight

    def torque(self, entries: Array, chi: Array) -> Array:
        """Torques W chi, shape (N, n)."""
        return np.stack([chi[own] @ entries[part] for part, own in self.parts], axis=1)

    def torque_slope(self, slope: Array, chi: Array, seed: Array) -> None:
        """Add to ``seed`` what a slope in the torques (N, n) means for the entries, of chi (c,), or (c, n, N)."""
        for j, (part, own) in enumerate(self.parts):
            seed[part] += (chi[own][:, None] if chi.ndim == 1 else chi[own, j]) * slope[:, j]

    def state_slope(self, state: Samples, seed: Array) -> list[Array]:
        """Slopes in q, qd, qdd, each (N, n), from slopes in the entries."""
        return np.split(self._adjoint(*state[1:4], state.width, seed.T).T, 3, axis=1)

    def matrix(self, samples: Samples) -> Array:
        """Matrix W, (n * N) x c, joint after joint."""
        return self.dense(self.state(samples).entries).reshape(-1, len(self.columns))

    def dense(self, entries: Array) -> Array:
        """Matrix W with its zeros, n x N x c."""
        W = np.zeros((len(self.parts), entries.shape[1], len(self.columns)))
        for rows, (part, columns) in zip(W, self.parts, strict=True):
            rows[:, columns] = entries[part].T
        return W


@functools.lru_cache(maxsize=16)
def regressor_kernel(robot: Robot, columns: tuple[str, ...]) -> RegressorKernel:
    """Make the kernel of a robot and its columns, once."""
    return RegressorKernel(robot, columns)
