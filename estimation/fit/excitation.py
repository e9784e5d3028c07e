"""How well a motion excites each parameter: its torque against the noise, and what others can imitate of it."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from ...common.arrays import Array, frozen_array
from ..equations.equations import Equations
from .estimate import Estimate


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
        problem: the equations.
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
