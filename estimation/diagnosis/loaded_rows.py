"""What the loaded recordings show beside their payload: a scale of their own, and short bursts of other torques.

Both ask method 4 one more question. All of it is in the joints' triangular factors, so that no row is read again.
"""

from collections.abc import Sequence
from itertools import compress
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model.names import parameter_kind
from ..equations.equations import PAYLOAD, Equations, WithoutEach
from ..fit.robust import jackknifed
from ..payload.loaded_scale import FRICTION
from ..payload.problem import PayloadProblem
from ..payload.result import in_payload_frame

SCALE, SCALE_Z = 0.01, 4.0
"""Difference of the loaded torques' scale from 1, and its standard deviations, above which it is another one."""
JOINT_SCALE, JOINT_SCALE_Z = 0.05, 5.0
"""The same of one joint's torque alone."""
BURST = 3.0
"""Mean squared residual of a stretch over their median, above which the stretch is left out."""
_Block = tuple[Equations | None, Equations | None]


class Scale(NamedTuple):
    """Scale of the loaded torques over that of the unloaded ones.

    ``joint``: whose, 0 for all; ``ratio`` with its standard deviation ``sigma``; ``mass``: the payload's on one
    scale [kg].
    """

    joint: int
    ratio: float
    sigma: float
    mass: float

    @property
    def z(self) -> float:
        """Standard deviations by which the ratio differs from 1."""
        return (self.ratio - 1.0) / max(self.sigma, 1e-300)


class Bursts(NamedTuple):
    """Stretches of time whose residuals stand out.

    ``many`` of ``blocks`` of at least ``length`` [s]; ``change``: of the payload's ten without them, in its
    frame, (10,).
    """

    many: int
    blocks: int
    length: float
    change: Array


def scales(problem: PayloadProblem, weights: Array) -> tuple[Scale, ...]:
    """Scales of the loaded torques, all together and joint by joint, that differ from 1 by more than a trifle.

    One more column in the loaded rows: the rigid part of what the robot alone needs. Friction and offsets of those
    rows are free, for they may have changed. Standard deviations leave out one block of time after another; they
    are computed only for what differs from 1 by more than the formula's allow.

    Args:
        problem: with recordings without payload, else nothing is known of a scale, and one that is not free.
        weights: of the joints.
    """
    if problem.scale is not None or problem.bare is None or not problem.loaded.leave_one_out:
        return ()
    assert problem.unloaded is not None
    question = _Question(problem.unloaded.columns, problem.robot.n, problem.bare.values, weights)
    gram = question.gram(problem.unloaded, problem.loaded)
    spare = sum(problem.unloaded.effective_rows) + sum(problem.loaded.effective_rows) - question.unknown - 1
    values, formula = question.answers(gram, max(spare, 1.0))
    limits = [(SCALE, SCALE_Z), *[(JOINT_SCALE, JOINT_SCALE_Z)] * problem.robot.n]
    told = [
        k
        for k, (value, sigma, (least, z)) in enumerate(zip(values[0], formula, limits, strict=True))
        if abs(value) > least and abs(value) > z * sigma
    ]
    if not told:
        return ()
    robust = _robust(problem, question, gram, values[0])
    if robust is None:
        return ()
    return tuple(
        Scale(k, 1.0 + float(values[0, k]), max(float(robust[k]), float(formula[k])), float(values[1, k]))
        for k in told
    )


def _robust(problem: PayloadProblem, question: "_Question", gram: Array, values: Array) -> Array | None:
    """Standard deviations of the scales by leaving out blocks of time; None with fewer than two."""
    left = [
        np.array([question.answers(gram - question.gram(bare, heavy), 1.0)[0][0] for bare, heavy in group])
        for group in _blocks(problem)
    ]
    if min(map(len, left), default=0) < 2:
        return None
    return jackknifed(left, values, problem.loaded.block_length).sigma


def bursts(problem: PayloadProblem, weights: Array) -> Bursts | None:
    """Stretches whose mean squared residual is over 3 times the median, and what the payload is without them.

    None where there are none, or more than half.
    """
    if problem.unloaded is None or not problem.loaded.leave_one_out:
        return None
    loaded = in_payload_frame(problem.robot, problem.loaded)
    columns = len(loaded.columns)
    whole = _gram(problem.unloaded, loaded, weights, columns)
    values = _inverse(whole[:-1, :-1]) @ whole[:-1, -1]
    error = np.append(-values, 1.0)
    blocks, high = 0, list[Array]()
    for group in _blocks(problem):
        grams = [
            _gram(bare, heavy and in_payload_frame(problem.robot, heavy), weights, columns) for bare, heavy in group
        ]
        means = np.array(
            [error @ gram @ error / max(_rows(block), 1) for gram, block in zip(grams, group, strict=True)]
        )
        high += list(compress(grams, means > BURST * np.median(means)))
        blocks += len(grams)
    if not high or 2 * len(high) > blocks:
        return None
    rest = whole - np.sum(high, axis=0)
    change = _inverse(rest[:-1, :-1]) @ rest[:-1, -1] - values
    return Bursts(len(high), blocks, problem.loaded.block_length, change[-len(PAYLOAD) :])


def _blocks(problem: PayloadProblem) -> list[list[_Block]]:
    """Rows of each block of time, without and with payload, in groups of blocks; those of one motion together."""
    assert problem.unloaded is not None
    heavy = _parts(problem.loaded)
    bare = _parts(problem.unloaded)
    if problem.paired:
        return [list(zip(bare, heavy, strict=True))]
    groups: list[list[_Block]] = [[(None, part) for part in heavy], [(part, None) for part in bare]]
    return [group for group in groups if group]


def _rows(block: _Block) -> int:
    return sum(part.equations for part in block if part is not None)


def _parts(equations: Equations) -> Sequence[Equations]:
    cut = equations.leave_one_out
    return cut.blocks if isinstance(cut, WithoutEach) else ()


class _Question(NamedTuple):
    """Method 4 with friction of its own in the loaded rows, and one more column for each scale.

    ``base``: the robot's columns; ``n``: number of joints; ``robot``: its parameters; ``weights`` of the joints.
    """

    base: tuple[str, ...]
    n: int
    robot: Array
    weights: Array

    @property
    def moved(self) -> list[int]:
        """Places of friction and offsets."""
        return [k for k, name in enumerate(self.base) if parameter_kind(name) in FRICTION]

    @property
    def unknown(self) -> int:
        """Number of columns before those of the scales."""
        return len(self.base) + len(PAYLOAD) + len(self.moved)

    def gram(self, bare: Equations | None, heavy: Equations | None) -> Array:
        """Gram matrix of all columns and the torque, the scales' columns last but one: all joints, then each."""
        b, c, size = len(self.base), len(self.base) + len(PAYLOAD), self.unknown + self.n + 2
        rigid = [k for k in range(b) if k not in self.moved]
        gram = np.zeros((size, size))
        for j, weight in enumerate(self.weights):
            if bare is not None:
                own = weight * bare.factors[j]
                gram[np.ix_([*range(b), -1], [*range(b), -1])] += own.T @ own
            if heavy is not None:
                factor = weight * heavy.factors[j]
                rows = np.zeros((len(factor), size))
                places = [*rigid, *range(b, c), -1]
                rows[:, places] = factor[:, places]
                rows[:, c : self.unknown] = factor[:, self.moved]
                along = factor[:, rigid] @ self.robot[rigid]
                rows[:, self.unknown] = rows[:, self.unknown + 1 + j] = along
                gram += rows.T @ rows
        return gram

    def answers(self, gram: Array, spare: float) -> tuple[Array, Array]:
        """Scale less 1, and mass on one scale, 2 x (n + 1); the formula's sigma of the scales, (n + 1,)."""
        return _one_by_one(gram, self.unknown, len(self.base) + len(PAYLOAD) - 1, spare)


def _one_by_one(gram: Array, unknown: int, mass: int, spare: float) -> tuple[Array, Array]:
    """Coefficient of each column between the unknown ones and the last, alone; the mass scaled back; its sigma."""
    inverse = _inverse(gram[:unknown, :unknown])
    solved = inverse @ gram[:unknown, unknown:]
    rest = gram[unknown:, unknown:] - gram[:unknown, unknown:].T @ solved
    size, along = np.diag(rest)[:-1], rest[:-1, -1]
    there = size > 1e-9 * np.diag(gram)[unknown:-1]
    value = np.where(there, along / np.where(there, size, 1.0), 0.0)
    left = np.maximum(rest[-1, -1] - value * along, 0.0)
    sigma = np.where(there, np.sqrt(left / spare / np.where(there, size, 1.0)), np.inf)
    weighed = (solved[mass, -1] - value * solved[mass, :-1]) / (1.0 + value)
    return np.array([value, weighed]), sigma


def _gram(bare: Equations | None, heavy: Equations | None, weights: Array, columns: int) -> Array:
    """Gram matrix of method 4's columns, the robot's first, and the torque."""
    gram = np.zeros((columns + 1, columns + 1))
    for j, weight in enumerate(weights):
        if bare is not None:
            own, places = weight * bare.factors[j], [*range(len(bare.columns)), columns]
            gram[np.ix_(places, places)] += own.T @ own
        if heavy is not None:
            factor = weight * heavy.factors[j]
            gram += factor.T @ factor
    return gram


def _inverse(gram: Array) -> Array:
    """Inverse of a Gram matrix whose columns are scaled to norm 1 first."""
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    return np.asarray(np.linalg.pinv(gram / np.outer(size, size), 1e-13, hermitian=True) / np.outer(size, size))
