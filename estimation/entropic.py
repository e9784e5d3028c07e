"""The bodies nearest to a prior in entropic distance within a bound of chi2, as a cone program solved by Clarabel.

Minimises sum D(P_j || P0_j) with ||F z - d|| <= rho and A z + b >= 0. D = -log det(P P0^-1) + tr(P0^-1 P) - 4 is
the log-det divergence of pseudo-inertias (Lee, Wensing and Park, 2020); it keeps every P_j positive definite and
does not change with frames or units. With P0 = C C' and Q = C^-1 P C^-T, D = tr Q - log det Q - 4, and log det Q is
the largest sum of t_i <= log Z_ii with Z lower triangular and [[Q, Z], [Z', diag Z]] positive semidefinite.
"""

from typing import Any, NamedTuple

import numpy as np

from ..model.arrays import Array
from .cone import ConeProgram, SolverError
from .constraints import PSEUDO_INERTIA

_TOLERANCE = 1e-9
"""Clarabel's, of gap and feasibility."""
_LARGEST = 1e3
"""F with larger entries, from data almost without noise, is scaled down to this."""
_LOWER = [(i, j) for i in range(4) for j in range(i + 1)]
"""Entries of Z, the first ten of a body's own variables; t are the last four."""
_OWN = len(_LOWER) + 4
_UPPER = [(i, j) for j in range(8) for i in range(j + 1)]
"""Clarabel's order of a triangle."""


class EntropicSolution(NamedTuple):
    """``z`` (n,); ``weight``: w for which z minimises chi2 + w D; ``multipliers`` (r,): fall of chi2 + w D."""

    z: Array
    weight: float
    multipliers: Array


def pseudo_inertias(program: ConeProgram, z: Array) -> Array:
    """P of each body of a program, p x 4 x 4."""
    return np.asarray(np.tensordot(program.bodies @ z, PSEUDO_INERTIA, 1))


def distances(program: ConeProgram, prior: Array, z: Array) -> Array:
    """D of each body, shape (p,); ``prior`` p x 4 x 4: pseudo-inertias P0."""
    ratio = np.linalg.solve(prior, pseudo_inertias(program, z))
    return np.asarray(np.trace(ratio, axis1=1, axis2=2) - np.linalg.slogdet(ratio)[1] - 4.0)


def nearest_within(program: ConeProgram, prior: Array, chi2: float) -> EntropicSolution:
    """Solve it.

    Args:
        program: F, d, rows and bodies in scaled units.
        prior: pseudo-inertias P0 in the same units, p x 4 x 4.
        chi2: bound of ||F z - d||^2, met to about 1e-6.

    Raises:
        SolverError: for anything but a clean solve.
    """
    import clarabel
    from scipy.sparse import csc_matrix

    (k, n), r, p = program.R.shape, len(program.A), len(program.bodies)
    Q = whitened_bodies(program, prior)
    size = n + _OWN * p
    scale = max(1.0, float(np.abs(program.R).max()) / _LARGEST)
    parts = [_padded(-program.A, size), _padded(np.vstack([np.zeros(n), -program.R / scale]), size)]
    right: list[Array] = [program.b, np.array([np.sqrt(chi2) / scale]), -program.d / scale]
    cones: list[Any] = [clarabel.NonnegativeConeT(r)] if r else []
    cones.append(clarabel.SecondOrderConeT(k + 1))
    for body in range(p):
        parts += [_triangle(Q[body], size, n + _OWN * body), _logarithms(size, n + _OWN * body)]
        right += [np.zeros(36), np.tile([0.0, 1.0, 0.0], 4)]
        cones += [clarabel.PSDTriangleConeT(8), *(clarabel.ExponentialConeT() for _ in range(4))]
    cost = np.zeros(size)
    cost[:n] = np.einsum("piin->n", Q)
    cost[n:].reshape(p, _OWN)[:, len(_LOWER) :] = -1.0
    matrix = csc_matrix(np.vstack(parts))
    solver = clarabel.DefaultSolver(
        csc_matrix((size, size)), cost, matrix, np.concatenate(right), cones, _settings()
    )
    solution = solver.solve()
    if str(solution.status) != "Solved":
        raise SolverError(str(solution.status), program)
    dual = np.asarray(solution.z)
    # d D / d rho is minus the cone's multiplier over scale; d chi2 = 2 rho d rho.
    weight = 2.0 * float(np.sqrt(chi2)) * scale / float(dual[r])
    return EntropicSolution(np.asarray(solution.x)[:n], weight, weight * dual[:r])


def whitened_bodies(program: ConeProgram, prior: Array) -> Array:
    """Q = C^-1 P C^-T with C C' = ``prior`` of each body, for each unit of z: p x 4 x 4 x n."""
    inverse = np.linalg.inv(np.linalg.cholesky(prior))
    units = np.einsum("pij,kjl,pml->pkim", inverse, PSEUDO_INERTIA, inverse, optimize=True)
    return np.asarray(np.einsum("pkim,pkn->pimn", units, program.bodies, optimize=True))


def _padded(rows: Array, size: int) -> Array:
    """Rows that touch z alone."""
    return np.hstack([rows, np.zeros((len(rows), size - rows.shape[1]))])


def _triangle(Q: Array, size: int, own: int) -> Array:
    """Minus the upper triangle of [[Q, Z], [Z', diag Z]], off-diagonals times sqrt 2: 36 x size."""
    rows = np.zeros((36, size))
    for row, (i, j) in enumerate(_UPPER):
        if j < 4:
            rows[row, : Q.shape[2]] = Q[i, j]
        elif (i, j - 4) in _LOWER:
            rows[row, own + _LOWER.index((i, j - 4))] = 1.0
        elif i == j:
            rows[row, own + _LOWER.index((i - 4, i - 4))] = 1.0
        if i != j:
            rows[row] *= np.sqrt(2.0)
    return -rows


def _logarithms(size: int, own: int) -> Array:
    """Minus (t_i, 0, Z_ii) of the four exponential cones t_i <= log Z_ii: 12 x size."""
    rows = np.zeros((12, size))
    for i in range(4):
        rows[3 * i, own + len(_LOWER) + i] = -1.0
        rows[3 * i + 2, own + _LOWER.index((i, i))] = -1.0
    return rows


def _settings() -> Any:
    import clarabel

    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = _TOLERANCE
    return settings
