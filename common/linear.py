"""Least squares, rank, range and null space that do not hang on the columns' units.

Columns of a regressor differ by powers of ten for no better reason than their units. Everything here scales them to
norm 1 first, nearly the best of all scalings (van der Sluis 1969), and calls a direction undetermined where its
singular value is below ``RANK_TOLERANCE`` of the largest: one convention for the whole house.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
from threadpoolctl import ThreadpoolController

from .arrays import Array

RANK_TOLERANCE = 1e-8
"""Columns, scaled to norm 1, are dependent if a singular value is below this fraction of the largest."""
_ROUNDING = 1e-12  # fraction of a column's norm in all rows, below which it is rounding in some of them


class Decomposition(NamedTuple):
    """Singular values of a matrix of rank r whose columns are scaled to norm 1, by ``decomposed``."""

    sizes: Array  # norms of A's columns, 1 for those that are zero, shape (c,)
    range: Array  # orthonormal basis of what the columns span, N x r
    singular: Array  # singular values of the scaled columns, largest first, shape (r,)
    # determined directions of the parameters over their singular values, c x r: root root' is the covariance of a
    # least-squares solution where the right side has errors of variance 1
    root: Array
    null: Array  # orthonormal basis of the undetermined ones, c x (c - r)

    @property
    def inverse(self) -> Array:
        """Pseudo-inverse, c x N: of all least-squares solutions the shortest in the scaled parameters."""
        return np.asarray(self.root @ self.range.T)

    def solution(self, B: Array) -> Array:
        """Least-squares solution of A x = B, of several the shortest; shape (c,), or c x m for N x m."""
        return np.asarray(self.root @ (self.range.T @ B))

    @property
    def hidden(self) -> Array:
        """Fraction of each parameter that lies in undetermined directions, 0 to 1, shape (c,)."""
        return np.asarray(np.sum(self.null**2, axis=1))


def decomposed(A: Array, whole: Array | None = None, tolerance: float = RANK_TOLERANCE) -> Decomposition:
    """Singular value decomposition of a matrix with its columns scaled to norm 1.

    ``A``: N x c; no rows and no columns are allowed; ``whole``: norms of the columns of a larger matrix, of which A
    is some rows. A column that is next to nothing beside them is rounding, and counts as zero. ``tolerance``:
    largest ratio of a singular value to the largest one that calls a direction undetermined.
    """
    sizes = np.linalg.norm(A, axis=0)
    if whole is not None:
        rounding = sizes <= _ROUNDING * whole
        A, sizes = np.where(rounding, 0.0, A), np.where(rounding, 0.0, sizes)
    sizes[sizes == 0.0] = 1.0
    rows, columns = A.shape
    U, singular, Vt = np.linalg.svd(A / sizes, full_matrices=rows < columns)
    r = int(np.sum(singular > tolerance * singular.max(initial=0.0)))
    root = Vt[:r].T / singular[:r] / sizes[:, None]
    return Decomposition(sizes, U[:, :r], singular[:r], root, Vt[r:].T)


def condition_numbers(W: Array) -> tuple[float, float]:
    """Condition numbers of W: as it is, and with its columns scaled to norm 1; inf where W has not full rank.

    By singular values of W itself: those of W'W lose half of the digits.
    """
    R = np.asarray(np.linalg.qr(W, mode="r"))
    parts, plain = decomposed(R), np.linalg.svd(R, compute_uv=False)
    if parts.null.size:
        return np.inf, np.inf
    return float(plain[0] / plain[-1]), float(parts.singular[0] / parts.singular[-1])


def is_covariance(C: Array) -> bool:
    """True if a matrix is square, symmetric and without negative eigenvalues, but for rounding."""
    square = C.ndim == 2 and C.shape[0] == C.shape[1] and np.isfinite(C).all() and np.allclose(C, C.T, atol=1e-12)
    return bool(square and (np.linalg.eigvalsh(C) >= -1e-9 * max(float(np.trace(C)), 1e-300)).all())


def without(W: Array, columns: Array) -> Array:
    """Take off W, N x c, all that some columns, N x k, can explain of it."""
    U = decomposed(columns).range
    rest = W - U @ (U.T @ W)
    # Orthogonalised twice: what is nearly explained would otherwise be rounding.
    return np.asarray(rest - U @ (U.T @ rest))


_LOCK = Lock()
_LIMITS: list[Any] = []  # of the calls that compute now, the first one's first
_libraries = cache(ThreadpoolController)  # to look for them takes longer than a small problem


@contextmanager
def one_thread() -> Iterator[None]:
    """Compute with one thread of BLAS: small matrices wait for more, and sums round by their number."""
    for package in ("numpy.linalg", "scipy.linalg"):  # whose libraries it finds
        import_module(package)
    with _LOCK:
        _LIMITS.append(_libraries().limit(limits=1, user_api="blas"))
    try:
        yield
    finally:
        with _LOCK:  # where calls overlap, the last to end gives back what the first one found
            limit = _LIMITS.pop()
            if not _LIMITS:
                limit.restore_original_limits()
