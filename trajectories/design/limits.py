"""Limits of a motion as numbers that must stay within an interval, with their slopes.

Every limit is written as low <= y(x) <= high with y of the order of 1: the two-sided form of g(x) <= 0. Slopes in
y are pulled back to the states and, for torques, to the entries of the observation matrix, from where the design's
one adjoint takes them on.
"""

from collections.abc import Callable
from typing import Literal, NamedTuple, Protocol

import numpy as np

from ...common.arrays import Array
from ..motions.samples import Samples
from .information import RegressorKernel


class State(NamedTuple):
    """A motion's samples and the regressor's entries on them."""

    samples: Samples
    entries: Array


class Slopes(NamedTuple):
    """Slopes of one number in the samples, and in the regressor's entries; both are added to."""

    samples: Samples
    seed: Array


Penalty = Callable[[State, Slopes], float]
"""Terms that limits add to a criterion: their value; their slopes are added to ``Slopes``."""


class Limit(Protocol):
    """One kind of limit.

    Attributes:
        name: what it limits ("speed").
        low, high: the interval of each column.
        middle, unit: the value in SI units is middle + y * unit, per column.
    """

    name: str
    low: Array
    high: Array
    middle: Array
    unit: Array

    def values(self, state: State) -> Array:
        """y, rows per sample (one row for the motion as a whole), a column per joint or pair of bodies."""

    def pullback(self, state: State, slope: Array, into: Slopes) -> None:
        """Add what a slope in the values means for samples and entries."""

    def label(self, column: int) -> str:
        """What a column belongs to ("joint 3")."""


class StateLimit:
    """Position, speed or acceleration of each joint."""

    def __init__(self, name: Literal["position", "speed", "acceleration"], low: Array, high: Array) -> None:
        """``low`` and ``high`` in SI units, each (n,), or (k, n) for k equal parts of the samples."""
        self.name: str = name
        self._field = {"position": "q", "speed": "qd", "acceleration": "qdd"}[name]
        low, high = np.atleast_2d(low, high)
        self._middle, self._half = 0.5 * (low + high), 0.5 * (high - low)
        # In messages the first part stands for all; each sample is judged by its own.
        self.middle, self.unit = self._middle[0], self._half[0]
        self.low, self.high = -np.ones(low.shape[1]), np.ones(low.shape[1])

    def values(self, state: State) -> Array:
        """Distance from the middle, 1 at the limit."""
        x = getattr(state.samples, self._field)
        return np.asarray((x - self._each(self._middle, len(x))) / self._each(self._half, len(x)))

    def pullback(self, state: State, slope: Array, into: Slopes) -> None:
        """Add the slopes to those in the states."""
        getattr(into.samples, self._field)[...] += slope / self._each(self._half, len(slope))

    def label(self, column: int) -> str:
        """The joint."""
        return f"joint {column + 1}"

    @staticmethod
    def _each(parts: Array, samples: int) -> Array:
        """A row for each sample, or one for all."""
        return parts if len(parts) == 1 else np.repeat(parts, samples // len(parts), axis=0)


class TorqueLimit:
    """Torque of each joint, tau = W chi, for one load."""

    def __init__(self, kernel: RegressorKernel, chi: Array, torque: Array, load: str = "") -> None:
        """``chi`` (c,) in the kernel's columns; ``torque`` (n,) [N·m or N], infinite where there is none."""
        self.name = f"torque {load}".strip()
        self._kernel, self._chi = kernel, chi
        self.unit = np.where(np.isfinite(torque), torque, 1.0)
        self.high = np.where(np.isfinite(torque), 1.0, np.inf)
        self.low, self.middle = -self.high, np.zeros(len(torque))

    def values(self, state: State) -> Array:
        """Torque over its limit."""
        return self._kernel.torque(state.entries, self._chi) / self.unit

    def pullback(self, state: State, slope: Array, into: Slopes) -> None:
        """Add the slopes to those in the entries of the regressor."""
        self._kernel.torque_slope(slope / self.unit, self._chi, into.seed)

    def label(self, column: int) -> str:
        """The joint."""
        return f"joint {column + 1}"


class DurationLimit:
    """Time that the whole motion may take."""

    def __init__(self, duration: float) -> None:
        """``duration`` [s]."""
        self.name, self.unit, self.middle = "duration", np.array([duration]), np.zeros(1)
        self.low, self.high = np.array([-np.inf]), np.array([1.0])

    def values(self, state: State) -> Array:
        """Duration over its limit, 1 x 1."""
        return np.asarray(state.samples.weight.sum() / self.unit)[None]

    def pullback(self, state: State, slope: Array, into: Slopes) -> None:
        """Add the slope to those in the samples' weights."""
        into.samples.weight[...] += slope[0, 0] / self.unit[0]

    def label(self, column: int) -> str:
        """The motion."""
        return "motion"


class LimitCheck(NamedTuple):
    """How near a motion comes to one limit on a fine grid.

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
        """One line."""
        state = f"violated by {self.violation:.4g}" if self.violation > 0.0 else "met"
        return f"{self.name} of {self.worst}: {self.value:.4g} against {self.limit:.4g}, {state}"


def excess(limit: Limit, values: Array) -> Array:
    """By how much each value lies outside its interval, in the limit's units; negative inside."""
    return np.maximum(values - limit.high, limit.low - values)


def check(limit: Limit, state: State) -> LimitCheck:
    """The place where a motion comes nearest to a limit, or misses it most."""
    values = limit.values(state)
    over = excess(limit, values)
    row, column = np.unravel_index(int(np.argmax(over)), over.shape)
    middle, unit, low, high = (float(x[column]) for x in (limit.middle, limit.unit, limit.low, limit.high))
    value = float(values[row, column])
    nearest = high if value - high >= low - value else low
    room = -float(over[row, column])
    missed = max(-room, 0.0)
    return LimitCheck(
        limit.name,
        limit.label(int(column)),
        middle + value * unit,
        middle + nearest * unit,
        missed * unit,
        missed,
        room,
    )
