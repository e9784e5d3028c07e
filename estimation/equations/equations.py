"""The equations Y = W chi + rho compressed by QR, joint by joint and cut in time: what every estimator takes."""

import io
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import accumulate, chain
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import lapack

from ...common import Array, Brief, InputError, decomposed
from ...common.files import write_bytes
from ...common.linear import RANK_TOLERANCE, condition_numbers
from ...model import INERTIAL

SHARED = "shared"  # beginning of the names of shared torques
PAYLOAD = tuple(f"{kind}_L" for kind in INERTIAL)
"""Names of the payload's ten parameters chi_L, in the order of (6)."""
FREE = "free "  # beginning of the names of what is estimated anew in each recording, besides the payload
NO_MOTOR = -1  # index that stands for a motor where a known spring makes the torque
_NOISE_FLOOR = 1e-12
"""Standard deviation of the error over the torque, at least: data without noise still need finite weights."""


@dataclass(frozen=True, eq=False, repr=False)
class Equations(Brief):
    """Triangular factors that hold all an estimator can learn from Y = W chi + rho.

    Attributes:
        columns: names of the parameters, c.
        factors: per joint, k x (c + 1) with k <= c + 1: R of the QR decomposition of [W_j Y_j].
        rows: per joint, number of equations.
        effective_rows: per joint, number of equations with independent noise (noise bandwidth times rows).
        shared: by joint and motor (both from 0), the part of the joint's torque Y_j that another joint's motor
            makes, where drives are coupled (9), or a known spring (``NO_MOTOR``), whose torque no gain scales: Q'
            times it, rows as those of the joint's factor.
        blocks: the same equations cut in blocks of time, where the memory of the residuals was asked for; nothing
            shared is kept of them.
        block_length: shortest length of a block [s], unless a whole recording is shorter.

    >>> Equations.from_arrays([[1.0], [2.0]], [1.1, 1.9], joint=[1, 1], names=["FV1"]).equations
    2
    """

    columns: tuple[str, ...]
    factors: tuple[Array, ...]
    rows: tuple[int, ...]
    effective_rows: tuple[float, ...]
    shared: Mapping[tuple[int, int], Array] = field(default_factory=dict)
    blocks: tuple["Equations", ...] = ()
    block_length: float = 0.0

    @staticmethod
    def from_arrays(W: ArrayLike, Y: ArrayLike, joint: ArrayLike, names: Sequence[str]) -> "Equations":
        """Compress equations of one's own, their errors taken as independent.

        Args:
            W: observation matrix, r x c.
            Y: torques [N·m or N], shape (r,).
            joint: number of each row's joint, from 1, shape (r,).
            names: of the c parameters.

        Raises:
            InputError: if they do not fit each other.
        """
        W, Y, joint = np.asarray(W, dtype=float), np.asarray(Y, dtype=float), np.asarray(joint)
        if W.shape != (len(Y), len(names)) or joint.shape != Y.shape or not len(Y) or joint.min() < 1:
            given = f"W {W.shape}, Y {Y.shape}, joint {joint.shape} and {len(names)} names"
            raise InputError(f"{given} do not fit: give r x c, r, r joints from 1, and c")
        rows = [joint == j for j in range(1, int(joint.max()) + 1)]
        counts = [int(own.sum()) for own in rows]
        factors = (triangular(np.column_stack([W[own], Y[own]])) for own in rows)
        return Equations(tuple(names), tuple(factors), tuple(counts), tuple(map(float, counts)))

    def transformed(
        self, M: Array, names: Sequence[str], shift: Array | None = None, joints: Sequence[int] | None = None
    ) -> "Equations":
        """Write the equations in other parameters p, of which these are chi = M p + shift.

        With a shift the torque W shift is taken off: the rest is no motor's any more, so nothing shared is kept;
        nor is it where only some joints' equations are.

        Args:
            M: c x len(names).
            names: of p.
            shift: shape (c,); zero by default.
            joints: whose equations are kept, from 0; all by default.
        """
        joints = range(len(self.factors)) if joints is None else joints
        right = np.append(np.zeros(len(self.columns)) if shift is None else -shift, 1.0)
        change = np.column_stack([np.vstack([M, np.zeros(M.shape[1])]), right])

        def changed(one: Equations) -> Equations:
            own = [(one.factors[j] @ change, one.rows[j], one.effective_rows[j]) for j in joints]
            factors, rows, effective = zip(*own, strict=True)
            return replace(one, columns=tuple(names), factors=factors, rows=rows, effective_rows=effective)

        shared = self.shared if shift is None and len(joints) == len(self.factors) else {}
        return replace(changed(self), shared=shared, blocks=tuple(map(changed, self.blocks)))

    def select(self, names: Sequence[str]) -> "Equations":
        """Keep only some of the parameters, or put all among others, whose columns are zero; in the order given."""
        if not (set(names) <= set(self.columns) or set(self.columns) <= set(names)):
            raise ValueError(f"neither a part of {self.columns} nor more: {tuple(names)}")
        M = np.array([[name == own for name in names] for own in self.columns], dtype=float)
        return self.transformed(M, names)

    def minus(self, names: Sequence[str], values: Array) -> "Equations":
        """Take off the torque W chi of known parameters: equations in the others alone."""
        known, c = [self.columns.index(name) for name in names], len(self.columns)
        rest, shift = [k for k in range(c) if k not in known], np.zeros(c)
        shift[known] = values
        return self.transformed(np.eye(c)[:, rest], [self.columns[k] for k in rest], shift)

    @property
    def whole(self) -> "Equations":
        """Drop the blocks."""
        return replace(self, blocks=(), block_length=0.0)

    def without_each(self) -> list["Equations"]:
        """Leave out each block in turn; what lies before and after each is merged once for all."""
        check_blocks(len(blocks := self.blocks))
        before = list(accumulate(blocks[:-1], lambda done, block: merged([done, block])))
        after = list(accumulate(blocks[:0:-1], lambda done, block: merged([block, done])))[::-1]
        return [after[0], *map(merged, zip(before[:-1], after[1:], strict=True)), before[-1]]

    def stacked(self, weights: Array | None = None) -> Array:
        """Stack the factors of all joints, k x (c + 1), the rows of joint j times ``weights[j]``."""
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

    @property
    def independent(self) -> float:
        """Fraction of the equations whose noise is independent, mean over the joints."""
        return sum(self.effective_rows) / self.equations

    def joint_weights(self, values: Array) -> Array:
        """Weights of the joints' equations: one over the standard deviation of the error, shape (n,)."""
        rows = np.maximum(np.array(self.rows, dtype=float), 1.0)
        freedom = max(1.0 - len(self.columns) / max(sum(self.effective_rows), 1.0), 1e-3)
        sigma = self.error_norms(values) / np.sqrt(rows * freedom)
        floor = _NOISE_FLOOR * np.linalg.norm(self.torque_norms) / np.sqrt(rows.sum())
        return np.asarray(1.0 / np.maximum(sigma, floor) if floor > 0.0 else np.ones(len(rows)))

    def save(self, path: str | Path) -> None:
        """Write the equations as NPZ, to be merged with others later or elsewhere; the name ends in .npz."""
        content = io.BytesIO()
        np.savez(content, **self.arrays())
        write_bytes(f"{path}" if f"{path}".endswith(".npz") else f"{path}.npz", content.getvalue())

    def arrays(self) -> dict[str, Any]:
        """Arrays that ``save`` writes: rows, columns, factor0 .., and shared<joint>_<motor> as ``shared``."""
        return {
            "columns": np.array(self.columns),
            "rows": self.rows,
            "effective_rows": self.effective_rows,
            **{f"factor{j}": factor for j, factor in enumerate(self.factors)},
            **{f"{SHARED}{joint}_{motor}": torque for (joint, motor), torque in self.shared.items()},
        }

    @staticmethod
    def load(path: str | Path) -> "Equations":
        """Read equations that ``save`` wrote.

        Raises:
            InputError: if the file holds something else.
        """
        try:
            with np.load(path, allow_pickle=False) as data:
                names = [name for name in sorted(data.files) if name.startswith(SHARED)]
                keys = [tuple(map(int, name.removeprefix(SHARED).split("_"))) for name in names]
                return Equations(
                    tuple(map(str, data["columns"])),
                    tuple(data[f"factor{j}"] for j in range(len(data["rows"]))),
                    tuple(map(int, data["rows"])),
                    tuple(map(float, data["effective_rows"])),
                    {(joint, motor): data[name] for (joint, motor), name in zip(keys, names, strict=True)},
                )
        except (OSError, KeyError, ValueError, zipfile.BadZipFile) as error:
            raise InputError(f"{path}: not a saved reduced problem ({error})") from None

    @property
    def equations(self) -> int:
        """Number of equations."""
        return sum(self.rows)

    def condition_numbers(self) -> tuple[float, float]:
        """Condition number of the unweighted W: in SI units, and with columns of norm 1; inf if rank-deficient."""
        return condition_numbers(self.stacked()[:, :-1])

    def by_motor(self) -> tuple[Array, ...]:
        """Split each joint's right-hand side by motors, but for a known spring's torque: per joint k x n."""
        units = np.eye(len(self.factors))
        torques = tuple(np.outer(factor[:, -1], unit) for factor, unit in zip(self.factors, units, strict=True))
        for (joint, motor), torque in self.shared.items():
            torques[joint][:, joint] -= torque
            if motor != NO_MOTOR:
                torques[joint][:, motor] += torque
        return torques


def compressed(rows: Array, extra: int = 0) -> tuple[Array, Array]:
    """R of a QR decomposition, and Q' times some last ``extra`` columns that take no part in it.

    Fewer rows than columns are kept as they are.
    """
    width = rows.shape[1] - extra
    if len(rows) > width:
        # What stands below is of the last columns alone.
        rows = np.triu(lapack.dgeqrf(rows)[0][:width])
    return rows[:, :width], rows[:, width:]


def triangular(rows: Array) -> Array:
    """R of the QR decomposition, of as many rows as columns or fewer."""
    return np.triu(lapack.dgeqrf(rows)[0][: rows.shape[1]]) if len(rows) > 1 else rows


def surely_determined(R: Array) -> bool:
    """True if a triangular matrix has full rank by a bound on its singular values, columns scaled to norm 1."""
    sizes, c = np.linalg.norm(R, axis=0), R.shape[1]
    if len(R) < c or not c or not sizes.all():
        return False
    inverse, singular = lapack.dtrtri(R[:c] / sizes)
    return not singular and float(np.linalg.norm(inverse)) * np.sqrt(c) * RANK_TOLERANCE < 1.0


def checked(factor: Array, columns: tuple[str, ...], rows: int, effective_rows: float) -> Array:
    """Triangular factor of weighted equations [W Y] that determine every parameter; InputError of others."""
    c = len(columns)
    if rows < c:
        few = "fewer samples than parameters; record longer or decimate less"
        raise InputError(f"{rows} equations for {c} parameters: {few}")
    R = triangular(factor)
    if not surely_determined(R[:, :c]) and (undetermined := decomposed(R[:, :c]).null).size:
        weight = np.abs(undetermined).max(axis=1)
        named = ", ".join(name for name, w in zip(columns, weight, strict=True) if w > 0.05)
        left = f"the recorded motion leaves {undetermined.shape[1]} of {c} directions undetermined, in {named}"
        raise InputError(f"{left}: move more joints, faster and over a wider range")
    if effective_rows <= c:
        short = f"{effective_rows:.0f} independent equations for {c} parameters"
        raise InputError(f"the motion is too short ({short}): record 20 s or more")
    return R


def check_blocks(*counts: int) -> None:
    """Refuse so few blocks of time that none can be left out."""
    if min(counts, default=0) < 2:
        raise InputError("robust standard deviations need two blocks of time at least: record longer")


def merged(parts: Iterable[Equations]) -> Equations:
    """Merge the equations of several parts with the same parameters by one more QR. Blocks of all are kept."""
    parts = list(parts)
    first = parts[0]
    if len(parts) == 1:
        return first
    if any(part.columns != first.columns for part in parts):
        raise ValueError("equations with different columns cannot be merged")
    if any(list(part.shared) != list(first.shared) for part in parts):
        raise ValueError("equations of robots with different coupled drives or springs cannot be merged")
    factors, shared = [], dict[tuple[int, int], Array]()
    for j in range(len(first.factors)):
        keys = [key for key in first.shared if key[0] == j]
        rows = np.vstack([np.column_stack([p.factors[j], *(p.shared[key] for key in keys)]) for p in parts])
        factor, others = compressed(rows, len(keys))
        factors.append(factor)
        shared |= zip(keys, others.T, strict=True)
    counts = tuple(np.sum([part.rows for part in parts], axis=0).tolist())
    effective = tuple(np.sum([part.effective_rows for part in parts], axis=0).tolist())
    blocks = tuple(chain.from_iterable(p.blocks for p in parts)) if all(p.blocks for p in parts) else ()
    length = max(part.block_length for part in parts)
    return Equations(first.columns, tuple(factors), counts, effective, shared, blocks, length)
