"""Base parameters: combinations of standard parameters that torques determine, and their regressors (13).

They are found numerically: QR of the regressor on random states (Gautier 1991).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import casadi as ca
import numpy as np

from ...common import Array, Brief, InputError, frozen_array
from ...common.linear import RANK_TOLERANCE
from ..regressors import regressor, standard_columns, standard_regressor
from ..robot import Robot, check_robot

STATES_PER_JOINT = 12  # random states for each joint: n rows each, so 12 n^2 rows for at most 14 n columns
_PRECISION = 1e-15
_ROUNDING = 1e-10  # factor in a grouping below which it is rounding


@dataclass(frozen=True, eq=False, repr=False)
class BaseParameters(Brief):
    """The minimal parameters chi of (13).

    Attributes:
        standard: names of the standard parameters, N_s.
        chosen: positions in ``standard`` of those that stand for a base parameter, N_b, rising.
        grouping: G, N_b x N_s: base parameters = G @ standard parameters, and W_s = W_base @ G.
        decided_by: what found them.
        expressions: each base parameter written with the robot's own lengths, "D3^2*(M3+M4) + ZZ1", N_b texts;
            empty where nothing symbolic is known.
    """

    standard: tuple[str, ...]
    chosen: tuple[int, ...]
    grouping: Array
    decided_by: Literal["closed form", "QR"] = "QR"
    expressions: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        shape = (len(self.chosen), len(self.standard))
        exact = np.where(np.abs(self.grouping) < _ROUNDING, 0.0, self.grouping)
        object.__setattr__(self, "grouping", frozen_array(exact, shape, "grouping"))
        if self.expressions and len(self.expressions) != len(self.chosen):
            raise ValueError(f"{len(self.expressions)} expressions for {len(self.chosen)} base parameters")

    @property
    def columns(self) -> tuple[str, ...]:
        """Standard parameters whose columns make up W_base, N_b names ("XX2")."""
        return tuple(self.standard[k] for k in self.chosen)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the base parameters, with R where others are grouped in ("XX2R")."""
        grouped = (np.abs(self.grouping) > 0).sum(axis=1) > 1
        return tuple(f"{name}R" if more else name for name, more in zip(self.columns, grouped, strict=True))

    @property
    def unidentifiable(self) -> tuple[str, ...]:
        """Standard parameters without any effect on the torques."""
        effect = np.abs(self.grouping).sum(axis=0)
        return tuple(name for name, size in zip(self.standard, effect, strict=True) if size == 0.0)

    @property
    def eliminated(self) -> tuple[str, ...]:
        """Standard parameters that stand for no base parameter: grouped into others or without effect."""
        return tuple(name for name in self.standard if name not in self.columns)

    def groupings(self, symbolic: bool = False) -> tuple[str, ...]:
        """Write each base parameter as a sum: "XX2R = XX2 - YY2 - 0.2025 M3".

        Args:
            symbolic: with the robot's own lengths instead: "XX2R = -D3^2*(M3+M4) + XX2 - YY2".

        Raises:
            ValueError: if symbolic text is asked for and there is none.
        """
        if symbolic:
            if not self.expressions:
                raise ValueError(
                    f"base parameters decided by {self.decided_by} have no symbolic text: "
                    "use closed_form_base_parameters"
                )
            return tuple(f"{name} = {text}" for name, text in zip(self.names, self.expressions, strict=True))
        return tuple(f"{name} = {text}" for name, text in zip(self.names, self.sums(), strict=True))

    def sums(self, digits: int = 6) -> tuple[str, ...]:
        """Write what each base parameter is: "XX2 - YY2 - 0.2025 M3"."""
        rows = zip(self.chosen, self.grouping, strict=True)
        return tuple(
            sum_text(self.standard[k], self.standard, np.where(np.arange(len(row)) == k, 0.0, row), digits)
            for k, row in rows
        )

    def value(self, parameters: Mapping[str, float]) -> Array:
        """Evaluate the base parameters of a robot with the given standard parameters, shape (N_b,).

        Raises:
            KeyError: if a standard parameter is missing.
        """
        return np.asarray(self.grouping @ np.array([parameters[name] for name in self.standard]))

    def effect_of(self, columns: tuple[str, ...]) -> Array:
        """Derivatives of the base parameters by some standard parameters, N_b x ``len(columns)``.

        With the last link's ten it is the map from a payload to base parameters behind (25)-(28).
        """
        return self.grouping[:, [self.standard.index(name) for name in columns]]


def sum_text(first: str, names: Sequence[str], factors: Array, digits: int = 6) -> str:
    """Write a sum of parameters, the first one with a factor of 1: "XX2 - YY2 - 0.2025 M3"."""
    text = first
    for name, factor in zip(names, factors.tolist(), strict=True):
        if factor:
            size = "" if abs(abs(factor) - 1.0) < 1e-9 else f"{abs(factor):.{digits}g} "
            text += f" {'-' if factor < 0.0 else '+'} {size}{name}"
    return text


def base_regressor(robot: Robot, base: BaseParameters) -> ca.Function:
    """``base_regressor(q, qd, qdd) -> Phi``, n x N_b, columns as ``base.columns`` (13)."""
    return regressor(robot, base.columns, "base_regressor")


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
