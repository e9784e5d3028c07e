"""The payload's equations joint by joint: the mass that some show, the share that one does."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag

from ...common.arrays import Array
from ...common.linear import Decomposition, decomposed
from ..equations.equations import PAYLOAD
from ..fit.linear_problem import LinearProblem

_BLURRED = 0.05
"""Share of noise in the torque that the other joints' payload predicts, above which a factor on it says nothing."""
_HIDDEN = 1e-6
"""Share of the mass in undetermined directions above which it is not visible."""


class Number(NamedTuple):
    """``variance`` by the formula; ``lasting``: the part of it that no block of time shows."""

    value: float
    variance: float
    lasting: float = 0.0


class JointEquations(NamedTuple):
    """Per joint weighted factors [W_L Y] of the payload, and W of what was taken off.

    ``covariance`` of the parameters taken off; ``lasting``: of them, what no block of time shows.
    """

    payload: tuple[Array, ...]
    taken: tuple[Array, ...]
    covariance: Array
    lasting: Array
    rows: tuple[float, ...]

    @staticmethod
    def of(problem: LinearProblem, weights: Array) -> "JointEquations":
        """The payload's ten alone, for weights of the joints."""
        unknown = problem.unknown.select(PAYLOAD)
        factors = problem.equations.select([name for group in problem.known for name in group.names]).factors
        lasting = _together([group.lasting for group in problem.known])
        # What an earlier identification's jackknife says counts instead of its formula.
        covariance = _together(
            [group.lasting if group.lasting.any() else group.covariance for group in problem.known]
        )
        return JointEquations(
            tuple(w * factor for w, factor in zip(weights, unknown.factors, strict=True)),
            tuple(w * factor[:, :-1] for w, factor in zip(weights, factors, strict=True)),
            covariance,
            lasting,
            unknown.effective_rows,
        )


def _together(covariances: Sequence[Array]) -> Array:
    """Covariance of independent groups of parameters."""
    return np.asarray(block_diag(*covariances)) if covariances else np.zeros((0, 0))


def mass_of(joints: Sequence[int]) -> Callable[[JointEquations], Number | None]:
    """Gives the mass by the equations of some joints (from 1); none where they leave it undetermined."""
    places = [joint - 1 for joint in joints]

    def mass(equations: JointEquations) -> Number | None:
        factor = np.vstack([equations.payload[j] for j in places])
        parts = decomposed(factor[:, :-1])
        return _number(equations, places, factor, parts, -1) if parts.hidden[-1] <= _HIDDEN else None

    return mass


def share_of(joint: int) -> Callable[[JointEquations], Number | None]:
    """Gives the share of the payload that a joint (from 1) shows; none where the others determine it too badly."""
    own = joint - 1

    def share(equations: JointEquations) -> Number | None:
        others = [j for j in range(len(equations.payload)) if j != own]
        factor = np.vstack([equations.payload[j] for j in others])
        parts = decomposed(factor[:, :-1])
        if parts.hidden.max() > _HIDDEN:
            return None
        inverse = parts.inverse
        x = inverse @ factor[:, -1]
        A, y = equations.payload[own][:, :-1], equations.payload[own][:, -1]
        predicted = A @ x
        # Errors of the others' payload are part of the error of what is predicted; large ones bias the factor.
        noise = A @ inverse @ inverse.T @ A.T
        if not np.trace(noise) < _BLURRED * float(predicted @ predicted):
            return None
        whitened = np.linalg.solve(np.eye(len(A)) + noise, predicted)
        size = float(whitened @ predicted)
        return Number(float(whitened @ y) / size, 1.0 / size)

    return share


def _number(
    equations: JointEquations, places: Sequence[int], factor: Array, parts: Decomposition, k: int
) -> Number:
    """Parameter k of [A Y], A decomposed, with the variance of the residual and of the parameters taken off."""
    Y, row = factor[:, -1], parts.inverse[k]
    error = Y - factor[:, :-1] @ parts.solution(Y)
    spare = max(sum(equations.rows[j] for j in places) - parts.rank, 1.0)
    gain = row @ np.vstack([equations.taken[j] for j in places])
    own = float(error @ error) / spare * float(row @ row)
    lasting = float(gain @ equations.lasting @ gain)
    return Number(float(row @ Y), own + float(gain @ equations.covariance @ gain), lasting)
