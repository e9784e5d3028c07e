"""Limits of a motion as numbers that must stay within an interval, with their slopes.

Every limit is written as low <= y(x) <= high with y of the order of 1: the two-sided form of g(x) <= 0. Slopes in
y are pulled back to the states and, for torques, to the entries of the observation matrix, from where the design's
one adjoint takes them on.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, Generic, Literal, NamedTuple, TypeVar

import numpy as np

from ...common.arrays import Array
from ...common.brief import Brief
from ...common.schema import Document
from ..motions.family import JointBounds, Samples
from .information import RegressorKernel

_Value = TypeVar("_Value")


class State(NamedTuple):
    """A motion's samples and the regressor's entries on them; or slopes of one number in both, to be added to.

    ``width``: of the smoothed sign in the entries [rad/s or m/s]; 0 for the exact one.
    """

    samples: Samples
    entries: Array
    width: float = 0.0


Penalty = Callable[[State, State], float]
"""Function that evaluates terms which limits add to a criterion in a state; slopes are added to the second one."""


@dataclass(frozen=True, eq=False, repr=False)
class Limit(Brief):
    """Limit of one kind.

    Attributes:
        kind: what it takes to know it: one state by itself, torques, the whole motion, or where bodies are.
        labels: what each column belongs to ("joint 3").
        low, high: the interval of each column.
        middle, unit: the value in SI units is middle + y * unit, per column.
    """

    kind: Literal["state", "torque", "duration", "clearance"]
    name: str
    labels: tuple[str, ...]
    low: Array
    high: Array
    middle: Array
    unit: Array

    def values(self, state: State) -> Array:
        """Evaluate y of a motion, rows per sample (one row for the motion as a whole), a column for each label."""
        raise NotImplementedError

    def pullback(self, state: State, slope: Array, into: State) -> None:
        """Add what a slope in the values of a state means for samples and entries."""
        raise NotImplementedError


def joint_labels(n: int) -> tuple[str, ...]:
    """Names of the columns of n joints in messages."""
    return tuple(f"joint {j + 1}" for j in range(n))


def state_limits(bounds: JointBounds, reach: tuple[Array, Array] | None = None) -> tuple[Limit, Limit, Limit]:
    """Limit position, speed and acceleration of each joint; 1 at the limit.

    ``reach``: lowest and highest positions instead of the bounds' own, each (n,), or (k, n) for k equal parts of
    the samples.
    """
    v, a = bounds.speed, bounds.acceleration
    position = StateLimit.between("position", *(reach or (bounds.low, bounds.high)))
    return position, StateLimit.between("speed", -v, v), StateLimit.between("acceleration", -a, a)


@dataclass(frozen=True, eq=False, repr=False)
class StateLimit(Limit):
    """Limit of positions, speeds or accelerations; of k equal parts of the samples, each its own, (k, n)."""

    centres: Array
    halves: Array

    @staticmethod
    def between(name: str, low: Array, high: Array) -> "StateLimit":
        """Make the limit of what ``name`` says."""
        low, high = np.atleast_2d(low, high)
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        unit = np.ones(low.shape[1])
        # In messages the first part stands for all; each sample is judged by its own.
        return StateLimit(
            "state", name, joint_labels(len(unit)), -unit, unit, middle[0], half[0], centres=middle, halves=half
        )

    def values(self, state: State) -> Array:
        """Compute the distance from the middle, in halves of the range."""
        x = state.samples[self._index]
        return np.asarray((x - _each(self.centres, len(x))) / _each(self.halves, len(x)))

    def pullback(self, _: State, slope: Array, into: State) -> None:
        """Add the slope in what is limited."""
        into.samples[self._index][...] += slope / _each(self.halves, len(slope))

    @property
    def _index(self) -> int:
        return ("position", "speed", "acceleration").index(self.name) + 1


def _each(parts: Array, samples: int) -> Array:
    return parts if len(parts) == 1 else np.repeat(parts, samples // len(parts), axis=0)


@dataclass(frozen=True, eq=False, repr=False)
class TorqueLimit(Limit):
    """Limit of torques W chi of one load."""

    kernel: RegressorKernel
    chi: Array

    def values(self, state: State) -> Array:
        """Compute torques over their limits."""
        return self.kernel.torque(state.entries, self.chi) / self.unit

    def pullback(self, _: State, slope: Array, into: State) -> None:
        """Add the slope in the entries."""
        self.kernel.torque_slope(slope / self.unit, self.chi, into.entries)


def torque_limit(kernel: RegressorKernel, chi: Array, torque: Array, load: str = "") -> Limit:
    """Limit the torque of each joint, over its limit (infinite where there is none), tau = W chi, for one load."""
    finite, n = np.isfinite(torque), len(torque)
    unit, high, name = np.where(finite, torque, 1.0), np.where(finite, 1.0, np.inf), f"torque {load}".strip()
    return TorqueLimit("torque", name, joint_labels(n), -high, high, np.zeros(n), unit, kernel, chi)


class DurationLimit(Limit):
    """Limit of the time that the whole motion takes."""

    def values(self, state: State) -> Array:
        """Compute the time over its limit, 1 x 1."""
        return np.asarray(state.samples.weight.sum() / self.unit)[None]

    def pullback(self, _: State, slope: Array, into: State) -> None:
        """Add the slope in the samples' times."""
        into.samples.weight[...] += slope[0, 0] / self.unit[0]


def duration_limit(duration: float) -> Limit:
    """Limit the time that the whole motion may take [s]."""
    low, high, middle, unit = np.array([[-np.inf], [1.0], [0.0], [duration]])
    return DurationLimit("duration", "duration", ("motion",), low, high, middle, unit)


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


def check(limit: Limit, state: State) -> LimitCheck:
    """Find where a motion comes nearest to a limit, or misses it most."""
    values = limit.values(state)
    over = excess(limit, values)
    row, column = np.unravel_index(int(np.argmax(over)), over.shape)
    middle, unit, low, high = (float(x[column]) for x in (limit.middle, limit.unit, limit.low, limit.high))
    value, beyond = float(values[row, column]), float(over[row, column])
    nearest = high if value - high >= low - value else low
    missed, shown = max(beyond, 0.0), (middle + value * unit, middle + nearest * unit)
    return LimitCheck(limit.name, limit.labels[int(column)], *shown, missed * unit, missed, -beyond)


class Latest(Generic[_Value]):
    """Function of a state that keeps its last value until another one comes: slopes are asked for after values."""

    def __init__(self, compute: Callable[[State], _Value]) -> None:
        """Keep nothing yet."""
        self._compute, self._last = compute, list[tuple[State, _Value]]()

    def __call__(self, state: State) -> _Value:
        """Compute the value, or give the last one."""
        if not self._last or self._last[0][0] is not state:
            self._last[:] = [(state, self._compute(state))]
        return self._last[0][1]

    def __reduce__(self) -> tuple[type["Latest[Any]"], tuple[Callable[[State], _Value]]]:
        """Pickle and copy the function without its last value."""
        return Latest, (self._compute,)


@dataclass(frozen=True, eq=False, repr=False)
class SlowLimit(Limit):
    """Limit of a torque at a fraction of the speed: speeds shrink by it, accelerations by its square.

    What dynamic forces help to lift has to be held without them: a limit may be active in the slow run alone.
    """

    kernel: RegressorKernel
    fast: Limit
    speed: float

    @cached_property
    def _slowed(self) -> Latest[State]:
        return Latest(self.slowed)

    def slowed(self, state: State) -> State:
        """Evaluate the slow run."""
        (weight, q, qd, qdd), speed = state.samples, self.speed
        slow, width = Samples(weight / speed, q, speed * qd, speed**2 * qdd), speed * state.width
        return State(slow, self.kernel.entries(slow, width), width)

    def values(self, state: State) -> Array:
        """Evaluate the limit in the slow run."""
        return self.fast.values(self._slowed(state))

    def pullback(self, state: State, slope: Array, into: State) -> None:
        """Add the slopes of the slow run."""
        slow = self._slowed(state)
        slopes = State(Samples.zeros(slow.samples), np.zeros_like(slow.entries))
        self.fast.pullback(slow, slope, slopes)
        by_state = self.kernel.state_slope(slow.samples, slow.width, slopes.entries)
        for part, by, power in zip(into.samples[1:], by_state, (0, 1, 2), strict=True):
            part += self.speed**power * by


def slow_limit(kernel: RegressorKernel, limit: Limit, speed: float) -> Limit:
    """Limit the torque at a fraction of the speed, besides."""
    own: dict[str, Any] = {field.name: getattr(limit, field.name) for field in fields(Limit)}
    own["name"] = f"{limit.name} at {100.0 * speed:g} % of the speed"
    return SlowLimit(**own, kernel=kernel, fast=limit, speed=speed)
