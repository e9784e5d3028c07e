"""Floor of a criterion: how small it can get within the limits if a motion could be in any state at any time.

A motion visits states (q, qd, qdd) and its information matrix is a weighted mean over them. The best weighted set
of states within the limits, continuity ignored, is an optimal experimental design; no motion is better. States and
weights are optimised together from random ones, so that the floor is an estimate: the least that was found.
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...common.arrays import Array
from ..motions.family import Clear, JointBounds, Plan, Samples, everywhere
from .criterion import CRITERIA
from .descent import FINE_WIDTH, WIDTH, Lagrangian, by_steps
from .problem import DesignProblem
from .score import score_samples

_STIFFNESS, _MARGIN = 10.0, 1e-3
_ITERATIONS = 200  # of a round
_TRIES = 100  # to find a pose that is clear


class FreeStates:
    """A family whose members are weighted sets of states, each within the joints' limits by itself.

    x holds q, qd and qdd of each state over their limits, then the logs of the weights.
    """

    def __init__(self, bounds: JointBounds, count: int) -> None:
        """Draw ``count`` states that share one second."""
        self._bounds, self.reach, self._shape = bounds, (bounds.low, bounds.high), (3, count, len(bounds.low))
        self._linear = 3 * count * len(bounds.low)
        self.size = self._linear + count
        self.low, self.high = -np.ones(self.size), np.ones(self.size)
        self.low[self._linear :], self.high[self._linear :] = -8.0, 8.0

    def random(self, draw: np.random.Generator, clear: Clear = everywhere) -> Array:
        """Draw random poses; speeds and accelerations mostly large."""
        x = np.zeros(self.size)
        states = x[: self._linear].reshape(self._shape)
        states[...] = draw.uniform(-1.0, 1.0, states.shape)
        states[1:] = np.sign(states[1:]) * np.sqrt(np.abs(states[1:]))
        for pose in states[0]:
            for _ in range(_TRIES):
                if clear((self._bounds.middle + self._bounds.half * pose)[None]):
                    break
                pose[...] = draw.uniform(-1.0, 1.0, len(pose))
        return x

    def sample(self, x: Array, finer: int = 1) -> Samples:
        """Take the states; there is nothing between them."""
        q, qd, qdd = x[: self._linear].reshape(self._shape)
        b = self._bounds
        return Samples(self._weight(x), b.middle + b.half * q, b.speed * qd, b.acceleration * qdd)

    def pullback(self, x: Array, slope: Samples) -> Array:
        """Apply the Jacobian transposed to the slopes."""
        b, w = self._bounds, self._weight(x)
        states = np.stack([slope.q * b.half, slope.qd * b.speed, slope.qdd * b.acceleration])
        by_weight = w * (slope.weight - w @ slope.weight)
        return np.concatenate([states.ravel(), by_weight])

    def plan(self, x: Array) -> Plan:
        """Refuse a plan: states without order are no motion."""
        raise TypeError("a set of states is no motion")

    def eased(self, x: Array, slower: float, smaller: float) -> Array:
        """Keep states as they are: each keeps its limits by itself."""
        return x

    def _weight(self, x: Array) -> Array:
        logs = x[self._linear :]
        weight = np.exp(logs - logs.max())
        return np.asarray(weight / weight.sum())


@dataclass(frozen=True)
class Floor:
    """Least value of a criterion that was found over weighted states within the limits.

    Attributes:
        value: of the criterion, as in ``Score.value``.
        gap: value of the design less the floor's: for condition numbers the log of their ratio; for "a" the log of
            the ratio of standard deviations; for "d" twice that, as a geometric mean over the parameters.
    """

    value: float
    gap: float
    states: int


def floor_under(
    problem: DesignProblem, reached: float, *, states: int = 0, seed: int = 0, effort: int = 3
) -> Floor:
    """Estimate the floor under any motion's criterion, all limits of single states kept.

    Args:
        problem: whose criterion and limits count.
        reached: value of the motion's criterion, as in ``Score.value``.
        states: number of states; 0 for three for each parameter.
        effort: rounds of 200 iterations at the surrogate's last order.
    """
    count = states or 3 * len(problem.names)
    family = FreeStates(problem.bounds, count)
    further_limits = tuple(limit for limit in problem.limits if limit.kind not in ("state", "duration"))
    free = replace(problem, family=family, limits=further_limits)
    x = family.random(np.random.default_rng(seed), problem.clear)
    course = Lagrangian(free, x, _STIFFNESS, _MARGIN)
    orders = CRITERIA[problem.criterion.kind].orders
    plan = [(order, WIDTH) for order in (*orders, *[orders[-1]] * effort)] + [(orders[-1], FINE_WIDTH)]
    for order, width in plan:
        function = partial(free.evaluate, order=order, width=width, limits=course)
        course.x = by_steps(function, course.x, family, _ITERATIONS)
        course.update(width)
    value = score_samples(free, family.sample(course.x)).value
    return Floor(value, reached - value, count)
