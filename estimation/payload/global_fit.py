"""Method 4: robot and payload together, (30)."""

from collections.abc import Sequence
from dataclasses import replace

from ...common.errors import InputError
from ..equations.names import PAYLOAD
from ..equations.problem import ReducedProblem, merged
from ..fit.essential import Elimination, StopRule, eliminate
from ..fit.estimate import Estimate, fit
from ..fit.least_squares import weighted
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
    return weighted(combined_problem(problem), weights.own if weights else None)


def selected(problem: PayloadProblem, weights: FixedWeights | None, *, names: Sequence[str]) -> Estimate:
    """The same with some parameters only, the others zero."""
    return weighted(combined_problem(problem).select(names), weights.own if weights else None)


def combined_problem(problem: PayloadProblem) -> ReducedProblem:
    """The equations of (30), columns base, then ``PAYLOAD``."""
    if problem.unloaded is None:
        raise InputError("method 4 needs a recording without payload")
    return merged([problem.unloaded.renamed(problem.loaded.columns), problem.loaded])


def essential_combined(problem: PayloadProblem, rule: StopRule | None = None) -> Elimination:
    """Essential parameters of robot and payload (in frame n) together, as in Table 2."""
    both = combined_problem(problem)
    return eliminate(both, weighted(both), rule)
