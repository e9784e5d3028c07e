"""Coulomb friction of each joint, from the recording without payload alone."""

from collections.abc import Sequence

import numpy as np

from ...common.arrays import Array
from ...common.linear import decomposed
from ...model import Robot, base_parameters
from ...model.motion import Measurement
from ..equations.observation import Observer
from ..equations.problem import ReducedProblem, merged
from ..equations.reduction import reduced
from ..fit.least_squares import joint_weights
from ..signals.rows import Mask

_HIDDEN = 1e-6
"""Share of a friction in undetermined directions above which it is not known."""


def coulomb_friction(robot: Robot, measured: Sequence[Measurement], masks: Sequence[Mask], decimate: int) -> Array:
    """Of each joint [N·m or N], shape (n,); 0 where the motion, or the robot's model, does not show it.

    A short motion leaves much of the robot undetermined; what it leaves has no part in friction.

    Args:
        robot: the robot.
        measured: recordings without payload.
        masks: their rows to be used, N x n.
        decimate: parallel decimation.
    """
    free = robot.with_offsets(True)
    observer = Observer(free, base_parameters(free).columns)
    problem = merged(
        reduced(observer.observe_rows(data, keep, decimate)) for data, keep in zip(measured, masks, strict=True)
    )
    values, hidden = _shown(problem, np.ones(robot.n))
    values, _ = _shown(problem, joint_weights(problem, values))
    levels = np.zeros(robot.n)
    for j in range(robot.n):
        name = f"FS{j + 1}"
        if name in problem.columns and hidden[problem.columns.index(name)] < _HIDDEN:
            levels[j] = max(values[problem.columns.index(name)], 0.0)
    return levels


def _shown(problem: ReducedProblem, weights: Array) -> tuple[Array, Array]:
    """Shortest least-squares solution, and the share of each value in undetermined directions."""
    factor = problem.stacked(weights)
    parts = decomposed(factor[:, :-1])
    return parts.solution(factor[:, -1]), parts.hidden
