"""Ordinary and weighted least squares on equations, (16)-(21), and how well they excite each parameter."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack, solve_triangular

from ...common.arrays import Array, frozen_array
from ...common.errors import InputError
from ...common.linear import RANK_TOLERANCE, decomposed
from ..equations.equations import Equations, scaled, triangular
from .covariance import formula
from .estimate import Estimate, fit


@dataclass(frozen=True)
class Excitation:
    """Signal of each parameter in weighted equations, in units of the noise.

    The relative standard deviation of a parameter is 1 / ``independent``: with all others known it would be
    1 / ``signal``.

    Attributes:
        names: of the parameters, c.
        signal: norm of the parameter's torque, |chi_k| ||W_k|| over the noise, shape (c,).
        independent: the same of its part that no combination of the others can imitate, |chi_k| / sigma_k.
    """

    names: tuple[str, ...]
    signal: Array
    independent: Array

    def __post_init__(self) -> None:
        """Lock the arrays."""
        for name in ("signal", "independent"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), (len(self.names),), name))

    @property
    def share(self) -> Array:
        """Part of each parameter's torque that is its own, 0 to 1, shape (c,): 1 over the square root of the
        variance inflation factor; nan for a value of exactly zero.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.independent / self.signal)


def excitation(problem: Equations, estimate: Estimate) -> Excitation:
    """Excitation of an estimate's parameters by the equations it comes from.

    Args:
        estimate: weighted, of the same columns.
    """
    c = len(problem.columns)
    R = problem.stacked(estimate.weights)
    T = solve_triangular(R[:c, :c], np.eye(c))
    spare = max(sum(problem.effective_rows) - c, 1.0)
    error = R @ np.append(-estimate.values, 1.0)
    # Equations filtered and decimated count for fewer: sigma goes by the effective ones.
    noise = float(np.linalg.norm(error)) / np.sqrt(spare)
    size = np.abs(estimate.values) / max(noise, np.finfo(float).tiny)
    return Excitation(problem.columns, size * np.linalg.norm(R[:, :c], axis=0), size / np.linalg.norm(T, axis=1))


_NOISE_FLOOR = 1e-12  # of the torque: data without noise still need finite weights


class Solution(NamedTuple):
    """Least-squares solution of R x = d.

    ``values`` (c,), ``covariance`` c x c, ``degrees_of_freedom``.
    """

    values: Array
    covariance: Array
    degrees_of_freedom: float


def solve(factor: Array, columns: tuple[str, ...], rows: int, effective_rows: float) -> Solution:
    """Least squares with covariance; arguments as of ``checked``.

    Decimated rows are not independent: the noise variance that the pass band holds is the residual's, (18),
    divided by the noise bandwidth, and c parameters take c of the *effective* rows.
    """
    R, c = checked(factor, columns, rows, effective_rows), len(columns)
    root, dof = solve_triangular(R[:c, :c], np.eye(c)), effective_rows - c
    return Solution(root @ R[:c, c], formula(root, float(np.sum(R[c:, c] ** 2)), dof), dof)


def checked(factor: Array, columns: tuple[str, ...], rows: int, effective_rows: float) -> Array:
    """The triangular factor of equations that determine every parameter.

    Args:
        factor: [W Y] or its triangular factor, k x (c + 1) or more, already weighted.
        columns: names of the c parameters.
        rows: number of equations behind it.
        effective_rows: number of those with independent noise.

    Raises:
        InputError: if they leave a direction of the parameters undetermined.
    """
    c = len(columns)
    if rows < c:
        raise InputError(
            f"{rows} equations for {c} parameters: fewer samples than parameters; record longer or decimate less"
        )
    R = triangular(factor)
    undetermined = np.zeros((c, 0)) if _clearly_determined(scaled(R[:, :c])) else decomposed(R[:, :c]).null
    if undetermined.size:
        weight = np.abs(undetermined).max(axis=1)
        named = [name for name, w in zip(columns, weight, strict=True) if w > 0.05]
        raise InputError(
            f"the recorded motion leaves {undetermined.shape[1]} of {c} directions undetermined, in "
            f"{', '.join(named)}: move more joints, faster and over a wider range"
        )
    if effective_rows <= c:
        raise InputError(
            f"{effective_rows:.0f} independent equations for {c} parameters: too few samples; record longer"
        )
    return R


def _clearly_determined(W: Array) -> bool:
    """By LAPACK's condition estimate of a triangle, which costs nothing beside singular values; False if in doubt.

    The estimate is rarely off by more than 3, and the 1-norm's condition within c of the 2-norm's.
    """
    c = W.shape[1]
    if len(W) < c or np.any(np.tril(W, -1)):
        return False
    reciprocal, failed = lapack.dtrcon(W[:c])
    return not failed and bool(reciprocal > 10.0 * c * RANK_TOLERANCE)


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
    return weighted(problem, np.ones(len(problem.rows)))


def weighted(problem: Equations, weights: Array | None = None) -> Estimate:
    """Weighted least squares.

    Args:
        weights: per joint [1/(N·m) or 1/N], shape (n,); by default from its error in the ordinary solution.
    """
    weights = joint_weights(problem, ordinary(problem).values) if weights is None else weights
    effective_rows = sum(problem.effective_rows)
    solution = solve(problem.stacked(weights), problem.columns, problem.equations, effective_rows)
    return Estimate(problem.columns, *solution, fit(problem, solution.values), weights)
