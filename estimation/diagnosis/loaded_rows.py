"""What the loaded recordings show beside their payload: a scale of their own, and short bursts of other torques.

Both ask method 4 one more question. All of it is in the joints' triangular factors, so that no row is read again.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model.names import parameter_kind
from ..equations.equations import PAYLOAD, Equations
from ..fit.robust import jackknife
from ..payload.methods import FRICTION
from ..payload.problem import PayloadProblem
from ..payload.result import in_payload_frame

SCALE, SCALE_Z = 0.01, 4.0
"""Difference of the loaded torques' scale from 1, and its standard deviations, above which it is another one."""
JOINT_SCALE, JOINT_SCALE_Z = 0.05, 5.0
"""The same of one joint's torque alone."""
BURST = 3.0
"""Mean squared residual of a stretch over their median, above which the stretch is left out."""


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

    ``many`` of ``blocks`` of at least ``length`` [s]; ``mass``: the payload's without them [kg]; ``change``: of its
    ten parameters in the payload's frame, (10,).
    """

    many: int
    blocks: int
    length: float
    mass: float
    change: Array


def scales(problem: PayloadProblem, weights: Array) -> tuple[Scale, ...]:
    """Scales of the loaded torques, all together and joint by joint, that differ from 1 by more than a trifle.

    One more column in the loaded rows: the rigid part of what the robot alone needs. Friction and offsets of those
    rows are free, for they may have changed. Standard deviations leave out one block of time after another; they
    are computed only for what differs from 1 by more than the formula's allow.

    Args:
        problem: with recordings without payload; else nothing is known of a scale.
        weights: of the joints.
    """
    if problem.unloaded is None or problem.bare is None or not problem.loaded.leave_one_out:
        return ()
    robot = problem.bare.values
    values, formula = _scales(problem, robot, weights)
    limits = [(SCALE, SCALE_Z), *[(JOINT_SCALE, JOINT_SCALE_Z)] * problem.robot.n]
    told = [
        k
        for k, (value, sigma, (least, z)) in enumerate(zip(values[0], formula, limits, strict=True))
        if abs(value) > least and abs(value) > z * sigma
    ]
    if not told:
        return ()
    try:
        robust = jackknife(
            lambda part: _scales(part, robot, weights)[0][0],
            problem.without_blocks,
            values[0],
            problem.loaded.block_length,
        )
    except InputError:  # too few blocks to know
        return ()
    return tuple(
        Scale(k, 1.0 + float(values[0, k]), max(float(robust.sigma[k]), float(formula[k])), float(values[1, k]))
        for k in told
    )


def bursts(problem: PayloadProblem, weights: Array) -> Bursts | None:
    """Stretches whose mean squared residual is over 3 times the median, and the payload without them.

    None where there are none, or where their equations do not determine the payload.
    """
    if problem.unloaded is None or not problem.loaded.leave_one_out:
        return None
    groups = problem.without_blocks
    whole = _gram(problem, weights)
    ten, values = _payload(whole)
    squares = _squares(problem, values, weights)
    count, blocks, rest = 0, 0, whole.copy()
    for group in groups:
        left = np.array([_squares(part, values, weights) for part in group])
        means = (squares[0] - left[:, 0]) / np.maximum(squares[1] - left[:, 1], 1.0)
        high = np.flatnonzero(means > BURST * np.median(means))
        blocks, count = blocks + len(means), count + len(high)
        for k in high:
            rest -= whole - _gram(group[k], weights)
    if not count or 2 * count > blocks:
        return None
    without, _ = _payload(rest)
    return Bursts(count, blocks, problem.loaded.block_length, float(without[9]), without - ten)


def _scales(problem: PayloadProblem, robot: Array, weights: Array) -> tuple[Array, Array]:
    """Scale less 1 and mass for all joints, then each, 2 x (n + 1); formula's sigma of the scales, (n + 1,)."""
    assert problem.unloaded is not None
    base, n = problem.unloaded.columns, problem.robot.n
    moved = [k for k, name in enumerate(base) if parameter_kind(name) in FRICTION]
    rigid = [k for k in range(len(base)) if k not in moved]
    c, own = len(base) + len(PAYLOAD), len(moved)
    size = c + own + n + 2  # the scales of all joints and of each, and the torque
    gram = np.zeros((size, size))
    for j, (bare, heavy, weight) in enumerate(
        zip(problem.unloaded.factors, problem.loaded.factors, weights, strict=True)
    ):
        rows = np.zeros((len(bare) + len(heavy), size))
        rows[: len(bare), [*range(len(base)), -1]] = bare
        below = rows[len(bare) :]
        below[:, [*rigid, *range(len(base), c), -1]] = heavy[:, [*rigid, *range(len(base), c), -1]]
        below[:, c : c + own] = heavy[:, moved]
        below[:, c + own] = below[:, c + own + 1 + j] = heavy[:, rigid] @ robot[rigid]
        gram += weight**2 * rows.T @ rows
    spare = sum(problem.unloaded.effective_rows) + sum(problem.loaded.effective_rows) - c - own - 1
    return _one_by_one(gram, c + own, len(base) + len(PAYLOAD) - 1, max(spare, 1.0))


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


def _gram(problem: PayloadProblem, weights: Array) -> Array:
    """Gram matrix of method 4's columns and the torque, the payload in its own frame."""
    assert problem.unloaded is not None
    heavy = in_payload_frame(problem.robot, problem.loaded)
    base, whole = len(problem.unloaded.columns), len(heavy.columns) + 1
    gram = np.zeros((whole, whole))
    bare = np.ix_([*range(base), whole - 1], [*range(base), whole - 1])
    for own, other, weight in zip(problem.unloaded.factors, heavy.factors, weights, strict=True):
        gram[bare] += weight**2 * own.T @ own
        gram += weight**2 * other.T @ other
    return gram


def _payload(gram: Array) -> tuple[Array, Array]:
    """The payload's ten, and all values of method 4."""
    values = _inverse(gram[:-1, :-1]) @ gram[:-1, -1]
    return values[-len(PAYLOAD) :], values


def _squares(problem: PayloadProblem, values: Array, weights: Array) -> Array:
    """Sum of the weighted squared residuals of method 4, and the number of equations."""
    assert problem.unloaded is not None
    heavy = in_payload_frame(problem.robot, problem.loaded)
    parts: Sequence[tuple[Equations, Array]] = (
        (problem.unloaded, values[: len(problem.unloaded.columns)]),
        (heavy, values),
    )
    total = sum(float(np.sum((weights * part.error_norms(x)) ** 2)) for part, x in parts)
    return np.array([total, float(sum(part.equations for part, _ in parts))])


def _inverse(gram: Array) -> Array:
    """Inverse of a Gram matrix whose columns are scaled to norm 1 first."""
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    return np.asarray(np.linalg.pinv(gram / np.outer(size, size), 1e-13, hermitian=True) / np.outer(size, size))
