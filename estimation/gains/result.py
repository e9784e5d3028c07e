"""Drive gains with their uncertainty."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ...common.arrays import Array, frozen_array
from ...model import InertialParameters, Robot, standard_columns, standard_regressor
from ...model.base import random_states
from ...model.kernel import Kernel
from ...model.names import parameter_kind
from ..fit.drive_gains import Fingerprints
from ..fit.estimate import Estimate, Fit
from ..fit.robust import RobustCovariance
from .known_load import KnownLoad

KNOWN_WELL = 0.05
"""Relative standard deviation up to which a gain counts as identified."""


@dataclass(frozen=True)
class DriveGains:
    """Torque per current of each motor, on the joint side.

    Attributes:
        robot: name of the robot.
        logarithms: ln K of gains [N·m/A or N/A] for bodies that can exist, its fit that of the currents [A]. Both
            covariances, by the formula and the robust one, hold the sigma of the mass.
        free_values: gains without constraints, shape (n,).
        gravity: per motor, whether gravity acts on it in some pose.
        rests_on: per motor, in words, which torques its gain rests on.
        load: the known payload.
        payload: the payload's ten as identified, known ones as given.
        without_robust: why there is no robust covariance.
        recordings: from which they were identified.
    """

    robot: str
    logarithms: Estimate
    free_values: Array
    gravity: tuple[bool, ...]
    rests_on: tuple[str, ...]
    load: KnownLoad
    payload: InertialParameters
    without_robust: str = ""
    recordings: Fingerprints = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Lock the array."""
        object.__setattr__(self, "free_values", frozen_array(self.free_values, (len(self.gravity),), "free gains"))

    @cached_property
    def values(self) -> Array:
        """Gains K [N·m/A or N/A], shape (n,)."""
        return np.exp(self.logarithms.values)

    @property
    def fit(self) -> Fit:
        """How well the currents [A] are explained."""
        return self.logarithms.fit

    @property
    def robust(self) -> RobustCovariance | None:
        """Covariance of ln K that holds for autocorrelated noise."""
        return self.logarithms.robust

    @property
    def relative_sigma(self) -> Array:
        """Relative standard deviations by the formula, shape (n,)."""
        return self.logarithms.sigma

    @property
    def relative_sigma_robust(self) -> Array | None:
        """Relative standard deviations that hold for autocorrelated noise, where there is enough data for them."""
        return self.logarithms.sigma_robust

    @property
    def larger_relative_sigma(self) -> Array:
        """The larger of both, shape (n,)."""
        return self.logarithms.larger_sigma

    @cached_property
    def larger_relative_covariance(self) -> Array:
        """Covariance of ln K with the larger standard deviations and their own correlations, n x n.

        The correlations are the robust ones where the robust deviations are the larger.
        """
        if self.robust is None:
            return self.logarithms.covariance
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


def gravity_acts(robot: Robot) -> tuple[bool, ...]:
    """Per motor, whether some mass of the robot or payload weighs on it in some pose."""
    q, qd, _ = random_states(robot, 20, seed=0)
    kernel = Kernel(standard_regressor(robot))
    entries = kernel(q, 0.0 * qd, 0.0 * qd)
    heavy = [parameter_kind(name) in ("MX", "MY", "MZ", "M") for name in standard_columns(robot)]
    weights = np.zeros((len(heavy), 20, robot.n))
    for row, column, values in zip(kernel.rows, kernel.columns, entries, strict=True):
        weights[column, :, row] = values
    flat = weights[heavy].reshape(-1, robot.n)
    motors = robot.coupling.motor_torques(flat) if robot.coupling else flat
    return tuple(bool(weight > 1e-9) for weight in np.abs(motors).max(axis=0))


def rests_on(robot: Robot) -> tuple[str, ...]:
    """Per motor, in words, which torques its gain rests on."""
    words = [
        "gravity and inertia" if gravity else "inertia only: no gravity acts on this joint"
        for gravity in gravity_acts(robot)
    ]
    if robot.spring is not None:
        words[robot.spring.joint - 1] += ", and the known spring"
    if robot.coupling is not None:
        j, k = robot.coupling.joints
        words[j - 1] += f" (the torque of joint {j} less that of joint {k})"
        words[k - 1] += f" (motor {k} turns with joints {j} and {k})"
    return tuple(words)
