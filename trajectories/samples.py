"""States of the robot on a motion, and what a design may change about them."""

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..common.arrays import Array
from ..model import Motion

Clear = Callable[[Array], bool]
"""Whether the robot may take all of some poses, (N, n) [rad or m]."""


def everywhere(poses: Array) -> bool:
    """Nothing stands in the way."""
    return True


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


class Jacobian(NamedTuple):
    """Derivatives of a motion's states in x, as far as they are not zero.

    Attributes:
        columns: of x on which a joint's states depend, at each sample, shape (N, n, w); ``size`` stands for none.
        q, qd, qdd: the derivatives in them, each (N, n, w); zero where the column is none.
        size: length of x.
    """

    columns: NDArray[np.intp]
    q: Array
    qd: Array
    qdd: Array
    size: int

    def dense(self) -> tuple[Array, Array, Array]:
        """Derivatives of q, qd and qdd, each (N, n, size)."""
        count, n, _ = self.columns.shape
        samples, joints = np.ogrid[:count, :n]
        wide = np.zeros((3, count, n, self.size + 1))
        for into, values in zip(wide, self[1:4], strict=True):
            np.add.at(into, (samples[..., None], joints[..., None], self.columns), values)
        return wide[0, ..., :-1], wide[1, ..., :-1], wide[2, ..., :-1]

    def transposed(self, slope: Samples) -> Array:
        """The transposed Jacobian times slopes in the states, shape (size,); weights not counted."""
        by_x = sum(values * part[..., None] for values, part in zip(self[1:4], slope[1:], strict=True))
        return np.asarray(np.bincount(self.columns.ravel(), np.ravel(by_x), self.size + 1)[:-1], dtype=float)


class Plan(Protocol):
    """A motion as a design returns it: it can be sampled, and says how long it takes."""

    @property
    def duration(self) -> float:
        """Time from start to end [s]."""

    def motion(self, rate: float) -> Motion:
        """Sample the motion at ``rate`` [Hz]."""

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Position, speed and acceleration at times [s], each (N, n); at rest before 0 and after the end."""


class Family(Protocol):
    """Motions that depend smoothly on a vector x whose entries are of the order of 1.

    Attributes:
        size: length of x.
        low, high: bounds of x, shape (size,).
        free_duration: whether the duration depends on x.
    """

    size: int
    low: Array
    high: Array
    free_duration: bool

    def random(self, draw: np.random.Generator, clear: Clear = everywhere) -> Array:
        """A random x to start from, within position and speed limits, through ``clear`` poses if it can."""

    def sample(self, x: Array, finer: int = 1) -> Samples:
        """States on the grid of the optimisation, or on one ``finer`` times as dense."""

    def pullback(self, x: Array, slope: Samples) -> Array:
        """Gradient in x of a number whose gradient in the samples is ``slope``: the Jacobian transposed."""

    def jacobian(self, x: Array) -> Jacobian:
        """Derivatives of the states; which columns they depend on is the same for every x."""

    def plan(self, x: Array) -> Plan:
        """The motion."""

    def eased(self, x: Array, slower: float, smaller: float) -> Array:
        """The same motion ``slower`` times slower, where the duration is free, and ``smaller`` times smaller."""
