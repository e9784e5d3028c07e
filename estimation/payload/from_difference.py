"""Method 3: torque difference on the same trajectory, (29)."""

from ...common.errors import InputError
from ..fit.estimate import Estimate
from ..fit.least_squares import weighted
from .problem import FixedWeights, PayloadProblem


def from_difference(problem: PayloadProblem, weights: FixedWeights | None = None) -> Estimate:
    """Payload from Y_T - Y_wL, the torques with and without it on one trajectory."""
    if problem.difference is None:
        raise InputError(f"method 3 cannot be used: {problem.without_difference}")
    return weighted(problem.difference, weights.own if weights else None)
