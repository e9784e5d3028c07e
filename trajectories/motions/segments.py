"""How a motion goes from one via point to the next: a quintic, or a trapezoid of speed.

Both give q, T qd and T^2 qdd at s = t / T as constant matrices times the states at the segment's ends: what
multiplies p0, T v0, T^2 a0, T^2 a1, T v1 and p1.
"""

from dataclasses import dataclass

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError

# Quintic Hermite polynomials on 0 <= s <= 1: row k holds the coefficients of 1, s, ..., s^5 that multiply
# p0, T v0, T^2 a0, T^2 a1, T v1, p1.
_HERMITE = np.array(
    [
        [1.0, 0.0, 0.0, -10.0, 15.0, -6.0],
        [0.0, 1.0, 0.0, -6.0, 8.0, -3.0],
        [0.0, 0.0, 0.5, -1.5, 1.5, -0.5],
        [0.0, 0.0, 0.0, 0.5, -1.0, 0.5],
        [0.0, 0.0, 0.0, -4.0, 7.0, -3.0],
        [0.0, 0.0, 0.0, 10.0, -15.0, 6.0],
    ]
)


Basis = tuple[Array, Array, Array]
"""What multiplies the ends' states: in q, in T qd and in T^2 qdd, each (N, 6)."""
Grid = tuple[Array, Basis]
"""Samples of a segment: the share of its time that each stands for, shape (N,), and the basis there."""


@dataclass(frozen=True)
class Quintic:
    """A quintic between position, speed and acceleration at both ends."""

    name = "quintic"
    passes = True
    peak_speed = 15.0 / 8.0
    peak_acceleration = 10.0 / 3.0**0.5

    def basis(self, s: Array) -> Basis:
        """The Hermite polynomials."""
        powers = s[:, None] ** np.arange(6)
        k = np.arange(1, 6)
        first = np.hstack([np.zeros((len(s), 1)), k * powers[:, :5]])
        second = np.hstack([np.zeros((len(s), 2)), k[1:] * k[:4] * powers[:, :4]])
        return powers @ _HERMITE.T, first @ _HERMITE.T, second @ _HERMITE.T

    def grid(self, parts: int) -> Grid:
        """Even parts."""
        return even(parts), self.basis(np.linspace(0.0, 1.0, parts + 1))


QUINTIC = Quintic()


@dataclass(frozen=True)
class Trapezoid:
    """A ramp to constant speed and a ramp down, as a controller runs a synchronised joint move.

    It rests at both ends. All joints follow one law q0 + (q1 - q0) f(t / T). Its acceleration is constant in each
    phase and steps between them.

    Attributes:
        ramp: share of the time that each of the two ramps takes, above 0, at most 0.5 (no constant speed then).

    Raises:
        InputError: if the ramp is out of range.
    """

    ramp: float = 0.25

    name = "trapezoid"
    passes = False

    def __post_init__(self) -> None:
        """Check the ramp."""
        if not 0.0 < self.ramp <= 0.5:
            raise InputError(f"a ramp of {self.ramp:g} of a move's time: give a share above 0, at most 0.5")

    @property
    def peak_speed(self) -> float:
        """Reached over the whole constant phase."""
        return 1.0 / (1.0 - self.ramp)

    @property
    def peak_acceleration(self) -> float:
        """Held over the whole ramps."""
        return 1.0 / (self.ramp * (1.0 - self.ramp))

    def basis(self, s: Array) -> Basis:
        """At a step of the acceleration its value after the step, at s = 1 that before."""
        return self._in_phase(s, np.minimum(np.searchsorted(self._corners[1:-1], s, side="right"), 2))

    def grid(self, parts: int) -> Grid:
        """Even parts of each phase; both sides of every step of the acceleration are sampled."""
        s, phase, share = [], [], []
        for k, (begin, end) in enumerate(zip(self._corners[:-1], self._corners[1:], strict=True)):
            if end > begin:
                count = max(round(parts * (end - begin)), 2)
                s.append(np.linspace(begin, end, count + 1))
                phase.append(np.full(count + 1, k))
                share.append(even(count) * (end - begin))
        return np.concatenate(share), self._in_phase(np.concatenate(s), np.concatenate(phase))

    @property
    def _corners(self) -> Array:
        return np.array([0.0, self.ramp, 1.0 - self.ramp, 1.0])

    def _in_phase(self, s: Array, phase: Array) -> Basis:
        """f, f' and f'' in the ramp up (0), at constant speed (1) and in the ramp down (2)."""
        v, a, left = self.peak_speed, self.peak_acceleration, 1.0 - s
        up, down = phase == 0, phase == 2
        f = np.select([up, down], [0.5 * a * s**2, 1.0 - 0.5 * a * left**2], v * (s - 0.5 * self.ramp))
        slope = np.select([up, down], [a * s, a * left], v)
        curve = np.select([up, down], [a, -a], 0.0)
        between = np.array([-1.0, 0.0, 0.0, 0.0, 0.0, 1.0])
        still = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
        return still + f[:, None] * between, slope[:, None] * between, curve[:, None] * between


Segment = Quintic | Trapezoid
"""A way from point to point: its name, whether it ``passes`` points in motion, and the peak speed and acceleration
of a step of 1 in unit time, at rest at both ends."""


def even(parts: int) -> Array:
    """Weights of the trapezoidal rule over unit time in even parts, shape (parts + 1,)."""
    share = np.full(parts + 1, 1.0 / parts)
    share[[0, -1]] *= 0.5
    return share
