"""What every kind of motion offers: samples of its states, a plan to run, a family and its shape."""

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Motion, Robot
from .bounds import JointBounds

Clear = Callable[[Array], bool]
"""Whether the robot may take all of some poses, (N, n) [rad or m]."""
_END = 1e-12  # of the duration: what rounding may keep the last sample from falling on the end
LONGEST = 3600.0
"""s: a motion that is designed takes no longer."""
_MOST = 10_000_000
"""Samples of a motion: eleven hours at 250 Hz; memory would not hold much more."""


def everywhere(poses: Array) -> bool:
    """Nothing stands in the way."""
    return True


def sample_count(duration: float, rate: float) -> int:
    """Samples of a motion of so many seconds at ``rate`` [Hz], its end included where one falls on it.

    Raises:
        InputError: if there are too many to be held.
    """
    if not duration * rate < _MOST:
        raise InputError(
            f"a motion of {duration:g} s at {rate:g} Hz has more than {_MOST} samples: make it shorter"
        )
    return int(duration * rate * (1.0 + _END)) + 1


class Samples(NamedTuple):
    """States with the time that each stands for.

    ``weight`` (N,) [s]; ``q``, ``qd``, ``qdd`` (N, n) [rad or m, per second, per second squared].
    """

    weight: Array
    q: Array
    qd: Array
    qdd: Array

    @staticmethod
    def zeros(like: "Samples") -> "Samples":
        """Samples of the same shapes, all zero."""
        return Samples(*(np.zeros_like(x) for x in like))


class Plan(Protocol):
    """A motion to be run: it starts and ends at rest, and says how long it takes."""

    @property
    def duration(self) -> float:
        """Time from rest to rest [s]."""

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Position, speed and acceleration at times [s], each (N, n); at rest before 0 and after ``duration``."""

    def motion(self, rate: float) -> Motion:
        """Sample the motion at ``rate`` [Hz], its end included where a sample falls on it."""
        t = np.arange(sample_count(self.duration, rate)) / rate
        return Motion(t, *self.at(t))


class Family(Protocol):
    """Motions that depend smoothly on a vector x whose entries are of the order of 1.

    Attributes:
        low, high: bounds of x, shape (size,).
        free_duration: whether the duration depends on x.
        reach: lowest and highest positions, each (n,), or (k, n): a row for each of k equal parts of the samples.
    """

    size: int
    low: Array
    high: Array
    free_duration: bool
    reach: tuple[Array, Array]

    def random(self, draw: np.random.Generator, clear: Clear = everywhere) -> Array:
        """A random x to start from, within position and speed limits, through ``clear`` poses if it can."""

    def sample(self, x: Array, finer: int = 1) -> Samples:
        """States on the grid of the optimisation, or on one ``finer`` times as dense."""

    def pullback(self, x: Array, slope: Samples) -> Array:
        """Gradient in x of a number whose gradient in the samples is ``slope``: the Jacobian transposed."""

    def plan(self, x: Array) -> Plan:
        """The motion."""

    def eased(self, x: Array, slower: float, smaller: float) -> Array:
        """Make a motion ``slower`` times slower, where the duration is free, and ``smaller`` times smaller."""


class Shape(Protocol):
    """A kind of motion among which a design chooses: a small value that stands for a family."""

    def family(self, robot: Robot, bounds: JointBounds, duration: float | None, start: Array | None) -> Family:
        """Motions of this shape.

        Args:
            duration: longest time that a motion through via points may take [s]; None for any.
            start: where it begins [rad or m], shape (n,); None for anywhere.
        """
