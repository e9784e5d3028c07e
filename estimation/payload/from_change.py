"""Method 2: the change of the base parameters under load, (24)-(28) for any robot."""

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import decomposed
from ...model.names import parameter_kind
from ...model.regressors import payload_columns
from ..equations.names import PAYLOAD
from ..fit.estimate import Estimate, fit
from ..fit.least_squares import weighted
from .problem import FixedWeights, PayloadProblem

_DRIVE = ("IA", "FS", "FV", "OFF", "FVM", "FSM")


def from_change(problem: PayloadProblem, weights: FixedWeights | None = None) -> Estimate:
    """Payload from two identifications of the robot, without and with it.

    Base parameters change by Delta chi = G_L chi_L, where G_L (N_b x 10) holds the last link's columns of the
    grouping matrix; on the RX90 its rows are (25)-(28). Solved by least squares weighted by the covariance of
    Delta chi. Drive parameters take no part: friction may change under load.
    """
    if problem.unloaded is None:
        raise InputError("method 2 needs a recording without payload")
    columns = problem.base.columns
    before = weighted(problem.unloaded, weights.robot if weights else None)
    after = weighted(problem.loaded.select(columns), weights.own if weights else None)
    inertial = tuple(name for name in columns if parameter_kind(name) not in _DRIVE)
    chi_a, C_a = before.select(inertial)
    chi_b, C_b = after.select(inertial)
    G = payload_map(problem)[[columns.index(name) for name in inertial]]
    values, covariance = _generalised(G, chi_b - chi_a, C_a + C_b)
    explained = np.concatenate([before.values, values])
    return Estimate(
        names=PAYLOAD,
        values=values,
        covariance=covariance,
        degrees_of_freedom=min(before.degrees_of_freedom, after.degrees_of_freedom),
        fit=fit(problem.loaded, explained),
        weights=after.weights,
    )


def payload_map(problem: PayloadProblem) -> Array:
    """G_L: how the base parameters change with the payload's ten; N_b x 10."""
    return problem.base.effect_of(payload_columns(problem.robot))


def _generalised(G: Array, change: Array, C: Array) -> tuple[Array, Array]:
    """Generalised least squares of G x = change with covariance C: x and its covariance."""
    scale = np.sqrt(np.diag(C))
    L = np.linalg.cholesky(C / np.outer(scale, scale))
    A = np.asarray(np.linalg.solve(L, G / scale[:, None]))
    b = np.asarray(np.linalg.solve(L, change / scale))
    parts = decomposed(A)
    if parts.null.size:
        raise InputError("the base parameters of this robot do not show all ten parameters of a payload")
    return parts.solution(b), parts.covariance
