"""Torque limits of a slow run on the way of a fast one, in the fast one's samples.

What dynamic forces help to lift has to be held without them: a limit may be active in the slow run alone.
"""

from dataclasses import replace

import numpy as np

from ...common.arrays import Array
from ..motions.samples import Samples
from .information import RegressorKernel
from .limits import Limit, State


def slow_limit(kernel: RegressorKernel, limit: Limit, speed: float) -> Limit:
    """A torque limit at a fraction of the speed: speeds shrink by it, accelerations by its square."""
    run = _SlowRun(kernel, limit, speed)
    name = f"{limit.name} at {100.0 * speed:g} % of the speed"
    return replace(limit, name=name, values=run.values, pullback=run.pullback)


class _SlowRun:
    """Values of a limit in the slow run, and their slopes in the fast one."""

    def __init__(self, kernel: RegressorKernel, limit: Limit, speed: float) -> None:
        """Nothing is known of any state yet."""
        self._kernel, self._limit, self._speed = kernel, limit, speed
        self._last: tuple[State, State] | None = None

    def values(self, state: State) -> Array:
        """Rows per sample, as of the limit itself."""
        return self._limit.values(self._slowed(state))

    def pullback(self, state: State, slope: Array, into: State) -> None:
        """Through the slow run's regressor to the fast one's states."""
        slow = self._slowed(state)
        slopes = State(Samples.zeros(slow.samples), np.zeros_like(slow.entries))
        self._limit.pullback(slow, slope, slopes)
        by_state = self._kernel.state_slope(slow.samples, slow.width, slopes.entries)
        for part, by, power in zip(into.samples[1:], by_state, (0, 1, 2), strict=True):
            part += self._speed**power * by

    def _slowed(self, state: State) -> State:
        """The slow run; kept until another state comes, for slopes follow values."""
        if self._last is None or self._last[0] is not state:
            weight, q, qd, qdd = state.samples
            width = self._speed * state.width
            slow = Samples(weight / self._speed, q, self._speed * qd, self._speed**2 * qdd)
            self._last = state, State(slow, self._kernel.entries(slow, width), width)
        return self._last[1]
