"""Least squares on the currents, i_j = k_j (W_j x) + rho_j, over k and x, by Gauss-Newton.

The errors are in the currents. Fitting torques, K_j i_j = W_j x, has them in a regressor's place and gives gains
that are too small (on a UR10e by 10 % and more); it serves as the start only (its linear system is that of Gautier
and Briot, Global identification of joint drive gains and dynamic parameters of robots, 2014).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag

from ...common import Array, InputError, decomposed
from ..equations.equations import Equations

_MOST = 200  # iterations
_LONGEST = 0.5  # step of a gain, relative
_ENOUGH = 1e-9  # relative change of a gain
_ROUNDS = 3  # of weights for the start
_SPREAD = 10.0  # of gains about their median, as far as weights go
_FLOOR = 1e-9  # of the current: data without noise still need finite weights


class CurrentFit(NamedTuple):
    """Gains and parameters, free or of bodies that can exist."""

    k: Array  # A/(N·m), shape (n,)
    x: Array  # all parameters, shape (c,)
    covariance: Array  # of ln K by the free fit, n x n, for white noise
    degrees_of_freedom: float


def current_weights(equations: Equations) -> Array:
    """Weights of the joints: one over the standard deviation of the current's error [1/A], shape (n,).

    From the joint's own equations with parameters of their own, so that neither gains nor other joints matter.
    """
    sigma = []
    whole = np.sqrt(sum(np.sum(factor[:, :-1] ** 2, axis=0) for factor in equations.factors))
    for factor, rows in zip(equations.factors, equations.effective_rows, strict=True):
        W, d = factor[:, :-1], factor[:, -1]
        # What this joint's equations do not hold is not quite zero in them, and would cost degrees of freedom.
        parts = decomposed(W, whole)
        error = np.linalg.norm(d - W @ parts.solution(d)) / np.sqrt(max(rows - parts.rank, 1.0))
        sigma.append(max(error, _FLOOR * np.linalg.norm(d) / np.sqrt(max(rows, 1.0)), 1e-300))
    return 1.0 / np.array(sigma)


def gauss_newton(equations: Equations, weights: Array, free: Sequence[int], known: Array) -> CurrentFit:
    """Minimise sum_j w_j^2 ||i_j - k_j W_j x||^2.

    Args:
        equations: factors of [W i].
        weights: per joint [1/A].
        free: indices of the unknown parameters among the columns.
        known: the others' values, which set the scale, zero at the free ones, shape (c,).
    """
    c, factors = len(free), equations.factors
    k, x = torque_side(factors, free, known)
    for _ in range(_ROUNDS):
        # Each joint weighted by the errors of its torque: else a disturbance of the arm's joints outweighs all that
        # the wrist's say.
        middle = float(np.median(np.abs(k)))
        size = weights * np.clip(np.abs(k), middle / _SPREAD, middle * _SPREAD)
        k, x = torque_side([w * factor for w, factor in zip(size, factors, strict=True)], free, known)
    step = np.full(c + len(k), np.inf)
    for _ in range(_MOST):
        J, error = linearised(factors, weights, k, x, free)
        parts = decomposed(J)
        if np.abs(step[c:] / k).max() < _ENOUGH:
            break
        if parts.null.size:  # the gains stand last
            missing = np.abs(parts.null[c:]).max(axis=1)
            joints = [str(j) for j, weight in enumerate(missing, 1) if weight > 1e-3]
            unknown = f"the gain of joint {', '.join(joints)}" if joints else "the robot's parameters"
            raise InputError(
                f"the recordings do not determine {unknown}: move more joints, faster and over a wider range"
            )
        step = parts.solution(error)
        step *= min(1.0, _LONGEST / np.abs(step[c:] / k).max())
        x[free] += step[:c]
        k += step[c:]
    else:
        raise InputError(
            "the drive gains do not settle: check units, signs and order of the currents, and that the arm touched "
            "nothing"
        )
    dof = sum(equations.effective_rows) - J.shape[1]
    if dof <= 0.0:
        raise InputError(f"too few samples for {J.shape[1]} unknowns: record longer")
    return CurrentFit(k, x, float(error @ error) / dof * parts.covariance[c:, c:] / np.outer(k, k), dof)


def torque_side(factors: Sequence[Array], free: Sequence[int], known: Array) -> tuple[Array, Array]:
    """Solve on the torque side for k, x of K_j i_j = W_j x, linear in K and x."""
    c = len(free)
    by_x, by_K = np.vstack([factor[:, free] for factor in factors]), (-factor[:, -1:] for factor in factors)
    A, b = np.hstack([by_x, block_diag(*by_K)]), -np.concatenate([factor[:, :-1] @ known for factor in factors])
    solution = decomposed(A).solution(b)
    K = solution[c:]
    if not (np.abs(K) > 1e-12 * np.abs(K).max()).all():
        raise InputError("the payload does not show in the currents: is it in the loaded recording?")
    x = known.copy()
    x[free] = solution[:c]
    return 1.0 / K, x


def linearised(
    factors: Sequence[Array], weights: Array, k: Array, x: Array, free: Sequence[int]
) -> tuple[Array, Array]:
    """Jacobian of the predicted currents by the free x and k, and the currents' errors, both weighted."""
    torques = [factor[:, :-1] @ x for factor in factors]
    by_x = [w * own * factor[:, free] for factor, w, own in zip(factors, weights, k, strict=True)]
    by_k = [(w * torque)[:, None] for w, torque in zip(weights, torques, strict=True)]
    J = np.hstack([np.vstack(by_x), block_diag(*by_k)])
    parts = zip(factors, weights, k, torques, strict=True)
    return J, np.concatenate([w * (factor[:, -1] - own * torque) for factor, w, own, torque in parts])
