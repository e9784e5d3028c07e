"""Whether the torques of the loaded recordings have a scale of their own.

One more column of method 4. All of it is in the joints' triangular factors, so that no row is read again; beside a
robot that is known and in a short motion, states thinned to 10 Hz do.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model.names import FRICTION, parameter_kind
from ..equations.equations import PAYLOAD, Equations
from ..equations.leave_one_out import WithoutEach
from ..fit.robust import jackknifed
from ..payload.problem import PayloadProblem
from .thinned import Thinned

SCALE, SCALE_Z = 0.01, 4.0
"""Difference of the loaded torques' scale from 1, and its standard deviations, above which it is another one."""
JOINT_SCALE, JOINT_SCALE_Z = 0.05, 5.0
"""The same of one joint's torque alone."""
_Block = tuple[Equations | None, Equations | None]


class Scale(NamedTuple):
    """Scale of the loaded torques over that of the unloaded ones.

    ``joint``: whose, 0 for all; ``ratio`` with its standard deviation ``sigma``; ``mass``: the payload's on one
    scale [kg]; ``effect``: by how much more the mass is by torques on a scale of 2 [kg].
    """

    joint: int
    ratio: float
    sigma: float
    mass: float
    effect: float = 0.0

    @property
    def z(self) -> float:
        """Standard deviations by which the ratio differs from 1."""
        return (self.ratio - 1.0) / max(self.sigma, 1e-300)


def scales(problem: PayloadProblem, weights: Array) -> tuple[Scale, ...]:
    """Scales of the loaded torques: of all together, and of joints that differ from 1 by more than a trifle.

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
    outstanding = [
        k
        for k, (value, sigma, (least, z)) in enumerate(zip(values[0], formula, limits, strict=True))
        if abs(value) > least and abs(value) > z * sigma
    ]
    robust = _robust(problem, question, gram, values[0]) if outstanding else formula
    if robust is None:
        return ()
    return tuple(
        Scale(k, 1.0 + float(values[0, k]), max(float(robust[k]), float(formula[k])), *map(float, values[1:, k]))
        for k in sorted({0, *outstanding})
    )


def scales_of_states(system: Thinned | None) -> tuple[Scale, ...]:
    """Scales of the loaded torques by thinned states, friction of the loaded rows free.

    Beside a robot known from earlier, or in a short motion, whose equations are not all there.
    """
    if system is None:
        return ()
    rigid = [k for k, name in enumerate(system.names) if parameter_kind(name) not in FRICTION]
    along = np.einsum("jcn,c->jn", system.columns[:, rigid], system.values[rigid]) * system.states.loaded
    alone = np.eye(len(along))[:, :, None] * along[:, None]
    pulls, free = np.array(system.pulls), range(system.payload.stop, len(system.pulls))
    pulls[free, free] = 0.0
    question = replace(system, pulls=pulls).with_columns(np.concatenate([along[:, None], alone], axis=1))
    scales = []
    for joint in range(len(along) + 1):
        answer = question.of(joint)
        value, sigma = float(answer.values[0]), float(np.sqrt(answer.covariance[0, 0]))
        plain, effect = float(question.shares[9, -1]), float(answer.effect[9, 0])
        scales.append(Scale(joint, 1.0 + value, sigma, (plain + effect * value) / (1.0 + value), plain - effect))
    return tuple(scales)


def _robust(problem: PayloadProblem, question: "_Question", gram: Array, values: Array) -> Array | None:
    """Standard deviations of the scales by leaving out blocks of time; None with fewer than two."""
    left = [
        np.array([question.answers(gram - question.gram(bare, heavy), 1.0)[0][0] for bare, heavy in group])
        for group in _blocks(problem)
    ]
    if min(map(len, left), default=0) < 2:
        return None
    return jackknifed(left, values, problem.loaded.block_length).sigma


def _blocks(problem: PayloadProblem) -> list[list[_Block]]:
    """Rows of each block of time, without and with payload, in groups of blocks; those of one motion together."""
    assert problem.unloaded is not None
    heavy = _parts(problem.loaded)
    bare = _parts(problem.unloaded)
    if problem.paired:
        return [list(zip(bare, heavy, strict=True))]
    groups: list[list[_Block]] = [[(None, part) for part in heavy], [(part, None) for part in bare]]
    return [group for group in groups if group]


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
        """Scale less 1, mass on one scale, what a scale of 2 adds to it, 3 x (n + 1); the formula's sigma."""
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
    return np.array([value, weighed, solved[mass, :-1] + solved[mass, -1]]), sigma


def _inverse(gram: Array) -> Array:
    """Inverse of a Gram matrix whose columns are scaled to norm 1 first."""
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    return np.asarray(np.linalg.pinv(gram / np.outer(size, size), 1e-13, hermitian=True) / np.outer(size, size))
