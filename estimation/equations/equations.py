"""The equations Y = W chi + rho compressed by QR, joint by joint and cut in time: what every estimator takes."""

import io
import zipfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.files import write_bytes
from ...common.linear import rank
from ...model import INERTIAL
from .conditioning import condition, scaled
from .elimination import Anchor, anchored, eliminated_from
from .leave_one_out import WithoutEach, each
from .shared_torque import SharedTorque, beside, compressed, refilled

SHARED = "shared"
"""How the names of shared torques begin."""
_Fields = tuple[tuple[str, ...], tuple[Array, ...], tuple[int, ...], tuple[float, ...], tuple[SharedTorque, ...]]


def fields_of(path: str | Path) -> _Fields:
    """Columns, factors, rows, effective rows and shared torques that a file holds.

    Raises:
        InputError: if the file holds something else.
    """
    try:
        with np.load(path, allow_pickle=False) as data:
            return (
                tuple(str(name) for name in data["columns"]),
                tuple(data[f"factor{j}"] for j in range(len(data["rows"]))),
                tuple(int(count) for count in data["rows"]),
                tuple(float(count) for count in data["effective_rows"]),
                tuple(
                    SharedTorque(*_joint_and_motor(name), data[name])
                    for name in sorted(data.files)
                    if name.startswith(SHARED)
                ),
            )
    except (OSError, KeyError, ValueError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: not a saved reduced problem ({error})") from None


def _joint_and_motor(name: str) -> tuple[int, int]:
    joint, motor = name.removeprefix(SHARED).split("_")
    return int(joint), int(motor)


PAYLOAD = tuple(f"{kind}_L" for kind in INERTIAL)
"""Names of the payload's ten parameters chi_L, in the order of (6)."""


@dataclass(frozen=True)
class Equations:
    """Triangular factors that hold all an estimator can learn from Y = W chi + rho.

    Attributes:
        columns: names of the parameters, c.
        factors: per joint, k x (c + 1) with k <= c + 1: R of the QR decomposition of [W_j Y_j].
        rows: per joint, number of equations.
        effective_rows: per joint, number of equations with independent noise (noise bandwidth times rows).
        shared: what of a joint's torque is of another joint's motor (coupled drives), or of a known spring:
            Q' times it, rows as those of the joint's factor.
        leave_one_out: the same equations without each block of time in turn, where the memory of the residuals was
            asked for; ``WithoutEach`` where they are the sum of their blocks.
        block_length: shortest length of a block [s], unless a whole recording is shorter.
    """

    columns: tuple[str, ...]
    factors: tuple[Array, ...]
    rows: tuple[int, ...]
    effective_rows: tuple[float, ...]
    shared: tuple[SharedTorque, ...] = ()
    leave_one_out: "Sequence[Equations]" = ()
    block_length: float = 0.0

    def transformed(self, columns: Sequence[str], M: Array, shift: Array | None = None) -> "Equations":
        """Equations in other parameters p, of which these are chi = M p + shift.

        With a shift the torque W shift is taken off: the rest is no motor's any more, so nothing shared is kept.

        Args:
            columns: names of p.
            M: c x len(columns).
            shift: shape (c,); zero by default.
        """
        factors = []
        for factor in self.factors:
            W, Y = factor[:, :-1], factor[:, -1]
            factors.append(np.column_stack([W @ M, Y if shift is None else Y - W @ shift]))
        shared = self.shared if shift is None else ()
        parts = each(self.leave_one_out, lambda part: part.transformed(columns, M, shift))
        return replace(self, columns=tuple(columns), factors=tuple(factors), shared=shared, leave_one_out=parts)

    def select(self, columns: Sequence[str]) -> "Equations":
        """Keep only some of the parameters, in the order given."""
        return self.transformed(
            columns, np.eye(len(self.columns))[:, [self.columns.index(name) for name in columns]]
        )

    def among(self, columns: Sequence[str]) -> "Equations":
        """Put the parameters among others, whose columns are zero."""
        M = np.zeros((len(self.columns), len(columns)))
        M[range(len(M)), [columns.index(name) for name in self.columns]] = 1.0
        return self.transformed(columns, M)

    def minus(self, names: Sequence[str], values: Array) -> "Equations":
        """Equations in the other parameters alone: the torque W chi of known ones is taken off."""
        known, c = [self.columns.index(name) for name in names], len(self.columns)
        rest, shift = [k for k in range(c) if k not in known], np.zeros(c)
        shift[known] = values
        return self.transformed([self.columns[k] for k in rest], np.eye(c)[:, rest], shift)

    def of_joint(self, joint: int) -> "Equations":
        """The equations of one joint alone, counted from 0; nothing shared is kept."""
        parts = each(self.leave_one_out, lambda part: part.of_joint(joint))
        return replace(
            self,
            factors=(self.factors[joint],),
            rows=(self.rows[joint],),
            effective_rows=(self.effective_rows[joint],),
            shared=(),
            leave_one_out=parts,
        )

    def eliminate(self, columns: Sequence[str], anchors: Sequence[Anchor] = ()) -> "Equations":
        """Take away all that some columns can explain, joint by joint.

        Each joint must have parameters of its own there, such as friction: this is then exact, what is left are the
        equations of the least-squares problem after those unknowns were solved for.

        Args:
            columns: what goes.
            anchors: equations that hold some of them; their levels are new last columns, left out where the levels
                are meant to be zero.
        """
        gone = [self.columns.index(name) for name in columns]
        rest = [k for k in range(len(self.columns)) if k not in gone]
        factors, ranks, shared = [], [], list[SharedTorque]()
        for j, factor in enumerate(self.factors):
            others = beside(self.shared, j, len(factor))
            remaining, eliminated = np.column_stack([factor[:, [*rest, -1]], others]), factor[:, gone]
            remaining, eliminated = anchored(remaining, eliminated, len(rest), columns, anchors, j)
            left, others, count = eliminated_from(remaining, eliminated, others.shape[1])
            factors.append(left)
            shared += refilled(self.shared, j, others)
            ranks.append(rank(factor[:, gone]) if anchors else count)
        return Equations(
            (*(self.columns[k] for k in rest), *(anchor.level for anchor in anchors)),
            tuple(factors),
            tuple(max(rows - gone, 0) for rows, gone in zip(self.rows, ranks, strict=True)),
            tuple(max(rows - gone, 0.0) for rows, gone in zip(self.effective_rows, ranks, strict=True)),
            tuple(shared),
            tuple(part.eliminate(columns, anchors) for part in self.leave_one_out),
            self.block_length,
        )

    def without_blocks(self) -> "Sequence[Equations]":
        """``leave_one_out``, for a jackknife.

        Raises:
            InputError: if there are fewer than two blocks.
        """
        if len(self.leave_one_out) < 2:
            raise InputError("robust standard deviations need two blocks of time at least: record longer")
        return self.leave_one_out

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
        """Write the equations as NPZ, to be merged with others later or elsewhere; the name ends in .npz."""
        content = io.BytesIO()
        np.savez(content, **self.arrays())
        write_bytes(f"{path}" if f"{path}".endswith(".npz") else f"{path}.npz", content.getvalue())

    def arrays(self) -> dict[str, Any]:
        """What ``save`` writes: rows, columns, factor0 .., and shared<joint>_<motor> as ``shared``."""
        return {
            "columns": np.array(self.columns),
            "rows": self.rows,
            "effective_rows": self.effective_rows,
            **{f"factor{j}": factor for j, factor in enumerate(self.factors)},
            **{f"{SHARED}{joint}_{motor}": torque for joint, motor, torque in self.shared},
        }

    @staticmethod
    def load(path: str | Path) -> "Equations":
        """Read what ``save`` wrote.

        Raises:
            InputError: if the file holds something else.
        """
        return Equations(*fields_of(path))

    def merged_with(self, others: Sequence["Equations"]) -> "Equations":
        """Join the equations of others in the same parameters."""
        return merged([self, *others])

    def emptied(self) -> "Equations":
        """No equation at all in the same parameters."""
        none = [0] * len(self.factors)
        return replace(
            self,
            factors=tuple(factor[:0] for factor in self.factors),
            rows=tuple(none),
            effective_rows=tuple(map(float, none)),
            shared=tuple(torque._replace(torque=torque.torque[:0]) for torque in self.shared),
        )

    @property
    def equations(self) -> int:
        """Number of equations r."""
        return sum(self.rows)

    def condition_numbers(self) -> tuple[float, float]:
        """Condition number of the unweighted W: in SI units, and with columns scaled to norm 1.

        Infinite where W is rank-deficient.
        """
        W = self.stacked()[:, :-1]
        return condition(W), condition(scaled(W))


def triangular(rows: Array) -> Array:
    """R of the QR decomposition; fewer rows than columns are kept as they are."""
    return compressed(rows)[0]


def merged(parts: Iterable[Equations]) -> Equations:
    """All equations of several parts with the same parameters; the merge is one more QR. Blocks of all are kept."""
    parts = list(parts)
    if len(parts) == 1:
        return parts[0]
    _check_alike(parts)
    whole = stacked([replace(part, leave_one_out=()) for part in parts])
    cut = [part.leave_one_out for part in parts]
    if not all(cut):
        return whole
    sums = [less for less in cut if isinstance(less, WithoutEach)]
    if len(sums) == len(cut):
        return replace(whole, leave_one_out=WithoutEach([block for less in sums for block in less.blocks]))
    return replace(whole, leave_one_out=_left_out_in_turn(parts))


def _left_out_in_turn(parts: Sequence[Equations]) -> tuple[Equations, ...]:
    """Each part without each of its blocks, beside all other parts."""
    less: list[Equations] = []
    for k, part in enumerate(parts):
        others = [replace(equations, leave_one_out=()) for equations in (*parts[:k], *parts[k + 1 :])]
        less += [stacked([*others, left]) for left in part.leave_one_out]
    return tuple(less)


def stacked(parts: Sequence[Equations], compress: bool = True) -> Equations:
    """All equations of several parts without their blocks, as triangular factors or only one below the other."""
    first, factors, shared = parts[0], [], list[SharedTorque]()
    for j in range(len(first.factors)):
        rows = np.vstack([np.column_stack([p.factors[j], beside(p.shared, j, len(p.factors[j]))]) for p in parts])
        width = len(first.columns) + 1
        factor, others = compressed(rows, rows.shape[1] - width) if compress else np.hsplit(rows, [width])
        factors.append(factor)
        shared += refilled(first.shared, j, others)
    return Equations(
        first.columns,
        tuple(factors),
        tuple(np.sum([part.rows for part in parts], axis=0).tolist()),
        tuple(np.sum([part.effective_rows for part in parts], axis=0).tolist()),
        tuple(shared),
        block_length=max(part.block_length for part in parts),
    )


def _check_alike(parts: Sequence[Equations]) -> None:
    """Refuse parts that are not of the same parameters of the same drives."""
    first, *others = parts
    if any(part.columns != first.columns for part in others):
        raise ValueError("equations with different columns cannot be merged")
    joints = [torque[:2] for torque in first.shared]
    if any([torque[:2] for torque in part.shared] != joints for part in others):
        raise ValueError("equations of robots with different coupled drives or springs cannot be merged")
