"""Fourier motions (Swevers et al. 1997): periodic, at rest without acceleration where they begin and end.

q(t) = q0 + sum_l (a_l / (w l) sin(w l t) - b_l / (w l) cos(w l t)), w = 2 pi / period. Speed and acceleration at
both ends vanish if and only if sum a_l = 0 and sum l b_l = 0; the free parameters are coordinates in the null space
of these equations, so that every x satisfies them.
"""

from dataclasses import dataclass

import numpy as np

from ...common.arrays import Array, frozen_array
from ...common.brief import Brief
from ...common.errors import InputError
from ...model import Robot
from .family import LONGEST, Clear, JointBounds, Plan, Samples, checked_start, everywhere

_MOST = 50  # harmonics: a search takes half an hour then
_TRIES, _SHRINKS = 200, 10  # to find a middle that is clear, and a motion about it
_SPAN = 0.5  # of position range and speed that a random motion may use at first
_SAMPLES = 24  # per period of the highest harmonic while optimising


@dataclass(frozen=True, repr=False)
class Fourier(Plan, Brief):
    """One period of a Fourier series.

    Attributes:
        offset: q0 [rad or m], shape (n,).
        a, b: speed amplitudes of sine and cosine terms [rad/s or m/s], each of shape (n, harmonics).
        period: [s].
    """

    offset: Array
    a: Array
    b: Array
    period: float

    def __post_init__(self) -> None:
        """Lock the arrays and check them."""
        object.__setattr__(self, "offset", frozen_array(self.offset, (None,), "offset"))
        shape = (len(self.offset), None)
        object.__setattr__(self, "a", frozen_array(self.a, shape, "a"))
        object.__setattr__(self, "b", frozen_array(self.b, self.a.shape, "b"))
        if not 0.0 < self.period < np.inf:
            raise ValueError("a Fourier motion needs a positive period")

    @property
    def duration(self) -> float:
        """One period [s]."""
        return self.period

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Position, speed and acceleration at times [s], each (N, n); at rest before 0 and after one period."""
        B, Bd, Bdd = fourier_basis(np.clip(t, 0.0, self.period), self.a.shape[1], self.period)
        c = np.hstack([self.a, self.b]).T
        return self.offset + B @ c, Bd @ c, Bdd @ c


def fourier_basis(t: Array, harmonics: int, period: float) -> tuple[Array, Array, Array]:
    """What multiplies a_1 ... a_H, b_1 ... b_H in q, qd and qdd, each (N, 2 H)."""
    wl = 2.0 * np.pi / period * np.arange(1, harmonics + 1)
    s, c = np.sin(wl * t[:, None]), np.cos(wl * t[:, None])
    return np.hstack([s / wl, -c / wl]), np.hstack([c, s]), np.hstack([-s * wl, c * wl])


class RestingSeries:
    """A family of Fourier series of a fixed period that begin and end at rest, without acceleration.

    Attributes:
        null: coefficients a_1 ... a_H, b_1 ... b_H of each of the basis functions, 2 H x functions.
        first: what multiplies the coefficients in q at t = 0, shape (2 H,).
    """

    free_duration = False

    def __init__(self, harmonics: int, period: float, samples: int, anchored: bool, parts: tuple[int, ...]) -> None:
        """At least two ``harmonics`` in a ``period`` [s]; ``anchored``: q counts from where the motion begins.

        Args:
            samples: of a period while optimising.
            parts: shape of x, but for the basis functions' weights along the last axis, one more if not anchored.
        """
        ends = np.zeros((2, 2 * harmonics))
        ends[0, :harmonics] = 1.0
        ends[1, harmonics:] = np.arange(1, harmonics + 1)
        self.null = np.linalg.svd(ends)[2][2:].T  # what leaves both ends as they are
        self.first = fourier_basis(np.zeros(1), harmonics, period)[0][0]
        self._harmonics, self._period, self._samples, self._anchored = harmonics, period, samples, anchored
        self._grids: dict[int, tuple[Array, Array, Array]] = {}
        self._shape = (*parts, self.null.shape[1] + (not anchored))
        self.size = int(np.prod(self._shape))
        self.low, self.high = np.full(self.size, -np.inf), np.full(self.size, np.inf)

    def grid(self, finer: int = 1) -> tuple[Array, Array, Array]:
        """What multiplies the coefficients in q, qd and qdd at even times of one period, each (N, 2 H)."""
        if finer not in self._grids:
            count = self._samples * finer
            B, Bd, Bdd = fourier_basis(np.arange(count) / count * self._period, self._harmonics, self._period)
            self._grids[finer] = (B - self.first if self._anchored else B, Bd, Bdd)
        return self._grids[finer]

    def by_weights(self, slope: Samples) -> Array:
        """Slopes in the basis functions' weights, n x functions, from those in a period's states."""
        B, Bd, Bdd = self.grid()
        return np.asarray((slope.q.T @ B + slope.qd.T @ Bd + slope.qdd.T @ Bdd) @ self.null)

    def eased(self, x: Array, slower: float, smaller: float) -> Array:
        """Smaller about what q counts from; the period stays."""
        return np.asarray(x * (smaller / slower))


@dataclass(frozen=True)
class FourierShape:
    """A Fourier series of a fixed duration.

    Attributes:
        duration: period [s].
        samples: while optimising; 0 for 24 per period of the highest harmonic.
        start: where it begins and ends [rad or m], n numbers; None for anywhere.
    """

    harmonics: int = 5
    duration: float = 10.0
    samples: int = 0
    start: tuple[float, ...] | None = None

    def family(self, robot: Robot, bounds: JointBounds) -> "FreeFourier":
        """Motions of this shape."""
        return FreeFourier(bounds, self)


class FreeFourier(RestingSeries):
    """Fourier series about a middle that is free, or from a given start; q, qd and qdd are linear in x."""

    def __init__(self, bounds: JointBounds, shape: FourierShape) -> None:
        """Lay out x.

        Raises:
            InputError: with too few harmonics: nothing moves that begins and ends at rest; for a start
                beyond limits.
        """
        start = checked_start(bounds, shape.start)
        harmonics, period, anchored = shape.harmonics, shape.duration, start is not None
        if not 2 <= harmonics <= _MOST or not 0.0 < period <= LONGEST:
            raise InputError(
                f"{harmonics} harmonics in {period:g} s: give at least 2, at most {_MOST}, in up to {LONGEST:g} s"
            )
        super().__init__(harmonics, period, shape.samples or _SAMPLES * harmonics, anchored, (len(bounds.low),))
        self._bounds, self._start, self.reach = bounds, start, (bounds.low, bounds.high)

    def random(self, draw: np.random.Generator, clear: Clear = everywhere) -> Array:
        """Random coefficients, as large as position and speed limits allow by half."""
        bounds, (n, size) = self._bounds, (self._shape[0], self.null.shape[1])
        c = np.zeros(self._shape)
        c[:, :size] = draw.standard_normal((n, size))
        moved = self.sample(c.ravel())
        reach = np.abs(moved.q - moved.q.mean(axis=0)).max(axis=0) / bounds.half
        fast = np.abs(moved.qd).max(axis=0) / bounds.speed
        strong = np.abs(moved.qdd).max(axis=0) / bounds.acceleration
        c /= (np.maximum(np.maximum(reach, fast), strong) / _SPAN)[:, None]
        if self._start is None:
            for _ in range(_TRIES):
                c[:, -1] = _SPAN * draw.uniform(-1.0, 1.0, n)
                if clear((bounds.middle + bounds.half * c[:, -1])[None]):
                    break
        for _ in range(_SHRINKS):
            if clear(self.sample(c.ravel()).q):
                break
            c[:, :size] *= 0.8
        return np.asarray(c.ravel())

    def sample(self, x: Array, finer: int = 1) -> Samples:
        """States at even times of one period."""
        offset, c = self._unpacked(x)
        B, Bd, Bdd = self.grid(finer)
        return Samples(np.full(len(B), self._period / len(B)), offset + B @ c.T, Bd @ c.T, Bdd @ c.T)

    def pullback(self, x: Array, slope: Samples) -> Array:
        """The Jacobian transposed times the slopes."""
        by_x = self.by_weights(slope) * self._bounds.speed[:, None]
        if self._start is None:
            by_x = np.column_stack([by_x, slope.q.sum(axis=0) * self._bounds.half])
        return np.asarray(by_x.ravel())

    def plan(self, x: Array) -> Fourier:
        """The motion."""
        offset, c = self._unpacked(x)
        a, b = np.hsplit(c, 2)
        return Fourier(offset if self._start is None else offset - c @ self.first, a, b, self._period)

    def _unpacked(self, x: Array) -> tuple[Array, Array]:
        """What q counts from, (n,), and coefficients a, b (n, 2 H)."""
        weights = x.reshape(self._shape)
        c = (weights[:, : self.null.shape[1]] @ self.null.T) * self._bounds.speed[:, None]
        if self._start is None:
            return self._bounds.middle + self._bounds.half * weights[:, -1], c
        return self._start, c
