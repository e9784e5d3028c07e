"""Fourier motions (Swevers et al. 1997): periodic, at rest without acceleration where they begin and end.

q(t) = q0 + sum_l (a_l / (w l) sin(w l t) - b_l / (w l) cos(w l t)), w = 2 pi / period. Speed and acceleration at
both ends vanish if and only if sum a_l = 0 and sum l b_l = 0; the free parameters are coordinates in the null space
of these equations, so that every x satisfies them.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space

from ..common.arrays import Array, frozen_array
from ..common.errors import InputError
from ..model import Motion, Robot
from .bounds import JointBounds
from .samples import Clear, Jacobian, Samples, everywhere

_TRIES, _SHRINKS = 200, 10  # to find a middle that is clear, and a motion about it
_SPAN = 0.5  # of position range and speed that a random motion may use at first


@dataclass(frozen=True)
class Fourier:
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

    def motion(self, rate: float) -> Motion:
        """Sample one period at ``rate`` [Hz], its end included where a sample falls on it."""
        t = np.arange(int(self.period * rate * (1.0 + 1e-12)) + 1) / rate
        return Motion(t, *self.at(t))

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


class FreeFourier:
    """Fourier series of a fixed period; q, qd and qdd are linear in x through constant bases."""

    def __init__(
        self,
        robot: Robot,
        bounds: JointBounds,
        harmonics: int,
        duration: float,
        *,
        samples: int = 0,
        start: Array | None = None,
    ) -> None:
        """Set up the bases.

        Args:
            robot: the robot, n joints.
            bounds: its limits.
            harmonics: number of harmonics, at least 2.
            duration: period [s].
            samples: while optimising; 0 for 24 per period of the highest harmonic.
            start: where the motion begins and ends [rad or m], shape (n,); None for free.

        Raises:
            InputError: with too few harmonics: nothing moves that begins and ends at rest.
        """
        if harmonics < 2 or not 0.0 < duration < np.inf:
            raise InputError(f"{harmonics} harmonics in {duration:g} s: give at least 2 and a positive duration")
        self.robot, self.bounds, self.harmonics, self.period = robot, bounds, harmonics, duration
        self.samples = samples or 24 * harmonics
        self._start = None if start is None else np.asarray(start, dtype=float)
        ends = np.zeros((2, 2 * harmonics))
        ends[0, :harmonics] = 1.0
        ends[1, harmonics:] = np.arange(1, harmonics + 1)
        self._null = null_space(ends)
        self._coefficients = self._null.shape[1]
        self._own = self._coefficients + (start is None)
        self.size, self.free_duration = robot.n * self._own, False
        self.low, self.high = np.full(self.size, -np.inf), np.full(self.size, np.inf)
        self._bases: dict[int, tuple[Array, Array, Array]] = {}

    def random(self, draw: np.random.Generator, clear: Clear = everywhere) -> Array:
        """Random coefficients, as large as position and speed limits allow by half."""
        c = np.zeros((self.robot.n, self._own))
        c[:, : self._coefficients] = draw.standard_normal((self.robot.n, self._coefficients))
        moved = self.sample(c.ravel())
        reach = np.abs(moved.q - moved.q.mean(axis=0)).max(axis=0) / self.bounds.half
        fast = np.abs(moved.qd).max(axis=0) / self.bounds.speed
        strong = np.abs(moved.qdd).max(axis=0) / self.bounds.acceleration
        c /= (np.maximum(np.maximum(reach, fast), strong) / _SPAN)[:, None]
        if self._start is None:
            for _ in range(_TRIES):
                c[:, -1] = _SPAN * draw.uniform(-1.0, 1.0, self.robot.n)
                if clear((self.bounds.middle + self.bounds.half * c[:, -1])[None]):
                    break
        x = np.asarray(c.ravel())
        for _ in range(_SHRINKS):
            if clear(self.sample(x).q):
                break
            x.reshape(self.robot.n, -1)[:, : self._coefficients] *= 0.8
        return x

    def sample(self, x: Array, finer: int = 1) -> Samples:
        """States at even times of one period."""
        offset, c = self._unpacked(x)
        B, Bd, Bdd = self._basis(finer)
        count = len(B)
        return Samples(np.full(count, self.period / count), offset + B @ c.T, Bd @ c.T, Bdd @ c.T)

    def pullback(self, x: Array, slope: Samples) -> Array:
        """The Jacobian transposed times the slopes."""
        B, Bd, Bdd = self._basis(1)
        total = slope.q.sum(axis=0)
        by_c = slope.q.T @ B + slope.qd.T @ Bd + slope.qdd.T @ Bdd
        if self._start is not None:
            by_c -= total[:, None] * self._first
        own = (by_c @ self._null) * self.bounds.speed[:, None]
        if self._start is None:
            own = np.column_stack([own, total * self.bounds.half])
        return np.asarray(own.ravel())

    def jacobian(self, x: Array) -> Jacobian:
        """A joint's states depend on its own coefficients, always in the same way."""
        n, own = self.robot.n, self._own
        B = [basis @ self._null for basis in self._basis(1)]
        if self._start is not None:
            B[0] = B[0] - self._first @ self._null
        q, qd, qdd = np.zeros((3, len(B[0]), n, own))
        for into, basis in zip((q, qd, qdd), B, strict=True):
            into[..., : self._coefficients] = basis[:, None] * self.bounds.speed[:, None]
        if self._start is None:
            q[..., -1] = self.bounds.half
        columns = np.broadcast_to(np.arange(self.size).reshape(n, own), q.shape)
        return Jacobian(columns, q, qd, qdd, self.size)

    def plan(self, x: Array) -> Fourier:
        """The motion."""
        offset, c = self._unpacked(x)
        return Fourier(offset, c[:, : self.harmonics], c[:, self.harmonics :], self.period)

    def eased(self, x: Array, slower: float, smaller: float) -> Array:
        """Smaller about the middle of the range, or about the start pose; the period stays."""
        return np.asarray(x * (smaller / slower))

    @property
    def _first(self) -> Array:
        """What multiplies the coefficients in q at t = 0."""
        return np.asarray(fourier_basis(np.zeros(1), self.harmonics, self.period)[0][0])

    def _basis(self, finer: int) -> tuple[Array, Array, Array]:
        if finer not in self._bases:
            count = self.samples * finer
            self._bases[finer] = fourier_basis(np.arange(count) / count * self.period, self.harmonics, self.period)
        return self._bases[finer]

    def _unpacked(self, x: Array) -> tuple[Array, Array]:
        """Offsets (n,) and coefficients a, b (n, 2 H)."""
        own = x.reshape(self.robot.n, self._own)
        c = (own[:, : self._coefficients] @ self._null.T) * self.bounds.speed[:, None]
        if self._start is None:
            return self.bounds.middle + self.bounds.half * own[:, -1], c
        return self._start - c @ self._first, c
