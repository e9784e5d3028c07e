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
    """Motion along one period of a Fourier series.

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
        """Duration of one period [s]."""
        return self.period

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Position, speed and acceleration at times [s], each (N, n); at rest before 0 and after one period."""
        B, Bd, Bdd = fourier_basis(np.clip(t, 0.0, self.period), self.a.shape[1], self.period)
        c = np.hstack([self.a, self.b]).T
        return self.offset + B @ c, Bd @ c, Bdd @ c


def fourier_basis(t: Array, harmonics: int, period: float) -> tuple[Array, Array, Array]:
    """Basis of a_1 ... a_H, b_1 ... b_H in q, qd and qdd, each (N, 2 H)."""
    wl = 2.0 * np.pi / period * np.arange(1, harmonics + 1)
    s, c = np.sin(wl * t[:, None]), np.cos(wl * t[:, None])
    return np.hstack([s / wl, -c / wl]), np.hstack([c, s]), np.hstack([-s * wl, c * wl])


class RestingSeries:
    """Family of Fourier series of a fixed period about poses, at rest and without acceleration at both ends.

    q, qd and qdd are linear in x.

    Attributes:
        null: coefficients a_1 ... a_H, b_1 ... b_H of each of the basis functions, 2 H x functions.
        first: what multiplies the coefficients in q at t = 0, shape (2 H,).
        moving: the joints that move; the others stay at rest.
    """

    moving: slice | list[int] = slice(None)

    def __init__(
        self, harmonics: int, period: float, samples: int, poses: Array, scale: Array, half: Array | None = None
    ) -> None:
        """Set up at least two ``harmonics`` in a ``period`` [s].

        Args:
            samples: of a period while optimising.
            poses: where each series begins, poses x n.
            scale: of the coefficients of the joints that move, shape (moving,).
            half: range about ``poses`` in which the mean position is free, shape (n,), x holding it behind the
                functions' weights; None where the series begin at ``poses``.
        """
        ends = np.zeros((2, 2 * harmonics))
        ends[0, :harmonics] = 1.0
        ends[1, harmonics:] = np.arange(1, harmonics + 1)
        self.null = np.linalg.svd(ends)[2][2:].T  # what leaves both ends as they are
        self.first = fourier_basis(np.zeros(1), harmonics, period)[0][0]
        self._harmonics, self._period, self._samples = harmonics, period, samples
        self._poses, self._scale, self._half = poses, scale, half
        self._grids: dict[int, tuple[Array, Array, Array]] = {}
        self._shape = (len(poses), len(scale), self.null.shape[1] + (half is not None))
        self.size = int(np.prod(self._shape))
        self.low, self.high = np.full(self.size, -np.inf), np.full(self.size, np.inf)

    def sample(self, x: Array, finer: int = 1) -> Samples:
        """Evaluate states at even times of one period at each pose."""
        about, c = self._unpacked(x)
        grid = self._grid(finer)
        poses, n, count = *about.shape, len(grid[0])
        q, qd, qdd = np.zeros((3, poses, count, n))
        q += about[:, None]
        for states, basis in zip((q, qd, qdd), grid, strict=True):
            states[:, :, self.moving] += basis @ c.transpose(0, 2, 1)
        weight = np.full(poses * count, self._period / count)
        return Samples(weight, *(states.reshape(-1, n) for states in (q, qd, qdd)))

    def pullback(self, x: Array, slope: Samples) -> Array:
        """Apply the Jacobian transposed to the slopes."""
        gradient, (B, Bd, Bdd) = np.empty(self._shape), self._grid(1)
        for own, q, qd, qdd in zip(gradient, *self._at_poses(slope), strict=True):
            by_weights = (q.T @ B + qd.T @ Bd + qdd.T @ Bdd) @ self.null
            own[:, : self.null.shape[1]] = by_weights * self._scale[:, None]
            if self._half is not None:
                own[:, -1] = q.sum(axis=0) * self._half
        return gradient.ravel()

    def eased(self, x: Array, slower: float, smaller: float) -> Array:
        """Shrink the motion about what q counts from; the period stays."""
        return np.asarray(x * (smaller / slower))

    def _grid(self, finer: int) -> tuple[Array, Array, Array]:
        """Basis of the coefficients in q, qd and qdd at even times of one period, each (N, 2 H)."""
        if finer not in self._grids:
            count = self._samples * finer
            B, Bd, Bdd = fourier_basis(np.arange(count) / count * self._period, self._harmonics, self._period)
            self._grids[finer] = (B - self.first if self._half is None else B, Bd, Bdd)
        return self._grids[finer]

    def _unpacked(self, x: Array) -> tuple[Array, Array]:
        """Unpack what q counts from, poses x n, and a, b of the joints that move, poses x moving x 2 H."""
        weights = x.reshape(self._shape)
        c = (weights[..., : self.null.shape[1]] @ self.null.T) * self._scale[:, None]
        return self._poses if self._half is None else self._poses + self._half * weights[..., -1], c

    def _at_poses(self, samples: Samples) -> list[Array]:
        """Evaluate states of the joints that move, pose by pose, each poses x N x moving."""
        states = (x.reshape(len(self._poses), -1, x.shape[1]) for x in samples[1:])
        return [x[..., self.moving] for x in states]


@dataclass(frozen=True)
class FourierShape:
    """Shape of a Fourier series of a fixed duration.

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
        """Make the family of motions of this shape."""
        return FreeFourier(bounds, self)


class FreeFourier(RestingSeries):
    """Family of Fourier series of all joints about a middle that is free, or from a given start."""

    def __init__(self, bounds: JointBounds, shape: FourierShape) -> None:
        """Lay out x.

        Raises:
            InputError: with too few harmonics: nothing moves that begins and ends at rest; for a start
                beyond limits.
        """
        start = checked_start(bounds, shape.start)
        harmonics, period = shape.harmonics, shape.duration
        if not 2 <= harmonics <= _MOST or not 0.0 < period <= LONGEST:
            raise InputError(
                f"{harmonics} harmonics in {period:g} s: give at least 2, at most {_MOST}, in up to {LONGEST:g} s"
            )
        poses, half = (bounds.middle, bounds.half) if start is None else (start, None)
        samples = shape.samples or _SAMPLES * harmonics
        super().__init__(harmonics, period, samples, poses[None], bounds.speed, half)
        self._bounds, self.reach = bounds, (bounds.low, bounds.high)

    def random(self, draw: np.random.Generator, clear: Clear = everywhere) -> Array:
        """Draw random coefficients, as large as position and speed limits allow by half."""
        bounds, (_, n, _), size = self._bounds, self._shape, self.null.shape[1]
        c = np.zeros(self._shape[1:])
        c[:, :size] = draw.standard_normal((n, size))
        moved = self.sample(c.ravel())
        reach = np.abs(moved.q - moved.q.mean(axis=0)).max(axis=0) / bounds.half
        fast = np.abs(moved.qd).max(axis=0) / bounds.speed
        strong = np.abs(moved.qdd).max(axis=0) / bounds.acceleration
        c /= (np.maximum(np.maximum(reach, fast), strong) / _SPAN)[:, None]
        for _ in range(_TRIES) if self._half is not None else ():
            c[:, -1] = _SPAN * draw.uniform(-1.0, 1.0, n)
            if clear((bounds.middle + bounds.half * c[:, -1])[None]):
                break
        for _ in range(_SHRINKS):
            if clear(self.sample(c.ravel()).q):
                break
            c[:, :size] *= 0.8
        return np.asarray(c.ravel())

    def plan(self, x: Array) -> Fourier:
        """Make the motion."""
        (about,), (c,) = self._unpacked(x)
        a, b = np.hsplit(c, 2)
        return Fourier(about if self._half is not None else about - c @ self.first, a, b, self._period)
