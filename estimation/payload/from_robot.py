"""Method 1: the robot's parameters are known, (22) and (23)."""

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import least_squares
from ...model.names import parameter_kind
from ..equations.names import PAYLOAD
from ..equations.problem import ReducedProblem, triangular
from ..fit.estimate import Estimate, fit
from ..fit.least_squares import joint_weights, solve, weighted
from .problem import FixedWeights, PayloadProblem

_FRICTION = ("FS", "FV", "OFF", "FVM", "FSM")


def from_robot(
    problem: PayloadProblem, weights: FixedWeights | None = None, free_friction: bool = False
) -> Estimate:
    """Payload from the loaded recording minus what the robot alone would need.

    The covariance accounts for that of the robot's parameters: C_L = s^2 (W_L' W_L)^-1 + P C P' with
    P = W_L^+ W.

    Args:
        problem: with ``unloaded`` or ``known``.
        weights: taken as given; estimated by default.
        free_friction: estimate friction anew from the loaded recording, for friction that depends on load.
    """
    if problem.known is not None:
        robot = problem.known
    elif problem.unloaded is not None:
        robot = weighted(problem.unloaded, weights.robot if weights else None)
    else:
        raise InputError(
            "method 1 needs the robot's parameters: give a recording without payload or --robot-parameters"
        )
    free = tuple(name for name in robot.names if free_friction and parameter_kind(name) in _FRICTION)
    fixed = tuple(name for name in robot.names if name not in free)
    unknown = (*PAYLOAD, *free)
    chi, C = robot.select(fixed)

    loaded = problem.loaded.select((*fixed, *unknown))
    own = weights.own if weights else _own_weights(_minus_robot(loaded, chi))

    factor = triangular(loaded.stacked(own))
    W, W_L = factor[:, : len(fixed)], factor[:, len(fixed) : -1]
    Y = factor[:, -1] - W @ chi
    solution = solve(np.column_stack([W_L, Y]), unknown, loaded.equations, sum(loaded.effective_rows))
    P = least_squares(W_L, W)
    covariance = solution.covariance + P @ C @ P.T
    ten = slice(0, len(PAYLOAD))
    return Estimate(
        names=PAYLOAD,
        values=solution.values[ten],
        covariance=covariance[ten, ten],
        degrees_of_freedom=min(solution.degrees_of_freedom, robot.degrees_of_freedom),
        fit=fit(loaded, np.concatenate([chi, solution.values])),
        weights=own,
    )


def _own_weights(plain: ReducedProblem) -> Array:
    ordinary = solve(plain.stacked(), plain.columns, plain.equations, sum(plain.effective_rows))
    return joint_weights(plain, ordinary.values)


def _minus_robot(loaded: ReducedProblem, chi: Array) -> ReducedProblem:
    """Equations in the unknowns alone: Y - W chi on the left-hand side."""
    k = len(chi)
    factors = tuple(
        np.column_stack([factor[:, k:-1], factor[:, -1] - factor[:, :k] @ chi]) for factor in loaded.factors
    )
    return ReducedProblem(loaded.columns[k:], factors, loaded.rows, loaded.effective_rows)
