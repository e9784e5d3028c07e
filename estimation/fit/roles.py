"""What is known of parameters beside the recordings: known from elsewhere, held near zero, or corrected."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

from ...common.arrays import Array


class Known(NamedTuple):
    """Parameters whose torque is taken off, and how sure they are.

    ``covariance``: part of the formula's, c x c; ``lasting``: what no block of time shows of it, zero where the
    blocks hold the recordings that the parameters come from; ``degrees_of_freedom``; ``gain_sensitivity``:
    gives derivatives by the relative error of each motor's torque, c x n, None where they are not known;
    ``left_out``: gives the values without each of the blocks that they come from, B x c, none by default.
    """

    names: tuple[str, ...]
    values: Array
    covariance: Array
    lasting: Array
    degrees_of_freedom: float = float("inf")
    gain_sensitivity: Callable[[], Array | None] = lambda: None
    left_out: Callable[[], Array | None] = lambda: None


class Held(NamedTuple):
    """How a parameter is held near zero.

    ``sigma``: its standard deviation; ``inflation``: by how much the memory of the errors raises the variance that
    white noise would give what the recordings say of it. One more equation counts for as much as that allows.
    """

    sigma: float
    inflation: float = 1.0

    @property
    def weight(self) -> float:
        """Weight of the equation, in units of weighted rows."""
        return float(np.sqrt(self.inflation)) / self.sigma


class Prior(NamedTuple):
    """Parameters known from elsewhere that the recordings correct, as far as their covariance leaves it to them.

    ``covariance``: c x c, of full rank; ``inflation`` as of ``Held``; the rest as of ``Known``.
    """

    names: tuple[str, ...]
    values: Array
    covariance: Array
    inflation: float = 1.0
    degrees_of_freedom: float = float("inf")
    gain_sensitivity: Callable[[], Array | None] = lambda: None

    @property
    def known(self) -> Known:
        """The parameters as they stand."""
        return Known(*self[:3], self.covariance, self.degrees_of_freedom, self.gain_sensitivity)

    @property
    def root(self) -> Array:
        """Rows of the equations, in units of weighted rows: root' root: the covariance's inverse, inflated."""
        scale = np.sqrt(np.diag(self.covariance))
        L = np.linalg.cholesky(self.covariance / np.outer(scale, scale))
        inverse = solve_triangular(L, np.eye(len(L)), lower=True)
        return np.asarray(np.sqrt(self.inflation) * inverse / scale)
