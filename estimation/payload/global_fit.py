"""Method 4: robot and payload together, (30)."""

from dataclasses import replace

from ...model import InputError
from ..estimate import Estimate, fit
from ..least_squares import weighted
from ..names import PAYLOAD
from ..problem import merged
from .problem import FixedWeights, PayloadProblem


def global_fit(problem: PayloadProblem, weights: FixedWeights | None = None) -> Estimate:
    """Payload from all recordings at once; the robot's parameters are common to both."""
    joint = combined(problem, weights)
    values, covariance = joint.select(PAYLOAD)
    return replace(
        joint, names=PAYLOAD, values=values, covariance=covariance, fit=fit(problem.loaded, joint.values)
    )


def combined(problem: PayloadProblem, weights: FixedWeights | None = None) -> Estimate:
    """Robot and payload parameters of (30), columns base, then ``PAYLOAD``."""
    if problem.unloaded is None:
        raise InputError("method 4 needs a recording without payload")
    loaded = problem.loaded
    both = merged([problem.unloaded.renamed(loaded.columns), loaded])
    return weighted(both, weights.own if weights else None)
