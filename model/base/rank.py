"""Base parameters found numerically: QR of the regressor on random states (Gautier 1991)."""

from functools import lru_cache

import numpy as np

from ...common import Array, InputError
from ...common.linear import RANK_TOLERANCE
from ..regressors import standard_columns, standard_regressor
from ..robot import Robot, check_robot
from .parameters import BaseParameters

STATES_PER_JOINT = 12  # random states for each joint: n rows each, so 12 n^2 rows for at most 14 n columns
_PRECISION = 1e-15


@lru_cache(maxsize=32)
def base_parameters(robot: Robot, seed: int = 0) -> BaseParameters:
    """Base parameters of a robot, drives included, as a left-to-right choice of columns.

    Columns are taken base to tip in the order of (6); a column that depends on those before it is grouped
    into them. This finds the same names as Khalil's closed-form rules. They are kept: a command asks for those of
    one robot several times.

    >>> base_parameters(robot).groupings()[3]
    'XX2R = XX2 - YY2 - 0.2025 M3 - 0.2025 M4 - 0.2025 M5 - 0.2025 M6'
    """
    check_robot(robot)
    count = STATES_PER_JOINT * robot.n
    W = stacked_regressor(robot, *random_states(robot, count, seed))
    for joint in robot.drives.unmeasured:
        W[(joint - 1) * count : joint * count] = 0.0
    return base_parameters_of(standard_columns(robot), W)


def base_parameters_of(columns: tuple[str, ...], W: Array) -> BaseParameters:
    """Find the base parameters that a standard regressor W on many states shows, at least N_s rows x N_s."""
    R = np.asarray(np.linalg.qr(W, mode="r"))
    residuals = left_residuals(R)
    chosen = np.flatnonzero(residuals > RANK_TOLERANCE)
    grouping = np.zeros((len(chosen), W.shape[1]))
    rest = np.setdiff1d(np.arange(W.shape[1]), chosen)
    grouping[:, chosen] = np.eye(len(chosen))
    size = np.linalg.norm(R[:, chosen], axis=0)
    grouping[:, rest] = np.linalg.lstsq(R[:, chosen] / size, R[:, rest], rcond=None)[0] / size[:, None]
    # What is nearly dependent is known to so many digits less.
    grouping[np.abs(grouping) < _PRECISION / residuals[chosen].min(initial=1.0)] = 0.0
    return BaseParameters(columns, tuple(chosen.tolist()), grouping, "QR")


def random_states(robot: Robot, count: int, seed: int) -> tuple[Array, Array, Array]:
    """Random q, qd, qdd of shape (count, n), of the order of 1 in SI units."""
    draw = np.random.default_rng(seed)
    span = np.array([np.pi if joint.revolute else 1.0 for joint in robot.joints])
    q = draw.uniform(-1.0, 1.0, (count, robot.n)) * span
    qd, qdd = draw.uniform(-3.0, 3.0, (2, count, robot.n))
    return q, qd, qdd


def stacked_regressor(robot: Robot, q: Array, qd: Array, qdd: Array) -> Array:
    """Evaluate the standard regressor on all states, one below the other: (count * n) x N_s."""
    # So few states are not worth a kernel, which must be compiled once.
    phi, states = standard_regressor(robot), [q.T, qd.T, qdd.T]
    if phi.n_in() > len(states):  # friction that depends on load, which any parameters may cause
        states.append(np.random.default_rng(len(q)).uniform(-1.0, 1.0, q.T.shape))
    side_by_side = phi.map(len(q))(*states)
    W = np.asarray(side_by_side.full().reshape(robot.n * len(q), -1))
    if not np.isfinite(W).all():
        names = [
            name for name, column in zip(standard_columns(robot), W.T, strict=True) if not np.isfinite(column).all()
        ]
        raise InputError(f"{', '.join(names)}: the law is no number at some speed, position or load: correct it")
    return W


def leftmost_independent(W: Array) -> list[int]:
    """Indices of the columns of ``W`` that do not depend on those to their left."""
    return [int(k) for k in np.flatnonzero(left_residuals(W) > RANK_TOLERANCE)]


def left_residuals(W: Array, tolerance: float = RANK_TOLERANCE) -> Array:
    """Residual of each column without those to its left, over the largest column: dependent below the tolerance."""
    # Every residual is orthogonalised twice, so that the decision does not hang on rounding.
    largest = np.linalg.norm(W, axis=0).max(initial=0.0)
    residuals = np.zeros(W.shape[1])
    basis = np.empty((W.shape[0], min(W.shape)))
    known = 0
    for k in range(W.shape[1]):
        if known == basis.shape[1]:
            break
        before = basis[:, :known]
        residual = W[:, k] - before @ (before.T @ W[:, k])
        residual -= before @ (before.T @ residual)
        size = np.linalg.norm(residual)
        residuals[k] = size / largest if largest > 0.0 else 0.0
        if residuals[k] > tolerance:
            basis[:, known] = residual / size
            known += 1
    return residuals
