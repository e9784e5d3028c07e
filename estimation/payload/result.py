"""What every payload method returns."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...common.arrays import Array
from ...model import INERTIAL, InertialParameters
from ..fit.estimate import Estimate


@dataclass(frozen=True)
class PayloadEstimate:
    """A payload as one method sees it.

    Attributes:
        method: 1 to 4.
        estimate: the ten parameters ``PAYLOAD`` about the origin of ``frame``, with covariance.
        frame: the frame, in words.
        without_robust: why there are no robust standard deviations although they were asked for.
    """

    method: int
    estimate: Estimate
    frame: str
    without_robust: str = ""

    @cached_property
    def body(self) -> InertialParameters:
        """The payload as a body."""
        return InertialParameters(self.estimate.values)

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.body.mass

    @cached_property
    def sigma_com(self) -> Array:
        """Standard deviations of the centre of mass [m], shape (3,), by the full covariance."""
        return self._propagated(_com, self.estimate.covariance)

    @cached_property
    def sigma_inertia_com(self) -> Array:
        """Standard deviations of the inertia at the centre of mass [kg m^2], 3 x 3, by the full covariance."""
        return self._propagated(_inertia_com, self.estimate.covariance).reshape(3, 3)

    @cached_property
    def sigma_com_robust(self) -> Array | None:
        """The same that holds for autocorrelated noise [m], where it was asked for."""
        robust = self.estimate.robust
        return self._propagated(_com, robust.covariance) if robust else None

    @cached_property
    def sigma_inertia_com_robust(self) -> Array | None:
        """The same that holds for autocorrelated noise [kg m^2], 3 x 3, where it was asked for."""
        robust = self.estimate.robust
        return self._propagated(_inertia_com, robust.covariance).reshape(3, 3) if robust else None

    @cached_property
    def larger_sigma(self) -> Array:
        """The larger of the formula's and the robust standard deviation of each parameter, shape (10,)."""
        return self.estimate.larger_sigma

    @cached_property
    def larger_sigma_com(self) -> Array:
        """The same for the centre of mass [m], shape (3,)."""
        return _larger(self.sigma_com, self.sigma_com_robust)

    @cached_property
    def larger_sigma_inertia_com(self) -> Array:
        """The same for the inertia at the centre of mass [kg m^2], 3 x 3."""
        return _larger(self.sigma_inertia_com, self.sigma_inertia_com_robust)

    def named(self, values: Array) -> dict[str, float]:
        """Ten numbers by name, "XX" to "M"."""
        return {kind: float(value) for kind, value in zip(INERTIAL, values, strict=True)}

    def _propagated(self, function: Callable[[Array], Array], covariance: Array) -> Array:
        """Standard deviations of a function of the ten, to first order (derivative by complex step)."""
        step = 1e-30
        x = self.estimate.values.astype(complex)
        jacobian = np.array([np.imag(function(x + 1j * step * unit)).ravel() / step for unit in np.eye(10)])
        variances = np.einsum("ki,kl,li->i", jacobian, covariance, jacobian)
        return np.asarray(np.sqrt(variances))


def _com(x: Array) -> Array:
    return np.asarray(x[6:9] / x[9])


def _inertia_com(x: Array) -> Array:
    xx, xy, xz, yy, yz, zz, *h, m = x
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    a, b, c = h
    cross = np.array([[0 * a, -c, b], [c, 0 * a, -a], [-b, a, 0 * a]])
    return np.asarray(inertia + cross @ cross / m)


def _larger(formula: Array, robust: Array | None) -> Array:
    return formula if robust is None else np.maximum(formula, robust)
