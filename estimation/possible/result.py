"""The nearest to a free estimate among all that can exist, and what that cost."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.special import chdtrc, fdtrc

from ...common.arrays import Array, frozen_array
from ...model import InertialParameters
from ..fit.estimate import Estimate
from .constraints import Constraint, KnownMass

CONFLICT = 0.01
"""Probability below which a constraint and the data contradict each other."""


class Active(NamedTuple):
    """A demand that holds the estimate back.

    ``description``: what is demanded; ``multiplier``: how fast chi2 falls as that is relaxed, per scaled unit
    (M l^2, M l, M of the body): a slope, so that of several the one to blame is found by leaving each out in turn;
    ``constraint``: of a payload, what ``description`` describes. Once ``tested``, ``rise`` is what it adds to chi2,
    and ``p_value`` the probability of as much if it is true, at most: by chi-squared (or Fisher's F) of as many
    degrees as the constraint restricts directions; nan before.
    """

    description: str
    multiplier: float
    constraint: Constraint | None = None
    rise: float = np.nan
    p_value: float = np.nan

    @property
    def conflict(self) -> bool:
        """Whether it contradicts the data."""
        return self.p_value < CONFLICT


class Weighing(NamedTuple):
    """A weighed mass beside the identified one [kg], each with its standard deviation."""

    mass: float
    sigma: float
    identified: float
    identified_sigma: float
    degrees_of_freedom: float

    @property
    def z(self) -> float:
        """By how many standard deviations of their difference the identified mass is larger."""
        return (self.identified - self.mass) / float(np.hypot(self.sigma, self.identified_sigma))

    @property
    def p_value(self) -> float:
        """Probability of as large a difference of either sign."""
        return rise_p_value(self.z**2, 1, self.degrees_of_freedom)

    @property
    def conflict(self) -> bool:
        """Whether scale and identification contradict each other."""
        return self.p_value < CONFLICT


@dataclass(frozen=True)
class Possible:
    """A payload, or the links of a robot, that can exist.

    Attributes:
        free: the unconstrained estimate with the covariance by which distance and p-value go.
        values: the constrained parameters: of a payload all ten in the order of ``PAYLOAD``, eliminated ones zero;
            of a robot its base parameters in the order of ``free.names``.
        chi2_rise: of these values, squared distance from the free ones by their covariance, plus soft terms.
        active: what holds the estimate back, largest multiplier first.
        bodies: the payload alone, or one robot's links; each can exist.
        status: of the solver; without a solve "free" if the free estimate holds every constraint, "repaired" if
            it does but for an eigenvalue of rounding size (exact data), "prior" if a prior itself will do.
        constraints: of a payload.
    """

    free: Estimate
    values: Array
    chi2_rise: float
    active: tuple[Active, ...]
    bodies: tuple[InertialParameters, ...]
    status: str
    constraints: tuple[Constraint, ...] = ()

    def __post_init__(self) -> None:
        """Lock the values."""
        object.__setattr__(self, "values", frozen_array(self.values, (None,), "constrained values"))

    @property
    def body(self) -> InertialParameters:
        """The payload as a body."""
        (body,) = self.bodies
        return body

    @cached_property
    def min_eigenvalues(self) -> tuple[float, ...]:
        """Smallest eigenvalue of each body's pseudo-inertia; none is negative."""
        return tuple(body.min_pseudo_inertia_eigenvalue for body in self.bodies)

    @property
    def min_pseudo_inertia_eigenvalue(self) -> float:
        """Smallest among the bodies; not negative."""
        return min(self.min_eigenvalues)

    @cached_property
    def p_value(self) -> float:
        """Probability of a rise this large if what is true holds the constraints.

        The nearest admissible point is no farther than the truth, whose squared distance is chi-squared with as
        many degrees of freedom k as there are parameters and soft terms (k times Fisher's F, as the covariance
        holds an estimated variance). At the boundary of a cone the rise itself follows a mixture of chi-squared
        laws of 0 to k degrees of freedom, for which the law of k is an upper bound: this p-value is too large,
        never too small; a small one says that a constraint or the model is wrong.
        """
        k = len(self.free.names) + sum(isinstance(constraint, KnownMass) for constraint in self.constraints)
        return rise_p_value(self.chi2_rise, k, self.free.degrees_of_freedom)

    @property
    def weighings(self) -> tuple[Weighing, ...]:
        """Each weighed mass against the free estimate."""
        values, sigma = (dict(zip(self.free.names, x, strict=True)) for x in (self.free.values, self.free.sigma))
        return tuple(
            Weighing(
                scale.mass, scale.sigma, float(values["M_L"]), float(sigma["M_L"]), self.free.degrees_of_freedom
            )
            for scale in self.constraints
            if isinstance(scale, KnownMass)
        )


def rise_p_value(chi2: float, k: int, degrees_of_freedom: float) -> float:
    """Probability that chi-squared of k degrees, or k times F(k, degrees_of_freedom), exceeds ``chi2``."""
    if np.isinf(degrees_of_freedom):
        return float(chdtrc(k, chi2))
    return float(fdtrc(k, max(degrees_of_freedom, 1.0), chi2 / k))
