"""Weighted least squares on equations, (16)-(21), and how well they excite each parameter."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from ...common import Array, freeze_fields
from ..equations.equations import Equations
from .estimate import Estimate
from .linear_problem import LinearProblem


@dataclass(frozen=True)
class Excitation:
    """Signal of each parameter in weighted equations, in units of the noise.

    The relative standard deviation of a parameter is 1 / ``independent``: with all others known it would be
    1 / ``signal``.
    """

    names: tuple[str, ...]  # of the parameters, c
    signal: Array  # norm of the parameter's torque, |chi_k| ||W_k|| over the noise, shape (c,)
    independent: Array  # the same of its part that no combination of the others can imitate, |chi_k| / sigma_k

    def __post_init__(self) -> None:
        """Lock the arrays."""
        freeze_fields(self, signal=(len(self.names),), independent=(len(self.names),))

    @property
    def share(self) -> Array:
        """Part of each parameter's torque that is its own, 0 to 1, shape (c,): 1 over the square root of the
        variance inflation factor; nan for a value of exactly zero.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.independent / self.signal)


def excitation(problem: Equations, estimate: Estimate) -> Excitation:
    """Measure the excitation of an estimate's parameters by the equations it comes from.

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


def weighted(problem: Equations, weights: Array | None = None) -> Estimate:
    """Estimate all columns by weighted least squares.

    Args:
        weights: per joint [1/(N·m) or 1/N], shape (n,); by default from its error in the ordinary solution (16).
    """
    return LinearProblem(problem, problem.columns).estimate(weights)
