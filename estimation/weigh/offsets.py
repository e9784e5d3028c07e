"""How far a joint's constant torque may change from one recording to the next.

Left wholly free, it takes the weight of a payload for itself where gravity hardly varies, as in ten seconds of a
slow arm. Within a session it changes little, which enters as one more equation for each joint of the arm; where the
recordings say that it changed more, it is free.
"""

from collections.abc import Sequence

import numpy as np

from ...model.arrays import Array
from ..correlation import autocorrelation_time
from ..least_squares import joint_weights
from ..names import PAYLOAD
from ..observation import Observation
from ..problem import ReducedProblem, merged
from ..reduction import reduced
from .run import friction_free, observed_friction_free

SHARE = 0.01
"""Of a joint's torque (rms): standard deviation of the change. The real UR10e's joints show at most 0.9 %, the
large ones 0.3 %; Coulomb friction changes by up to 4 % and stays free."""
_WRIST = 3
"""Last joints, always free: their constant torque shifts the centre of mass, and their torques are small."""
_CONTRADICTED = 1e-3
"""Probability of what the recordings say, below which the constant torques are free."""


def offset_stiffness(observations: Sequence[Observation], torque_rms: Array) -> Array:
    """Weights of the equations that hold constant torques near zero, in units of the rows, shape (n,).

    An equation counts as much as the joint's noise and its memory allow. All zero where the recordings contradict.

    Args:
        observations: with the columns of ``run_observer``.
        torque_rms: root mean square of each joint's torque [N·m or N], shape (n,); 0 for held joints.
    """
    plain = [observed_friction_free(recording) for recording in observations]
    problem = merged(reduced(recording) for recording in plain).select(PAYLOAD)
    weights = joint_weights(problem, _shortest(problem, np.ones(len(torque_rms)))[0])
    values, _ = _shortest(problem, weights)
    noise = problem.error_norms(values) / np.sqrt(np.maximum(problem.rows, 1))
    noise = noise * np.sqrt([_inflation(plain, values, j) for j in range(len(noise))])
    stiffness = np.divide(noise, SHARE * torque_rms, out=np.zeros_like(noise), where=torque_rms > 0.0)
    stiffness[max(len(noise) - _WRIST, 1) :] = 0.0
    whole = [reduced(recording) for recording in observations]
    held = merged(friction_free(one, stiffness) for one in whole).select(PAYLOAD)
    each = np.divide(1.0, noise, out=np.zeros_like(noise), where=noise > 0.0)
    rise = _shortest(held, each)[1] - _shortest(problem, each)[1]
    return np.zeros_like(stiffness) if _unlikely(rise, int((stiffness > 0.0).sum())) else stiffness


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
    scale = np.linalg.norm(factor[:, :-1], axis=0)
    scale[scale == 0.0] = 1.0
    values = np.linalg.lstsq(factor[:, :-1] / scale, factor[:, -1], rcond=1e-10)[0] / scale
    return np.asarray(values), float(np.sum((factor[:, -1] - factor[:, :-1] @ values) ** 2))
