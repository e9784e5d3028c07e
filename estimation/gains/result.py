"""Drive gains with their uncertainty."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...common.arrays import Array, frozen_array
from ...model import InertialParameters
from ..fit.estimate import Fit
from ..fit.gain_recordings import GainRecordings
from ..fit.robust import RobustCovariance
from .known_load import KnownLoad

KNOWN_WELL = 0.05
"""Relative standard deviation up to which a gain counts as identified."""


@dataclass(frozen=True)
class DriveGains:
    """Torque per current of each motor, on the joint side.

    Attributes:
        robot: name of the robot.
        values: gains K [N·m/A or N/A], shape (n,), for bodies that can exist.
        free_values: the same without constraints.
        relative_covariance: of ln K by the formula for white noise, n x n, the mass's sigma included.
        robust: covariance of ln K that holds for autocorrelated noise, the mass's sigma included.
        gravity: per motor, whether gravity acts on it in some pose.
        rests_on: per motor, in words, which torques its gain rests on.
        load: the known payload.
        payload: the payload's ten as identified, known ones as given.
        fit: how well the currents [A] are explained.
        degrees_of_freedom: independent equations minus unknowns.
        without_robust: why there is no robust covariance.
        recordings: from which they were identified.
    """

    robot: str
    values: Array
    free_values: Array
    relative_covariance: Array
    robust: RobustCovariance | None
    gravity: tuple[bool, ...]
    rests_on: tuple[str, ...]
    load: KnownLoad
    payload: InertialParameters
    fit: Fit
    degrees_of_freedom: float
    without_robust: str = ""
    recordings: GainRecordings = GainRecordings()

    def __post_init__(self) -> None:
        """Lock the arrays and check their shapes."""
        n = len(self.gravity)
        for name in ("values", "free_values"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), (n,), name))
        object.__setattr__(
            self, "relative_covariance", frozen_array(self.relative_covariance, (n, n), "covariance")
        )

    @cached_property
    def relative_sigma(self) -> Array:
        """Relative standard deviations by the formula, shape (n,)."""
        return np.sqrt(np.diag(self.relative_covariance))

    @cached_property
    def relative_sigma_robust(self) -> Array | None:
        """The same that holds for autocorrelated noise, where there is enough data for it."""
        return self.robust.sigma if self.robust else None

    @cached_property
    def larger_relative_sigma(self) -> Array:
        """The larger of both, shape (n,)."""
        robust = self.relative_sigma_robust
        return self.relative_sigma if robust is None else np.maximum(self.relative_sigma, robust)

    @cached_property
    def larger_relative_covariance(self) -> Array:
        """Covariance of ln K with the larger standard deviations and their own correlations, n x n.

        The correlations are the robust ones where the robust deviations are the larger.
        """
        if self.robust is None:
            return self.relative_covariance
        own = self.robust.covariance
        stretch = self.larger_relative_sigma / self.robust.sigma
        return np.asarray(own * np.outer(stretch, stretch))

    @property
    def identified(self) -> tuple[bool, ...]:
        """Per joint, whether its gain is known to 5 % (1 sigma)."""
        return tuple(bool(sigma <= KNOWN_WELL) for sigma in self.larger_relative_sigma)

    @property
    def identifiability(self) -> tuple[str, ...]:
        """Per joint, in words, what its gain rests on and whether that is enough."""
        return tuple(
            words + ("" if good else f"; too little, known to {100 * sigma:.0f} % only: keep the maker's gain")
            for words, good, sigma in zip(self.rests_on, self.identified, self.larger_relative_sigma, strict=True)
        )
