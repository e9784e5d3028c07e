"""How far a joint's constant torque may change from one recording to the next.

Left wholly free, it takes the weight of a payload for itself where gravity hardly varies, as in ten seconds of a
slow arm. It is what dry friction differs by from one direction to the other, so that its change is a share of that
friction, which the recording without payload shows. It enters as one more equation for each joint of the arm, and
what the change may be widens the intervals; where the recordings say that it changed more, it is free.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...common.arrays import Array
from ...common.linear import decomposed, least_squares
from ...model import Processing, Robot, base_parameters
from ...model.motion import Measurement
from ..equations.correlation import inflation
from ..equations.equations import PAYLOAD, Anchor, Equations, merged
from ..equations.observation import Observation, Observer
from ..equations.reduction import reduced
from ..fit.least_squares import joint_weights
from ..fit.linear_problem import Known
from ..signals.rows import Mask

FREE = "free "
"""Before the names of what is estimated anew in each recording, beside the payload."""
_HELD = "held "
"""Before the names of what constant torques are held at."""

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
_HIDDEN = 1e-6
"""Share of a friction in undetermined directions above which it is not known."""


@dataclass(frozen=True, eq=False)
class HeldOffsets:
    """Equations that hold the joints' constant torques near zero.

    Attributes:
        sigma: standard deviation of what they may be [N·m or N], shape (n,); 0 where they are free.
        stiffness: weights of the equations, in units of the rows, shape (n,); 0 where there is none.
    """

    sigma: Array
    stiffness: Array

    @cached_property
    def joints(self) -> tuple[int, ...]:
        """Positions of the joints held, from 0."""
        return tuple(int(j) for j in np.flatnonzero(self.stiffness > 0.0))

    @property
    def anchors(self) -> tuple[Anchor, ...]:
        """The equations: each constant torque is what it is held at."""
        return tuple(
            Anchor(f"{FREE}OFF{j + 1}", j, float(self.stiffness[j]), f"{_HELD}OFF{j + 1}") for j in self.joints
        )

    @property
    def known(self) -> Known:
        """What they are held at: zero, as far as sigma says; alike in all recordings, to be safe."""
        k, n = len(self.joints), len(self.sigma)
        lasting = np.diag(self.sigma[list(self.joints)] ** 2)
        names = tuple(anchor.level for anchor in self.anchors)
        return Known(names, np.zeros(k), np.zeros((k, k)), lasting, gain_sensitivity=lambda: np.zeros((k, n)))

    def friction_free(self, equations: Equations) -> Equations:
        """Equations of one recording less all that its constant torques, friction and ripple can explain."""
        return equations.eliminate([name for name in equations.columns if name.startswith(FREE)], self.anchors)


def free_offsets(n: int) -> HeldOffsets:
    """No equations: constant torques are wholly free."""
    return HeldOffsets(np.zeros(n), np.zeros(n))


def held_offsets(observations: Sequence[Observation], coulomb: Array) -> HeldOffsets:
    """The equations that hold constant torques near zero; none where the recordings contradict them.

    An equation counts as much as the joint's noise and its memory allow.

    Args:
        observations: with free columns of each joint.
        coulomb: Coulomb friction of each joint without payload [N·m or N], shape (n,); 0 where it is not known: the
            joint's constant torque is free then.
    """
    plain = [friction_free(recording) for recording in observations]
    problem = merged(reduced(recording) for recording in plain).select(PAYLOAD)
    weights = joint_weights(problem, _shortest(problem, np.ones(len(coulomb)))[0])
    values, _ = _shortest(problem, weights)
    noise = problem.error_norms(values) / np.sqrt(np.maximum(problem.rows, 1))
    series = [[(one.t[j], one.errors(values)[j]) for one in plain] for j in range(len(noise))]
    weighty = noise * np.sqrt([inflation(joint) for joint in series])
    sigma = np.where(np.array(problem.rows) > 0, OFFSET_SHARE * coulomb, 0.0)
    sigma[max(len(noise) - _WRIST, 1) :] = 0.0
    stiffness = np.divide(weighty, sigma, out=np.zeros_like(noise), where=sigma > 0.0)
    held = HeldOffsets(sigma, stiffness)
    whole = [reduced(recording) for recording in observations]
    bound = merged(held.friction_free(one) for one in whole).select(PAYLOAD)
    each = np.divide(1.0, weighty, out=np.zeros_like(noise), where=weighty > 0.0)
    rise = _shortest(bound, each)[1] - _shortest(problem, each)[1]
    return free_offsets(len(noise)) if _unlikely(rise, len(held.joints)) else held


def _unlikely(rise: float, joints: int) -> bool:
    from scipy.special import chdtrc

    return joints > 0 and bool(chdtrc(joints, max(rise, 0.0)) < _CONTRADICTED)


def _shortest(problem: Equations, weights: Array) -> tuple[Array, float]:
    """Shortest least-squares solution, of which the residual alone is used, and its sum of squares."""
    factor = problem.stacked(weights)
    values = least_squares(factor[:, :-1], factor[:, -1])
    return values, float(np.sum((factor[:, -1] - factor[:, :-1] @ values) ** 2))


def friction_free(recording: Observation) -> Observation:
    """Equations held whole less all that the free columns can explain; rows keep their times."""
    return recording.eliminate([name for name in recording.columns if name.startswith(FREE)])


def coulomb_friction(
    robot: Robot, measured: Sequence[Measurement], masks: Sequence[Mask], processing: Processing
) -> Array:
    """Of each joint [N·m or N], shape (n,); 0 where the motion, or the robot's model, does not show it.

    A short motion leaves much of the robot undetermined; what it leaves has no part in friction.

    Args:
        robot: the robot.
        measured: recordings without payload.
        masks: their rows to be used, N x n.
        processing: settings.
    """
    free = robot.with_offsets(True)
    observer = Observer(free, base_parameters(free).columns)
    problem = merged(
        reduced(observer.observe_rows(data, keep, processing.thinning(data.motion.rate)))
        for data, keep in zip(measured, masks, strict=True)
    )
    values, hidden = _shown(problem, np.ones(robot.n))
    values, _ = _shown(problem, joint_weights(problem, values))
    levels = np.zeros(robot.n)
    for j in range(robot.n):
        name = f"FS{j + 1}"
        if name in problem.columns and hidden[problem.columns.index(name)] < _HIDDEN:
            levels[j] = max(values[problem.columns.index(name)], 0.0)
    return levels


def _shown(problem: Equations, weights: Array) -> tuple[Array, Array]:
    """Shortest least-squares solution, and the share of each value in undetermined directions."""
    factor = problem.stacked(weights)
    parts = decomposed(factor[:, :-1])
    return parts.solution(factor[:, -1]), parts.hidden
