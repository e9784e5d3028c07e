"""The equations Y = W chi + rho compressed by QR, joint by joint and cut in time: what every estimator takes."""

import io
import zipfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
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
from .shared_torque import SharedTorque, beside, compressed, refilled

SHARED = "shared"
"""How the names of shared torques begin."""
PAYLOAD = tuple(f"{kind}_L" for kind in INERTIAL)
"""Names of the payload's ten parameters chi_L, in the order of (6)."""


@dataclass(frozen=True, eq=False)
class Blocks:
    """Equations cut in blocks of time, stacked; together they are the whole.

    Attributes:
        factors: per joint, B x k x (c + 1): the blocks' own, rows of zeros below the shorter ones.
        rows: number of equations, B x n.
        effective_rows: number of those with independent noise, B x n.
        length: shortest length of a block [s], unless a whole recording is shorter.
    """

    factors: tuple[Array, ...] = ()
    rows: Array = field(default_factory=lambda: np.zeros((0, 0)))
    effective_rows: Array = field(default_factory=lambda: np.zeros((0, 0)))
    length: float = 0.0

    def __len__(self) -> int:
        """Number of blocks."""
        return len(self.rows)

    @staticmethod
    def of(blocks: "Sequence[Equations]", length: float = 0.0) -> "Blocks":
        """Stack the equations of blocks."""
        factors = [_stack([part.factors[j][None] for part in blocks]) for j in range(len(blocks[0].factors))]
        rows = np.array([part.rows for part in blocks], dtype=float)
        return Blocks(tuple(factors), rows, np.array([part.effective_rows for part in blocks]), length)

    def joined(self, others: "Blocks", together: bool = False) -> "Blocks":
        """These blocks and then others; ``together``: each with its partner of the same motion."""
        pairs, length = list(zip(self.factors, others.factors, strict=True)), max(self.length, others.length)
        if together:
            rows, effective = self.rows + others.rows, self.effective_rows + others.effective_rows
            return Blocks(tuple(np.concatenate(pair, axis=1) for pair in pairs), rows, effective, length)
        rows, effective = (
            np.vstack([self.rows, others.rows]),
            np.vstack([self.effective_rows, others.effective_rows]),
        )
        return Blocks(tuple(map(_stack, pairs)), rows, effective, length)

    def weighted(self, weights: Array) -> Array:
        """Rows of all joints, those of joint j times ``weights[j]``, B x k x (c + 1)."""
        return np.concatenate([w * stack for w, stack in zip(weights, self.factors, strict=True)], axis=1)


def _stack(parts: Sequence[Array]) -> Array:
    """Stacks of factors, each B x k x (c + 1), as one; rows of zeros below the shorter ones."""
    most = max(part.shape[1] for part in parts)
    return np.concatenate([np.pad(part, ((0, 0), (0, most - part.shape[1]), (0, 0))) for part in parts])


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
        blocks: the same equations cut in blocks of time, where the memory of the residuals was asked for.
    """

    columns: tuple[str, ...]
    factors: tuple[Array, ...]
    rows: tuple[int, ...]
    effective_rows: tuple[float, ...]
    shared: tuple[SharedTorque, ...] = ()
    blocks: Blocks = Blocks()

    def transformed(
        self, M: Array, names: Sequence[str], shift: Array | None = None, joints: Sequence[int] | None = None
    ) -> "Equations":
        """Equations in other parameters p, of which these are chi = M p + shift.

        With a shift the torque W shift is taken off: the rest is no motor's any more, so nothing shared is kept;
        nor is it where only some joints' equations are.

        Args:
            M: c x len(names).
            names: of p.
            shift: shape (c,); zero by default.
            joints: whose equations are kept, from 0; all by default.
        """
        joints, blocks = range(len(self.factors)) if joints is None else joints, self.blocks
        right = np.append(np.zeros(len(self.columns)) if shift is None else -shift, 1.0)
        change = np.column_stack([np.vstack([M, np.zeros(M.shape[1])]), right])
        return Equations(
            tuple(names),
            tuple(self.factors[j] @ change for j in joints),
            tuple(self.rows[j] for j in joints),
            tuple(self.effective_rows[j] for j in joints),
            self.shared if shift is None and len(joints) == len(self.factors) else (),
            Blocks(
                tuple(blocks.factors[j] @ change for j in joints) if len(blocks) else (),
                blocks.rows[:, joints] if len(blocks) else blocks.rows,
                blocks.effective_rows[:, joints] if len(blocks) else blocks.effective_rows,
                blocks.length,
            ),
        )

    def select(self, names: Sequence[str]) -> "Equations":
        """Keep only some of the parameters, or put all among others, whose columns are zero; in the order given.

        Raises:
            ValueError: for names of which neither holds.
        """
        if not (set(names) <= set(self.columns) or set(self.columns) <= set(names)):
            raise ValueError(f"neither a part of {self.columns} nor more: {tuple(names)}")
        M = np.zeros((len(self.columns), len(names)))
        for k, name in enumerate(names):
            if name in self.columns:
                M[self.columns.index(name), k] = 1.0
        return self.transformed(M, names)

    def minus(self, names: Sequence[str], values: Array) -> "Equations":
        """Equations in the other parameters alone: the torque W chi of known ones is taken off."""
        known, c = [self.columns.index(name) for name in names], len(self.columns)
        rest, shift = [k for k in range(c) if k not in known], np.zeros(c)
        shift[known] = values
        return self.transformed(np.eye(c)[:, rest], [self.columns[k] for k in rest], shift)

    def eliminate(self, columns: Sequence[str], anchors: Sequence[Anchor] = ()) -> "Equations":
        """Take away all that some columns can explain, joint by joint.

        Each joint must have parameters of its own there, such as friction: this is then exact, what is left are the
        equations of the least-squares problem after those unknowns were solved for. Blocks of time are not kept:
        what remains of each depends on the others.

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
        )

    @property
    def whole(self) -> "Equations":
        """The equations without their blocks."""
        return replace(self, blocks=Blocks())

    def parts(self) -> list["Equations"]:
        """The equations of each block; nothing shared is kept."""
        counts = zip(self.blocks.rows.astype(int).tolist(), self.blocks.effective_rows.tolist(), strict=True)
        return [
            Equations(self.columns, tuple(stack[b] for stack in self.blocks.factors), tuple(rows), tuple(effective))
            for b, (rows, effective) in enumerate(counts)
        ]

    def without_each(self) -> list["Equations"]:
        """The equations without each block, for a jackknife; nothing shared is kept.

        What lies before and after each block is merged once for all: 3 B merges instead of B^2.

        Raises:
            InputError: if there are fewer than two blocks.
        """
        if len(self.blocks) < 2:
            raise InputError("robust standard deviations need two blocks of time at least: record longer")
        blocks = self.parts()
        after: list[list[Equations]] = [[]]
        for block in reversed(blocks[1:]):
            after.append([merged([block, *after[-1]])])
        before: list[Equations] = []
        without = []
        for block in blocks:
            without.append(merged([*before, *after.pop()]))
            before = [merged([*before, block])]
        return without

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
        try:
            with np.load(path, allow_pickle=False) as data:
                shared = []
                for name in sorted(name for name in data.files if name.startswith(SHARED)):
                    joint, motor = name.removeprefix(SHARED).split("_")
                    shared.append(SharedTorque(int(joint), int(motor), data[name]))
                return Equations(
                    tuple(str(name) for name in data["columns"]),
                    tuple(data[f"factor{j}"] for j in range(len(data["rows"]))),
                    tuple(int(count) for count in data["rows"]),
                    tuple(float(count) for count in data["effective_rows"]),
                    tuple(shared),
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
        return condition(W), condition(scaled(W))


def triangular(rows: Array) -> Array:
    """R of the QR decomposition; fewer rows than columns are kept as they are."""
    return compressed(rows)[0]


def merged(parts: Iterable[Equations]) -> Equations:
    """All equations of several parts with the same parameters; the merge is one more QR. Blocks of all are kept."""
    parts = list(parts)
    first = parts[0]
    if len(parts) == 1:
        return first
    _check_alike(parts)
    factors, shared = [], list[SharedTorque]()
    for j in range(len(first.factors)):
        rows = np.vstack([np.column_stack([p.factors[j], beside(p.shared, j, len(p.factors[j]))]) for p in parts])
        factor, others = compressed(rows, rows.shape[1] - len(first.columns) - 1)
        factors.append(factor)
        shared += refilled(first.shared, j, others)
    return Equations(
        first.columns,
        tuple(factors),
        tuple(np.sum([part.rows for part in parts], axis=0).tolist()),
        tuple(np.sum([part.effective_rows for part in parts], axis=0).tolist()),
        tuple(shared),
        reduce(Blocks.joined, [p.blocks for p in parts]) if all(len(p.blocks) for p in parts) else Blocks(),
    )


def _check_alike(parts: Sequence[Equations]) -> None:
    """Refuse parts that are not of the same parameters of the same drives."""
    first, *others = parts
    if any(part.columns != first.columns for part in others):
        raise ValueError("equations with different columns cannot be merged")
    joints = [torque[:2] for torque in first.shared]
    if any([torque[:2] for torque in part.shared] != joints for part in others):
        raise ValueError("equations of robots with different coupled drives or springs cannot be merged")
