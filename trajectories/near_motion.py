"""Motions about a pose: a Fourier series of some joints, the others held, perhaps once more about a second pose."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import null_space

from ..common.arrays import Array, frozen_array
from ..model import Motion
from .bounds import JointBounds
from .fourier import fourier_basis
from .limits import Slopes, State
from .samples import Clear, Jacobian, Samples, everywhere
from .segments import Quintic

_SPAN = 0.7  # of range, speed and acceleration that a random start uses
_SAMPLES = 16  # per period of the highest harmonic while optimising
_SHRINKS = 20


@dataclass(frozen=True)
class NearMotion:
    """The same periods of a Fourier series at one or two poses, at rest before and after each.

    Between poses it goes on straight lines in joint space, and at the end back to the first.

    Attributes:
        poses: where each series begins and ends [rad or m], poses x n.
        a, b: speed amplitudes of sine and cosine terms [rad/s or m/s], poses x n x harmonics.
        period: of the series [s].
        repeats: periods at each pose.
        transfer: duration of the way from one pose to the other [s]; 0 with one pose.
    """

    poses: Array
    a: Array
    b: Array
    period: float
    repeats: int
    transfer: float

    def __post_init__(self) -> None:
        """Lock the arrays and check them."""
        object.__setattr__(self, "poses", frozen_array(self.poses, (None, None), "poses"))
        shape = (*self.poses.shape, None)
        object.__setattr__(self, "a", frozen_array(self.a, shape, "a"))
        object.__setattr__(self, "b", frozen_array(self.b, self.a.shape, "b"))
        if not self.period > 0.0 or self.repeats < 1 or (self.transfer > 0.0) != (len(self.poses) > 1):
            raise ValueError("a motion near a pose needs a positive period, repeats, and transfers between poses")

    @property
    def duration(self) -> float:
        """From rest to rest, transfers included [s]."""
        count = len(self.poses)
        return count * (self.repeats * self.period + self.transfer)

    def motion(self, rate: float) -> Motion:
        """Sample the motion at ``rate`` [Hz]."""
        t = np.arange(int(self.duration * rate * (1.0 + 1e-12)) + 1) / rate
        return Motion(t, *self.at(t))

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Position, speed and acceleration at times [s], each (N, n); at rest before 0 and after the end."""
        t = np.clip(t, 0.0, self.duration)
        stay, count = self.repeats * self.period, len(self.poses)
        place = np.minimum((t / (stay + self.transfer)).astype(int), count - 1)
        own = t - place * (stay + self.transfer)
        q, qd, qdd = (np.empty((len(t), self.poses.shape[1])) for _ in range(3))
        for p, pose in enumerate(self.poses):
            here, away = (place == p) & (own <= stay), (place == p) & (own > stay)
            q[here], qd[here], qdd[here] = self._series(p, own[here])
            to = self.poses[(p + 1) % count]
            q[away], qd[away], qdd[away] = self._transfer(pose, to, np.minimum(own[away] - stay, self.transfer))
        return q, qd, qdd

    def slowed(self, speed: float) -> "NearMotion":
        """The same way once, at a fraction of the speed: to be watched before the real run."""
        slow = replace(self, a=self.a * speed, b=self.b * speed, period=self.period / speed)
        return replace(slow, repeats=1, transfer=self.transfer / speed)

    def _series(self, p: int, t: Array) -> tuple[Array, Array, Array]:
        B, Bd, Bdd = fourier_basis(t, self.a.shape[2], self.period)
        c = np.hstack([self.a[p], self.b[p]]).T
        first = fourier_basis(np.zeros(1), self.a.shape[2], self.period)[0]
        return self.poses[p] + (B - first) @ c, Bd @ c, Bdd @ c

    def _transfer(self, start: Array, end: Array, t: Array) -> tuple[Array, Array, Array]:
        if self.transfer == 0.0:
            return np.tile(start, (len(t), 1)), np.zeros((len(t), len(start))), np.zeros((len(t), len(start)))
        B, Bd, Bdd = (b[:, -1:] for b in Quintic().basis(t / self.transfer))
        way = (end - start)[None]
        return start + B * way, Bd * way / self.transfer, Bdd * way / self.transfer**2


class FreeNearMotion:
    """Motions about poses of a fixed period; q, qd and qdd of the series are linear in x."""

    def __init__(
        self,
        bounds: JointBounds,
        poses: Array,
        moving: Sequence[int],
        reach: Array,
        *,
        harmonics: int,
        period: float,
        repeats: int,
        transfer: float,
    ) -> None:
        """Set up the bases.

        Args:
            bounds: limits of the joints.
            poses: poses x n [rad or m].
            moving: positions of the joints that move, counted from 0.
            reach: how far each of them may go to either side [rad or m].
            harmonics: number of harmonics, at least 2.
            period, repeats, transfer: as of ``NearMotion``.
        """
        self.bounds, self.poses, self.moving, self.reach = bounds, poses, list(moving), reach
        self.harmonics, self.period, self.repeats, self.transfer = harmonics, period, repeats, transfer
        ends = np.zeros((2, 2 * harmonics))
        ends[0, :harmonics] = 1.0
        ends[1, harmonics:] = np.arange(1, harmonics + 1)
        self._null = null_space(ends)
        self._shape = (len(poses), len(self.moving), self._null.shape[1])
        self.size, self.free_duration = int(np.prod(self._shape)), False
        self.low, self.high = np.full(self.size, -np.inf), np.full(self.size, np.inf)
        self._bases: dict[int, tuple[Array, Array, Array]] = {}

    def random(self, draw: np.random.Generator, clear: Clear = everywhere) -> Array:
        """Random coefficients as large as range, speed and acceleration allow."""
        c = draw.standard_normal(self._shape)
        moved = self.sample(c.ravel())
        sizes = (self.reach, self.bounds.speed[self.moving], self.bounds.acceleration[self.moving])
        for p, own in enumerate(self._parts(len(moved.q))):
            offsets = moved.q[own][:, self.moving] - self.poses[p][self.moving]
            states = (offsets, moved.qd[own][:, self.moving], moved.qdd[own][:, self.moving])
            over = [np.abs(y).max(axis=0) / size for y, size in zip(states, sizes, strict=True)]
            c[p] *= (_SPAN / np.max(over, axis=0))[:, None]
        x = np.asarray(c.ravel())
        for _ in range(_SHRINKS):
            if clear(self.sample(x).q):
                break
            x = 0.8 * x
        return x

    def sample(self, x: Array, finer: int = 1) -> Samples:
        """States at even times of one period at each pose."""
        B, Bd, Bdd = self._basis(finer)
        count, size = len(B), (len(self.poses) * len(B), self.poses.shape[1])
        q, (qd, qdd) = np.repeat(self.poses, count, axis=0), np.zeros((2, *size))
        for own, c in zip(self._parts(size[0]), self._coefficients(x), strict=True):
            q[own, self.moving] += B @ c.T
            qd[own, self.moving], qdd[own, self.moving] = Bd @ c.T, Bdd @ c.T
        return Samples(np.full(size[0], self.period / count), q, qd, qdd)

    def pullback(self, x: Array, slope: Samples) -> Array:
        """The Jacobian transposed times the slopes."""
        B, Bd, Bdd = self._basis(1)
        parts = []
        for own in self._parts(len(slope.q)):
            q, qd, qdd = (y[own][:, self.moving] for y in slope[1:])
            parts.append((q.T @ B + qd.T @ Bd + qdd.T @ Bdd) @ self._null * self._scale[:, None])
        return np.asarray(np.stack(parts).ravel())

    def jacobian(self, x: Array) -> Jacobian:
        """A moving joint's states depend on its own coefficients at its pose, always in the same way."""
        count, own = len(self._basis(1)[0]), self._shape[2]
        shape = (len(self.poses) * count, self.poses.shape[1], own)
        columns, (q, qd, qdd) = np.full(shape, self.size), np.zeros((3, *shape))
        place = np.arange(self.size).reshape(self._shape)
        for p, part in enumerate(self._parts(shape[0])):
            columns[part, self.moving] = place[p]
            for into, basis in zip((q, qd, qdd), self._basis(1), strict=True):
                into[part, self.moving] = (basis @ self._null)[:, None] * self._scale[:, None]
        return Jacobian(columns, q, qd, qdd, self.size)

    def plan(self, x: Array) -> NearMotion:
        """The motion."""
        c = np.zeros((*self.poses.shape, 2 * self.harmonics))
        c[:, self.moving] = self._coefficients(x)
        a, b = c[..., : self.harmonics], c[..., self.harmonics :]
        return NearMotion(self.poses, a, b, self.period, self.repeats, self.transfer)

    def eased(self, x: Array, slower: float, smaller: float) -> Array:
        """Smaller about the poses; the period stays."""
        return np.asarray(x * (smaller / slower))

    @property
    def _scale(self) -> Array:
        """Coefficients of the order of 1 use the whole range at the first harmonics."""
        return np.asarray(np.minimum(self.bounds.speed[self.moving], 2.0 * np.pi / self.period * self.reach))

    def _coefficients(self, x: Array) -> Array:
        """a, b of the moving joints, poses x moving x 2 H."""
        return np.asarray((x.reshape(self._shape) @ self._null.T) * self._scale[:, None])

    def _parts(self, samples: int) -> list[slice]:
        """Each pose's own samples."""
        count = samples // len(self.poses)
        return [slice(p * count, (p + 1) * count) for p in range(len(self.poses))]

    def _basis(self, finer: int) -> tuple[Array, Array, Array]:
        """Bases at even times, the first sample at the pose."""
        if finer not in self._bases:
            count = _SAMPLES * self.harmonics * finer
            B, Bd, Bdd = fourier_basis(np.arange(count) / count * self.period, self.harmonics, self.period)
            self._bases[finer] = (B - B[:1], Bd, Bdd)
        return self._bases[finer]


class RangeLimit:
    """How far the moving joints go from the poses, within their own limits."""

    def __init__(self, family: FreeNearMotion) -> None:
        """``family``: whose poses and range."""
        self.name, self._moving = "position", family.moving
        low = np.maximum(family.poses[:, family.moving] - family.reach, family.bounds.low[family.moving])
        high = np.minimum(family.poses[:, family.moving] + family.reach, family.bounds.high[family.moving])
        self._middle, self._half = 0.5 * (low + high), 0.5 * (high - low)
        # The first pose's stand for all in messages; each sample is judged by its own.
        self.middle, self.unit = self._middle[0], self._half[0]
        self.low, self.high = -np.ones(len(family.moving)), np.ones(len(family.moving))

    def values(self, state: State) -> Array:
        """Distance from the range's middle, 1 at its ends."""
        middle, half = self._each(len(state.samples.q))
        return np.asarray((state.samples.q[:, self._moving] - middle) / half)

    def pullback(self, state: State, slope: Array, into: Slopes) -> None:
        """Into the positions."""
        _, half = self._each(len(state.samples.q))
        into.samples.q[:, self._moving] += slope / half

    def label(self, column: int) -> str:
        """The joint."""
        return f"joint {self._moving[column] + 1}"

    def _each(self, samples: int) -> tuple[Array, Array]:
        count = samples // len(self._middle)
        return np.repeat(self._middle, count, axis=0), np.repeat(self._half, count, axis=0)
