"""The reduced problem: [W Y] compressed by QR, joint by joint. What every estimator takes."""

import zipfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import lapack

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import RANK_TOLERANCE, decomposed
from .shared_torque import SharedTorque, beside, compressed, refilled

_SHARED = "shared"


@dataclass(frozen=True)
class ReducedProblem:
    """Triangular factors that hold all an estimator can learn from Y = W chi + rho.

    Attributes:
        columns: names of the parameters, c.
        factors: per joint, k x (c + 1) with k <= c + 1: R of the QR decomposition of [W_j Y_j].
        rows: per joint, number of equations.
        effective_rows: per joint, number of equations with independent noise (noise bandwidth times rows).
        shared: what of a joint's torque is of another joint's motor (coupled drives), or of a known spring:
            Q' times it, rows as those of the joint's factor.
    """

    columns: tuple[str, ...]
    factors: tuple[Array, ...]
    rows: tuple[int, ...]
    effective_rows: tuple[float, ...]
    shared: tuple[SharedTorque, ...] = ()

    def select(self, columns: Sequence[str]) -> "ReducedProblem":
        """The same equations with only some of the parameters, in the order given."""
        places = [self.columns.index(name) for name in columns]
        factors = tuple(factor[:, [*places, -1]] for factor in self.factors)
        return replace(self, columns=tuple(columns), factors=factors)

    def renamed(self, columns: Sequence[str]) -> "ReducedProblem":
        """The same equations in other parameters' place among ``columns``; absent ones get no column."""
        factors = []
        places = [columns.index(name) for name in self.columns]
        for factor in self.factors:
            wide = np.zeros((len(factor), len(columns) + 1))
            wide[:, [*places, len(columns)]] = factor
            factors.append(wide)
        return replace(self, columns=tuple(columns), factors=tuple(factors))

    def stacked(self, weights: Array | None = None) -> Array:
        """Factor of all joints together, k x (c + 1), the rows of joint j times ``weights[j]``."""
        weights = np.ones(len(self.factors)) if weights is None else weights
        return triangular(np.vstack([w * factor for w, factor in zip(weights, self.factors, strict=True)]))

    def error_norms(self, values: Array) -> Array:
        """Norm of Y_j - W_j chi for each joint, shape (n,)."""
        x = np.append(-values, 1.0)
        return np.array([np.linalg.norm(factor @ x) for factor in self.factors])

    @cached_property
    def torque_norms(self) -> Array:
        """Norm of Y_j for each joint, shape (n,)."""
        return np.array([np.linalg.norm(factor[:, -1]) for factor in self.factors])

    def save(self, path: str | Path) -> None:
        """Write the problem as NPZ, to be merged with others later or elsewhere."""
        np.savez(path, **self.arrays())

    def arrays(self) -> dict[str, Any]:
        """What ``save`` writes: rows, columns, factor0 .., and shared<joint>_<motor> as ``shared``."""
        return {
            "columns": np.array(self.columns),
            "rows": self.rows,
            "effective_rows": self.effective_rows,
            **{f"factor{j}": factor for j, factor in enumerate(self.factors)},
            **{f"{_SHARED}{joint}_{motor}": torque for joint, motor, torque in self.shared},
        }

    @staticmethod
    def load(path: str | Path) -> "ReducedProblem":
        """Read what ``save`` wrote.

        Raises:
            InputError: if the file is not a reduced problem.
        """
        try:
            with np.load(path, allow_pickle=False) as data:
                return ReducedProblem(
                    tuple(str(name) for name in data["columns"]),
                    tuple(data[f"factor{j}"] for j in range(len(data["rows"]))),
                    tuple(int(count) for count in data["rows"]),
                    tuple(float(count) for count in data["effective_rows"]),
                    tuple(
                        SharedTorque(*_joint_and_motor(name), data[name])
                        for name in sorted(data.files)
                        if name.startswith(_SHARED)
                    ),
                )
        except (OSError, KeyError, ValueError, zipfile.BadZipFile) as error:
            raise InputError(f"{path}: not a saved reduced problem ({error})") from None

    @property
    def equations(self) -> int:
        """Number of equations r."""
        return sum(self.rows)

    def condition_numbers(self) -> tuple[float, float]:
        """Condition number of the unweighted W: in SI units, and with columns scaled to norm 1.

        Infinite where W is rank-deficient.
        """
        W = self.stacked()[:, :-1]
        return _condition(W), _condition(_scaled(W))


def _joint_and_motor(name: str) -> tuple[int, int]:
    joint, motor = name.removeprefix(_SHARED).split("_")
    return int(joint), int(motor)


def triangular(rows: Array) -> Array:
    """R of the QR decomposition; fewer rows than columns are kept as they are."""
    return compressed(rows)[0]


def merged(problems: Iterable[ReducedProblem]) -> ReducedProblem:
    """All equations of several problems with the same parameters; the merge is one more QR."""
    problems = list(problems)
    first = problems[0]
    for other in problems[1:]:
        if other.columns != first.columns:
            raise ValueError("problems with different columns cannot be merged")
        if [one[:2] for one in other.shared] != [one[:2] for one in first.shared]:
            raise ValueError("problems of robots with different coupled drives or springs cannot be merged")
    if len(problems) == 1:
        return first
    factors, shared = [], list[SharedTorque]()
    for j in range(len(first.factors)):
        stacked = [np.column_stack([p.factors[j], beside(p.shared, j, len(p.factors[j]))]) for p in problems]
        rows = np.vstack(stacked)
        factor, others = compressed(rows, rows.shape[1] - len(first.columns) - 1)
        factors.append(factor)
        shared += refilled(first.shared, j, others)
    return ReducedProblem(
        first.columns,
        tuple(factors),
        tuple(np.sum([problem.rows for problem in problems], axis=0).tolist()),
        tuple(np.sum([problem.effective_rows for problem in problems], axis=0).tolist()),
        tuple(shared),
    )


def check_rank(W: Array, columns: Sequence[str], rows: int) -> None:
    """Refuse data that leave a direction of the parameters undetermined.

    Args:
        W: observation matrix or its triangular factor, k x c.
        columns: names of the parameters.
        rows: number of equations behind it.

    Raises:
        InputError: names the parameters in the undetermined directions.
    """
    if rows < len(columns):
        raise InputError(
            f"{rows} equations for {len(columns)} parameters: fewer samples than parameters; record longer "
            "or decimate less"
        )
    if _clearly_determined(_scaled(W)):
        return
    undetermined = decomposed(W).null
    if undetermined.size:
        weight = np.abs(undetermined).max(axis=1)
        named = [name for name, w in zip(columns, weight, strict=True) if w > 0.05]
        raise InputError(
            f"the recorded motion leaves {undetermined.shape[1]} of {len(columns)} directions undetermined, in "
            f"{', '.join(named)}: move more joints, faster and over a wider range"
        )


def _clearly_determined(W: Array) -> bool:
    """By LAPACK's condition estimate of a triangle, which costs nothing beside singular values; False if in doubt.

    The estimate is rarely off by more than 3, and the 1-norm's condition within c of the 2-norm's.
    """
    c = W.shape[1]
    if len(W) < c or np.any(np.tril(W, -1)):
        return False
    reciprocal, failed = lapack.dtrcon(W[:c])
    return not failed and bool(reciprocal > 10.0 * c * RANK_TOLERANCE)


def _scaled(W: Array) -> Array:
    norms = np.linalg.norm(W, axis=0)
    return np.asarray(W / np.where(norms > 0.0, norms, 1.0))


def _condition(W: Array) -> float:
    singular = np.linalg.svd(W, compute_uv=False)
    if len(singular) < W.shape[1] or singular[-1] <= 1e-14 * singular[0]:
        return float("inf")
    return float(singular[0] / singular[-1])
