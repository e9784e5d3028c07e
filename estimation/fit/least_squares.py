"""Ordinary and weighted least squares on equations, (16)-(21), and how well they excite each parameter."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

from ...common.arrays import Array, frozen_array
from ...common.errors import InputError
from ..equations.conditioning import check_rank
from ..equations.equations import Equations, triangular
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
        c = len(self.names)
        object.__setattr__(self, "signal", frozen_array(self.signal, (c,), "signal"))
        object.__setattr__(self, "independent", frozen_array(self.independent, (c,), "independent"))

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
    root, dof = solve_triangular(R[:c, :c], np.eye(c)), effective_rows - c
    return Solution(root @ R[:c, c], formula(root, float(np.sum(R[c:, c] ** 2)), dof), dof)


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
