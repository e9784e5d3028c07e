"""Gains without constraints: Gauss-Newton on the exact least squares of the currents.

The errors are in the currents. Fitting torques, K_j i_j = W_j chi + W_Lj chi_L, has them in a regressor's place and
gives gains that are too small (on a UR10e by 10 % and more); it serves as the start only (its linear system is that
of Gautier and Briot, Global identification of joint drive gains and dynamic parameters of robots, 2014).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...model import InputError
from ...model.arrays import Array
from ..payload.equations import PAYLOAD
from ..problem import ReducedProblem
from .known_load import KnownLoad

_MOST = 200  # iterations
_ENOUGH = 1e-9  # relative change of a gain
_UNDETERMINED = 1e-8  # singular value of the scaled Jacobian over the largest


class FreeGains(NamedTuple):
    """Gains and parameters.

    ``k`` (n,) [A/(N·m)]; ``x`` (c,) base parameters and the payload's ten; ``covariance`` of ln K, n x n, for white
    noise and an exact load; ``degrees_of_freedom``.
    """

    k: Array
    x: Array
    covariance: Array
    degrees_of_freedom: float


def free_gains(equations: ReducedProblem, load: KnownLoad, weights: Array) -> FreeGains:
    """Minimise sum_j w_j^2 ||i_j - k_j (W_j chi + W_Lj chi_L)||^2 over k, chi and what is unknown of chi_L.

    Args:
        equations: as in ``GainProblem``.
        load: the known payload.
        weights: per joint [1/A].

    Raises:
        InputError: if the recordings leave a gain undetermined, or one is negative.
    """
    columns = equations.columns
    free = [k for k, name in enumerate(columns) if name not in load.known]
    known = np.zeros(len(columns))
    known[-len(PAYLOAD) :] = load.ten
    k, x = _start(equations.factors, free, known)
    for _ in range(_MOST):
        J, error = _linearised(equations.factors, weights, k, x, free)
        scale = np.linalg.norm(J, axis=0)
        _check_determined(J / scale, len(k))
        step = np.linalg.lstsq(J / scale, error, rcond=None)[0] / scale
        x[free] += step[: len(free)]
        k += step[len(free) :]
        if np.abs(step[len(free) :] / k).max() < _ENOUGH:
            break
    else:
        raise InputError("the drive gains do not settle: check units, signs and order of the currents")
    wrong = [str(j) for j, value in enumerate(k, 1) if value <= 0.0]
    if wrong:
        raise InputError(
            f"the current of joint {', '.join(wrong)} pushes against its motion: turn its sign (a log map's "
            "'sign'), or check the order of joints"
        )
    J, error = _linearised(equations.factors, weights, k, x, free)
    R = np.linalg.qr(J / scale, mode="r")
    dof = sum(equations.effective_rows) - J.shape[1]
    if dof <= 0.0:
        raise InputError(f"too few samples for {J.shape[1]} unknowns: record longer")
    inverse = np.linalg.inv(R)[len(free) :] / scale[len(free) :, None] / k[:, None]
    return FreeGains(k, x, float(error @ error) / dof * inverse @ inverse.T, dof)


def _start(factors: Sequence[Array], free: Sequence[int], known: Array) -> tuple[Array, Array]:
    """The torque-side solution of K_j i_j = W_j chi + W_Lj chi_L, linear in K, chi and chi_L."""
    n = len(factors)
    rows, right = [], []
    for j, factor in enumerate(factors):
        gains = np.zeros((len(factor), n))
        gains[:, j] = -factor[:, -1]
        rows.append(np.column_stack([factor[:, free], gains]))
        right.append(-factor[:, :-1] @ known)
    A = np.vstack(rows)
    scale = np.linalg.norm(A, axis=0)
    scale[scale == 0.0] = 1.0
    solution = np.linalg.lstsq(A / scale, np.concatenate(right), rcond=None)[0] / scale
    K = solution[len(free) :]
    if not (np.abs(K) > 1e-12 * np.abs(K).max()).all():
        raise InputError("the payload does not show in the currents: is it in the loaded recording?")
    x = known.copy()
    x[free] = solution[: len(free)]
    return 1.0 / K, x


def _linearised(
    factors: Sequence[Array], weights: Array, k: Array, x: Array, free: Sequence[int]
) -> tuple[Array, Array]:
    """Jacobian of the predicted currents by the free x and k, and the currents' errors, both weighted."""
    rows, errors = [], []
    for j, (factor, w) in enumerate(zip(factors, weights, strict=True)):
        torque = factor[:, :-1] @ x
        own = np.zeros((len(factor), len(k)))
        own[:, j] = torque
        rows.append(w * np.column_stack([k[j] * factor[:, free], own]))
        errors.append(w * (factor[:, -1] - k[j] * torque))
    return np.vstack(rows), np.concatenate(errors)


def _check_determined(J: Array, n: int) -> None:
    _, singular, Vt = np.linalg.svd(J, full_matrices=False)
    missing = np.abs(Vt[singular < _UNDETERMINED * singular[0]][:, -n:]).max(axis=0, initial=0.0)
    if (singular < _UNDETERMINED * singular[0]).any():
        joints = [str(j) for j, weight in enumerate(missing, 1) if weight > 1e-3]
        what = f"the gain of joint {', '.join(joints)}" if joints else "the robot's parameters"
        raise InputError(f"the recordings do not determine {what}: move more joints, faster and over a wider range")
