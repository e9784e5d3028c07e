"""Whether what is known beforehand and what the data say go together."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...common.linear import rank
from .constrained import ConstrainedEstimate, solve_constrained
from .constraints import Constraint, KnownMass, PossibleBody
from .scaling import rise_p_value

CONFLICT = 0.01
"""Probability below which a constraint and the data contradict each other."""


class Tested(NamedTuple):
    """A constraint that holds the estimate back, and how unlikely that is if it is true.

    ``rise``: what it adds to chi2. ``p_value``: probability of as much, at most: by chi-squared (or Fisher's F) of
    as many degrees as the constraint restricts directions.
    """

    constraint: Constraint
    rise: float
    p_value: float

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


def tested(result: ConstrainedEstimate) -> tuple[Tested, ...]:
    """Each active constraint by itself: the rise with all constraints less that without it.

    That a body must exist is not left out; its rise is that which it causes alone.
    """
    found = []
    for active in result.active:
        constraint, others = active.constraint, [c for c in result.constraints if c is not active.constraint]
        if isinstance(constraint, PossibleBody):
            rise, k = solve_constrained(result.free, [constraint]).chi2_rise, len(result.free.names)
        else:
            rise = result.chi2_rise - solve_constrained(result.free, others).chi2_rise
            k = rank(constraint.rows.A)
        p = rise_p_value(max(rise, 0.0), k, result.free.degrees_of_freedom)
        found.append(Tested(constraint, rise, p))
    return tuple(found)


def weighings(result: ConstrainedEstimate) -> tuple[Weighing, ...]:
    """Each weighed mass against the free estimate."""
    free = result.free
    k = free.names.index("M_L")
    scales: Sequence[KnownMass] = [c for c in result.constraints if isinstance(c, KnownMass)]
    return tuple(
        Weighing(c.mass, c.sigma, float(free.values[k]), float(free.sigma[k]), free.degrees_of_freedom)
        for c in scales
    )
