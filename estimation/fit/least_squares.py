"""Ordinary and weighted least squares on equations, (16)-(21)."""

from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

from ...common.arrays import Array
from ...common.errors import InputError
from ..equations.equations import Equations, check_rank, triangular
from .estimate import Estimate, fit

_NOISE_FLOOR = 1e-12  # of the torque: data without noise still need finite weights


class Solution(NamedTuple):
    """Least-squares solution of R x = d.

    ``values`` (c,), ``covariance`` c x c, ``degrees_of_freedom``.
    """

    values: Array
    covariance: Array
    degrees_of_freedom: float


def solve(factor: Array, columns: tuple[str, ...], rows: int, effective_rows: float) -> Solution:
    """Least squares with covariance.

    Decimated rows are not independent: the noise variance that the pass band holds is the residual's, (18),
    divided by the noise bandwidth, and c parameters take c of the *effective* rows.

    Args:
        factor: [W Y] or its triangular factor, k x (c + 1), already weighted.
        columns: names of the c parameters.
        rows: number of equations behind it.
        effective_rows: number of those with independent noise.

    Raises:
        InputError: if the data do not determine every parameter.
    """
    return solve_triangle(checked(factor, columns, rows, effective_rows), effective_rows)


def checked(factor: Array, columns: tuple[str, ...], rows: int, effective_rows: float) -> Array:
    """The triangular factor of equations that determine every parameter.

    Raises:
        InputError: if they do not.
    """
    c = len(columns)
    R = triangular(factor)
    check_rank(R[:, :c], columns, rows)
    if effective_rows <= c:
        raise InputError(
            f"{effective_rows:.0f} independent equations for {c} parameters: too few samples; record longer"
        )
    return R


def solve_triangle(R: Array, effective_rows: float) -> Solution:
    """Least squares from a triangular factor that is known to determine every parameter."""
    c = R.shape[1] - 1
    inverse = solve_triangular(R[:c, :c], np.eye(c))
    dof = effective_rows - c
    variance = float(np.sum(R[c:, c] ** 2)) / dof
    return Solution(inverse @ R[:c, c], variance * inverse @ inverse.T, dof)


def joint_weights(problem: Equations, values: Array) -> Array:
    """Weight of each joint's equations: one over the standard deviation of its error, shape (n,)."""
    rows = np.maximum(np.array(problem.rows, dtype=float), 1.0)
    share = max(1.0 - len(problem.columns) / max(sum(problem.effective_rows), 1.0), 1e-3)
    sigma = problem.error_norms(values) / np.sqrt(rows * share)
    floor = _NOISE_FLOOR * np.linalg.norm(problem.torque_norms) / np.sqrt(rows.sum())
    if floor == 0.0:
        return np.ones(len(rows))
    return np.asarray(1.0 / np.maximum(sigma, floor))


def ordinary(problem: Equations) -> Estimate:
    """Ordinary least squares (16)."""
    return _estimate(problem, np.ones(len(problem.rows)))


def weighted(problem: Equations, weights: Array | None = None) -> Estimate:
    """Weighted least squares.

    Args:
        problem: the equations.
        weights: per joint [1/(N·m) or 1/N], shape (n,); by default from its error in the ordinary solution.
    """
    return _estimate(problem, joint_weights(problem, ordinary(problem).values) if weights is None else weights)


def _estimate(problem: Equations, weights: Array) -> Estimate:
    factor = problem.stacked(weights)
    solution = solve(factor, problem.columns, problem.equations, sum(problem.effective_rows))
    return Estimate(
        names=problem.columns,
        values=solution.values,
        covariance=solution.covariance,
        degrees_of_freedom=solution.degrees_of_freedom,
        fit=fit(problem, solution.values),
        weights=weights,
    )
