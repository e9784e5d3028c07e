"""How far a joint's constant torque may change from one recording to the next.

Left wholly free, it takes the weight of a payload for itself where gravity hardly varies, as in ten seconds of a
slow arm. It is what dry friction differs by from one direction to the other, so that its change is a share of that
friction, which the recording without payload shows. It enters as one more equation for each joint of the arm, and
what the change may be widens the intervals; where the recordings say that it changed more, it is free.
"""

from collections.abc import Sequence

import numpy as np

from ...common.arrays import Array
from ...common.linear import least_squares
from ..equations.correlation import autocorrelation_time
from ..equations.names import PAYLOAD
from ..equations.observation import Observation
from ..equations.problem import ReducedProblem, merged
from ..equations.reduction import reduced
from ..fit.least_squares import joint_weights
from .run import HeldOffsets, free_offsets, friction_free, observed_friction_free

OFFSET_SHARE = 0.033
"""Of a joint's Coulomb friction: standard deviation of the change between two recordings.

Measured without any payload (benchmarks/constant_torques.py): constant torques of the UR10e's joints 1 to 3
scatter by 2.3 % of it from 10 s to 10 s beyond their noise (90 % interval 1.1 to 4.1 %); the difference of two by
sqrt(2) more.
"""
_WRIST = 3
"""Last joints, always free: their constant torque shifts the centre of mass, and the TX40's scatter by 17 %."""
_CONTRADICTED = 1e-3
"""Probability of what the recordings say, below which the constant torques are free."""


def held_offsets(observations: Sequence[Observation], coulomb: Array) -> HeldOffsets:
    """The equations that hold constant torques near zero; none where the recordings contradict them.

    An equation counts as much as the joint's noise and its memory allow.

    Args:
        observations: with the columns of ``run_observer``.
        coulomb: Coulomb friction of each joint without payload [N·m or N], shape (n,); 0 where it is not known: the
            joint's constant torque is free then.
    """
    plain = [observed_friction_free(recording) for recording in observations]
    problem = merged(reduced(recording) for recording in plain).select(PAYLOAD)
    weights = joint_weights(problem, _shortest(problem, np.ones(len(coulomb)))[0])
    values, _ = _shortest(problem, weights)
    noise = problem.error_norms(values) / np.sqrt(np.maximum(problem.rows, 1))
    weighty = noise * np.sqrt([_inflation(plain, values, j) for j in range(len(noise))])
    sigma = np.where(np.array(problem.rows) > 0, OFFSET_SHARE * coulomb, 0.0)
    sigma[max(len(noise) - _WRIST, 1) :] = 0.0
    stiffness = np.divide(weighty, sigma, out=np.zeros_like(noise), where=sigma > 0.0)
    held = HeldOffsets(sigma, stiffness)
    whole = [reduced(recording) for recording in observations]
    bound = merged(friction_free(one, held) for one in whole).select(PAYLOAD)
    each = np.divide(1.0, weighty, out=np.zeros_like(noise), where=weighty > 0.0)
    rise = _shortest(bound, each)[1] - _shortest(problem, each)[1]
    return free_offsets(len(noise)) if _unlikely(rise, len(held.joints)) else held


def _unlikely(rise: float, joints: int) -> bool:
    from scipy.special import chdtrc

    return joints > 0 and bool(chdtrc(joints, max(rise, 0.0)) < _CONTRADICTED)


def _inflation(recordings: Sequence[Observation], values: Array, joint: int) -> float:
    """By how much the memory of a joint's errors raises the variance of their mean."""
    series = [(one.t[joint], one.errors(values)[joint]) for one in recordings if len(one.t[joint]) > 1]
    if not series:
        return 1.0
    step = min(float(np.diff(t).min()) for t, _ in series)
    return max(1.0, 2.0 * autocorrelation_time(series, step) / step)


def _shortest(problem: ReducedProblem, weights: Array) -> tuple[Array, float]:
    """Shortest least-squares solution, of which the residual alone is used, and its sum of squares."""
    factor = problem.stacked(weights)
    values = least_squares(factor[:, :-1], factor[:, -1])
    return values, float(np.sum((factor[:, -1] - factor[:, :-1] @ values) ** 2))
