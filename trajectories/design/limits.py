"""Limits of a motion as numbers that must stay within an interval, with their slopes.

Every limit is written as low <= y(x) <= high with y of the order of 1: the two-sided form of g(x) <= 0. Slopes in
y are pulled back to the states and, for torques, to the entries of the observation matrix, from where the design's
one adjoint takes them on.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np

from ...common import Array, Brief, Document
from ..motions.family import JointBounds, Samples
from .criterion import RegressorKernel

Penalty = Callable[[Samples, Samples], float]
"""Function that evaluates terms which limits add to a criterion; slopes in the samples are added to the second."""
Pullback = Callable[[Array, Samples], None]
"""Function that adds what a slope in a limit's values means for samples and entries."""


@dataclass(frozen=True, eq=False, repr=False)
class Limit(Brief):
    """Limit of one kind, the interval of each column."""

    kind: Literal["state", "torque", "duration", "clearance"]  # what it takes to know it
    name: str
    labels: tuple[str, ...]  # what each column belongs to ("joint 3")
    low: Array
    high: Array
    middle: Array  # the value in SI units is middle + y * unit
    unit: Array
    # y of a motion, a row per sample, or one for the motion as a whole; and its pullback
    measure: Callable[[Samples], tuple[Array, Pullback]]

    def values(self, state: Samples) -> Array:
        """Evaluate y alone."""
        return self.measure(state)[0]


def joint_labels(n: int) -> tuple[str, ...]:
    """Names of the columns of n joints in messages."""
    return tuple(f"joint {j + 1}" for j in range(n))


def state_limits(bounds: JointBounds, reach: tuple[Array, Array] | None = None) -> tuple[Limit, ...]:
    """Limit position, speed and acceleration of each joint; 1 at the limit.

    ``reach``: lowest and highest positions instead of the bounds' own, each (n,), or (k, n) for k equal parts of
    the samples.
    """
    v, a, limits = bounds.speed, bounds.acceleration, []
    ranges = {"position": reach or (bounds.low, bounds.high), "speed": (-v, v), "acceleration": (-a, a)}
    for index, (name, ends) in enumerate(ranges.items(), start=1):
        low, high = np.atleast_2d(*ends)
        middle, half, unit = 0.5 * (low + high), 0.5 * (high - low), np.ones(low.shape[1])
        measure = partial(_states, index, middle, half)
        # In messages the first part stands for all; each sample is judged by its own.
        labels = joint_labels(len(unit))
        limits.append(Limit("state", name, labels, -unit, unit, middle[0], half[0], measure))
    return tuple(limits)


def _states(index: int, middle: Array, half: Array, state: Samples) -> tuple[Array, Pullback]:
    x = state[index]
    if len(half) > 1:
        middle, half = (np.repeat(parts, len(x) // len(parts), axis=0) for parts in (middle, half))

    def pullback(slope: Array, into: Samples) -> None:
        into[index][...] += slope / half

    return (x - middle) / half, pullback


def torque_limit(kernel: RegressorKernel, chi: Array, torque: Array, load: str = "") -> Limit:
    """Limit the torque of each joint, over its limit (infinite where there is none), tau = W chi, for one load."""
    finite, n = np.isfinite(torque), len(torque)
    unit, high, name = np.where(finite, torque, 1.0), np.where(finite, 1.0, np.inf), f"torque {load}".strip()
    measure = partial(_torques, kernel, chi, unit)
    return Limit("torque", name, joint_labels(n), -high, high, np.zeros(n), unit, measure)


def _torques(kernel: RegressorKernel, chi: Array, unit: Array, state: Samples) -> tuple[Array, Pullback]:
    def pullback(slope: Array, into: Samples) -> None:
        kernel.torque_slope(slope / unit, chi, into.entries)

    return kernel.torque(state.entries, chi) / unit, pullback


def duration_limit(duration: float) -> Limit:
    """Limit the time that the whole motion may take [s]."""
    low, high, middle, unit = np.array([[-np.inf], [1.0], [0.0], [duration]])
    return Limit("duration", "duration", ("motion",), low, high, middle, unit, partial(_duration, duration))


def _duration(longest: float, state: Samples) -> tuple[Array, Pullback]:
    def pullback(slope: Array, into: Samples) -> None:
        into.weight[...] += slope[0, 0] / longest

    return np.array([[state.weight.sum() / longest]]), pullback


def slow_limit(kernel: RegressorKernel, limit: Limit, speed: float) -> Limit:
    """Limit the torque at a fraction of the speed: speeds shrink by it, accelerations by its square.

    What dynamic forces help to lift has to be held without them: a limit may be active in the slow run alone.
    """
    name = f"{limit.name} at {100.0 * speed:g} % of the speed"
    return replace(limit, name=name, measure=partial(_slowed, kernel, limit, speed))


def _slowed(kernel: RegressorKernel, limit: Limit, speed: float, state: Samples) -> tuple[Array, Pullback]:
    weight, q, qd, qdd, _, width = state
    slow = kernel.state(Samples(weight / speed, q, speed * qd, speed**2 * qdd), speed * float(width[0]))
    values, own = limit.measure(slow)

    def pullback(slope: Array, into: Samples) -> None:
        slopes = Samples.zeros(slow)
        own(slope, slopes)
        for part, by, power in zip(into[1:4], kernel.state_slope(slow, slopes.entries), (0, 1, 2), strict=True):
            part += speed**power * by

    return values, pullback


class LimitCheck(Document, frozen=True):
    """Result of a check: how near a motion comes to one limit on a fine grid.

    Attributes:
        name: of the limit.
        worst: what comes nearest ("joint 3").
        value, limit: there, SI units.
        violation: by how much the limit is missed, SI units; 0 where it is met.
        relative: ``violation`` in units of the limit.
        room: what is left to the limit, in units of the limit; negative where it is missed.
    """

    name: str
    worst: str
    value: float
    limit: float
    violation: float
    relative: float
    room: float

    def __str__(self) -> str:
        """Write the check in one line."""
        state = f"violated by {self.violation:.4g}" if self.violation > 0.0 else "met"
        return f"{self.name} of {self.worst}: {self.value:.4g} against {self.limit:.4g}, {state}"


def excess(limit: Limit, values: Array) -> Array:
    """Distance of each value outside its interval, in the limit's units; negative inside."""
    return np.maximum(values - limit.high, limit.low - values)


def check(limit: Limit, state: Samples) -> LimitCheck:
    """Find where a motion comes nearest to a limit, or misses it most."""
    values = limit.values(state)
    over = excess(limit, values)
    row, column = np.unravel_index(int(np.argmax(over)), over.shape)
    middle, unit, low, high = (float(x[column]) for x in (limit.middle, limit.unit, limit.low, limit.high))
    value, beyond = float(values[row, column]), float(over[row, column])
    nearest = high if value - high >= low - value else low
    missed, shown = max(beyond, 0.0), (middle + value * unit, middle + nearest * unit)
    return LimitCheck(limit.name, limit.labels[int(column)], *shown, missed * unit, missed, -beyond)
