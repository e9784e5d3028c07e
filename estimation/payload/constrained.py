"""A method's payload as it should be used: one that can exist, with intervals that hold."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...common.arrays import Array
from ...model import InertialParameters
from ..fit.drive_gains import Gains
from ..fit.estimate import error_model
from ..possible.constraints import Constraint
from ..possible.intervals import NO_INTERVALS, Intervals, profile_intervals
from ..possible.payload import CONFLICT, POSSIBLE, Active, Possible, Weighing, solve_constrained, tested
from .result import PayloadEstimate


@dataclass(frozen=True)
class ConstrainedPayload:
    """The payload nearest to one method's estimate among those that hold the constraints.

    Attributes:
        free: the method's own estimate.
        result: the constrained one. Its ``free`` holds the same values with the covariance and the degrees of
            freedom by which distance, p-value and intervals go: those of ``error_model``.
        intervals: 95 %; nan where a constraint contradicts the data.
        gains: uncertainty of the drive gains that is part of the covariance; None where they are taken as exact.
        tested: active constraints with the probability of what each costs.
    """

    free: PayloadEstimate
    result: Possible
    intervals: Intervals
    gains: Gains | None
    tested: tuple[Active, ...]

    @property
    def method(self) -> int:
        """1 to 4."""
        return self.free.method

    @property
    def frame(self) -> str:
        """In which the ten are given, in words."""
        return self.free.frame

    @property
    def robust(self) -> bool:
        """Whether the intervals allow for errors that last."""
        return self.free.estimate.robust is not None

    @property
    def body(self) -> InertialParameters:
        """The payload as a body that can exist."""
        return self.result.body

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.body.mass

    @property
    def sigma(self) -> Array:
        """Standard deviations of the free ten behind the intervals, gains included, shape (10,)."""
        return self.result.free.sigma

    @cached_property
    def principal_moments(self) -> Array:
        """Principal moments of inertia at the centre of mass, rising [kg m^2], shape (3,)."""
        return np.asarray(np.linalg.eigvalsh(self.body.inertia_com))

    @property
    def p_value(self) -> float:
        """Probability of all constraints together; if small, they, or the model, contradict the data."""
        return self.result.p_value

    @property
    def weighings(self) -> tuple[Weighing, ...]:
        """Weighed masses beside the identified one."""
        return self.result.weighings

    @property
    def conflicts(self) -> tuple[Active, ...]:
        """Active constraints that contradict the data."""
        return tuple(constraint for constraint in self.tested if constraint.conflict)

    @property
    def conflict(self) -> bool:
        """Whether a constraint or a weighed mass, or all of them together, contradict the data."""
        apart = any(weighing.conflict for weighing in self.weighings)
        return apart or bool(self.conflicts) or self.p_value < CONFLICT


def constrain_payload(
    free: PayloadEstimate, constraints: Sequence[Constraint] = POSSIBLE, gains: Gains | None = None
) -> ConstrainedPayload:
    """The nearest payload that holds the constraints, with intervals.

    Args:
        free: a method's result, all ten determined.
        constraints: what is known beforehand; that the body can exist is always demanded.
        gains: uncertainty of the drive gains; taken as exact by default.

    Raises:
        InputError: if the covariance does not determine every parameter, or what the result owes to the drive gains
            is not known.
        SolverError: for anything but a clean solve, as when no body holds all constraints.
    """
    result = solve_constrained(error_model(free.estimate, gains), constraints)
    tests = tested(result)
    contradicted = result.p_value < CONFLICT or any(test.conflict for test in tests)
    intervals = NO_INTERVALS if contradicted else profile_intervals(result)
    return ConstrainedPayload(free, result, intervals, gains, tests)
