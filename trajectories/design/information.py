"""Observation matrix on samples of a motion, its Gram matrix, and one adjoint for all gradients.

For criterion C with spectral gradient M = dC/dG and G = W' diag(w) W, dC/dW = 2 w W M. Torques are linear in W as
well, so that the slopes of torque limits join the same seed; reverse mode of the regressor then gives the slopes
in q, qd and qdd at about the cost of a few evaluations. W'W itself is never differentiated.
"""

import functools
from collections.abc import Callable, Sequence
from itertools import pairwise

import casadi as ca
import numpy as np

from ...common import Array
from ...model import Robot
from ...model.drives import SPRING, smooth_sign
from ...model.kernel.kernel import Kernel
from ...model.regressors import own_regressor
from ..motions.family import Samples


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

    def entries(self, samples: Samples, width: float) -> Array:
        """Evaluate the non-zero entries on N samples, (entries, N); ``width`` 0 for the exact sign."""
        states = (samples.q, samples.qd, samples.qdd)
        return self._smooth(*states, np.array([width])) if width > 0.0 else self._exact(*states)

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

    def state_slope(self, samples: Samples, width: float, seed: Array) -> tuple[Array, Array, Array]:
        """Slopes in q, qd, qdd, each (N, n), from slopes in the entries."""
        states = (samples.q, samples.qd, samples.qdd)
        q, qd, qdd = np.split(self._adjoint(*states, np.array([width]), seed.T).T, 3, axis=1)
        return q, qd, qdd

    def matrix(self, samples: Samples, width: float = 0.0) -> Array:
        """Matrix W, (n * N) x c, joint after joint."""
        return self.dense(self.entries(samples, width)).reshape(-1, len(self.columns))

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
