"""What every payload method returns."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...common.arrays import Array
from ...model import INERTIAL, InertialParameters
from ...model.payload_spread import PayloadSpread, payload_spread
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
        return self._spread(self.estimate.covariance).com

    @cached_property
    def sigma_inertia_com(self) -> Array:
        """Standard deviations of the inertia at the centre of mass [kg m^2], 3 x 3, by the full covariance."""
        return self._spread(self.estimate.covariance).inertia_com

    @cached_property
    def sigma_com_robust(self) -> Array | None:
        """The same that holds for autocorrelated noise [m], where it was asked for."""
        robust = self.estimate.robust
        return self._spread(robust.covariance).com if robust else None

    @cached_property
    def sigma_inertia_com_robust(self) -> Array | None:
        """The same that holds for autocorrelated noise [kg m^2], 3 x 3, where it was asked for."""
        robust = self.estimate.robust
        return self._spread(robust.covariance).inertia_com if robust else None

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

    def _spread(self, covariance: Array) -> PayloadSpread:
        return payload_spread(self.estimate.values, covariance, range(len(INERTIAL)))


def _larger(formula: Array, robust: Array | None) -> Array:
    return formula if robust is None else np.maximum(formula, robust)
