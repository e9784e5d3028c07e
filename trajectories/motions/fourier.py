"""Fourier motions (Swevers et al. 1997): periodic, at rest without acceleration where they begin and end.

q(t) = q0 + sum_l (a_l / (w l) sin(w l t) - b_l / (w l) cos(w l t)), w = 2 pi / period. Speed and acceleration at
both ends vanish if and only if sum a_l = 0 and sum l b_l = 0; the free parameters are coordinates in the null space
of these equations, so that every x satisfies them. Such a series moves all joints about a pose that is chosen with
it, or some joints near one given pose or two.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial

import numpy as np

from ...common import Array, Brief, InputError, freeze_fields
from ...model import Robot
from ...model.base import PayloadVisibility, checked_joints, payload_visibility
from .family import LONGEST, Clear, Factors, Grid, JointBounds, Pieces, Plan, Samples, check_pose
from .via_points import QUINTIC, quickest

_MOST = 50  # harmonics: a search takes half an hour then
_TRIES, _SHRINKS = 200, 20  # to find a middle that is clear, and a motion about it
_SPAN = 0.5  # of the range that a random middle uses
_PERIOD = 7.5  # s: about how long a series near a pose lasts before it is repeated
_SHORTEST = 1.0  # s: at each pose
_TRANSFER_SPEED = 0.5  # of the limits
_TRANSFER_MORE = 0.01  # s: beyond the shortest transfer, so that rounding breaks no limit


def _series(s: Array, harmonics: int) -> Factors:
    """Factors of period a_1 .. a_H and period b_1 .. b_H, q counted from s = 0."""
    wl = 2.0 * np.pi * np.arange(1, harmonics + 1)
    sin, cos = np.sin(wl * s[:, None]), np.cos(wl * s[:, None])
    return np.concatenate([[sin / wl, cos, -sin * wl], [(1.0 - cos) / wl, sin, cos * wl]], axis=2)


def _from_offset(b: Array, period: float) -> Array:
    """Distance of a series' beginning from its offset q0, by the b (.., harmonics)."""
    return np.asarray(-period / (2.0 * np.pi) * (b / np.arange(1, b.shape[-1] + 1)).sum(axis=-1))


@dataclass(frozen=True, eq=False, repr=False)
class Fourier(Plan, Brief):
    """Motion along equal periods of a Fourier series at one or two poses, at rest before and after each.

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
    repeats: int = 1
    transfer: float = 0.0

    def __post_init__(self) -> None:
        shape = np.shape(self.a)
        freeze_fields(self, poses=shape[:2], a=(None, None, None), b=shape)
        if not 0.0 < self.period < np.inf or self.repeats < 1 or (self.transfer > 0.0) != (len(self.poses) > 1):
            raise ValueError("a Fourier motion needs a positive period, repeats, and transfers between poses")

    @property
    def offset(self) -> Array:
        """Offset q0 of each series [rad or m], poses x n."""
        return self.poses - _from_offset(self.b, self.period)

    @cached_property
    def pieces(self) -> Pieces:
        """Periods at each pose, and the way to the other: a quintic's step stands behind the series' factors."""
        count, n, harmonics = self.a.shape
        C = self.period * np.concatenate([self.a, self.b], axis=2).swapaxes(1, 2)
        series, way = np.pad(C, ((0, 0), (0, 1), (0, 0))), np.zeros((count, 2 * harmonics + 1, n))
        way[:, -1] = np.roll(self.poses, -1, axis=0) - self.poses
        ways = count > 1
        coefficients = np.stack([*[series] * self.repeats, *[way] * ways], axis=1)
        durations = np.tile([*[self.period] * self.repeats, *[self.transfer] * ways], count)

        def basis(s: Array) -> Factors:
            return np.concatenate([_series(s, harmonics), QUINTIC.basis(s)[..., -1:]], axis=2)

        start = np.repeat(self.poses, self.repeats + ways, axis=0)
        return Pieces(start, coefficients.reshape(len(start), -1, n), durations, basis)

    def slowed(self, speed: float) -> "Fourier":
        """Slow one period down to a fraction of the speed, the same way: to be watched before the real run."""
        slow = replace(self, a=self.a * speed, b=self.b * speed, period=self.period / speed)
        return replace(slow, repeats=1, transfer=self.transfer / speed)


@dataclass(frozen=True)
class FourierShape:
    """Shape of a Fourier series of a fixed duration.

    Attributes:
        duration: period [s].
        start: where it begins and ends [rad or m], n numbers; None for anywhere.
    """

    harmonics: int = 5
    duration: float = 10.0
    start: tuple[float, ...] | None = None

    samples = 24  # per period of the highest harmonic while optimising
    span = 0.5  # of range, speed and acceleration that a random motion uses at first

    def __post_init__(self) -> None:
        if not 2 <= self.harmonics <= _MOST or not 0.0 < self.duration <= LONGEST:
            given = f"{self.harmonics} harmonics in {self.duration:g} s"
            raise InputError(f"{given}: give at least 2, at most {_MOST}, in up to {LONGEST:g} s")

    def family(self, robot: Robot, bounds: JointBounds) -> "FreeSeries":
        """Make the family of motions of this shape: about a middle that is free, or from a start within limits."""
        if self.start is not None:
            check_pose(np.asarray(self.start, dtype=float), robot, bounds)
        return FreeSeries(self, bounds)


@dataclass(frozen=True, eq=False, repr=False)
class NearShape(Brief):
    """Shape of a motion about one pose or two.

    Attributes:
        poses: where the robot stands [rad or m], shape (1 or 2, n).
        joints: numbers of the joints that move.
        ranges: how far each of them goes to either side [rad or m], shape (k,).
        duration: of the motion, the ways between two poses included [s].
    """

    poses: Array
    joints: tuple[int, ...]
    ranges: Array
    duration: float

    harmonics, samples, span = 8, 16, 0.7  # as of a ``FourierShape``
    mass_alike = 1.0

    def check(self, robot: Robot, bounds: JointBounds) -> None:
        """Refuse what the robot cannot do."""
        moving = checked_joints(robot, self.joints)
        if len(self.ranges) != len(moving) or not (self.ranges > 0.0).all() or not np.isfinite(self.ranges).all():
            raise InputError(f"the range must be one positive number, or one for each of {len(moving)} joints")
        if not 0.0 < self.duration <= LONGEST:
            raise InputError(f"a duration of {self.duration:g} s: give a positive one, at most {LONGEST:g} s")
        for pose in self.poses:
            check_pose(pose, robot, bounds)

    def family(self, robot: Robot, bounds: JointBounds) -> "FreeSeries":
        """Make the family of motions of this shape: the duration divided among poses, periods and ways between.

        Raises:
            InputError: if the duration leaves no time beside the way between two poses.
        """
        self.check(robot, bounds)
        return FreeSeries(self, bounds)

    def visibility(self, robot: Robot) -> PayloadVisibility:
        """Visibility of the payload in torques near the poses, before any motion."""
        return payload_visibility(robot, list(self.poses), self.joints, self.ranges.tolist())


@lru_cache(maxsize=64)
def _grid(harmonics: int, samples: int) -> Grid:
    return np.full(samples, 1.0 / samples), _series(np.arange(samples) / samples, harmonics)


class FreeSeries:
    """Family of Fourier series of a fixed period about poses; q, qd and qdd are linear in x.

    x holds, for each pose and joint that moves, weights of functions that begin and end at rest; then, where the
    middle is free, how far q0 is from it. Periods, repeats and transfer are as of a ``Fourier``.
    """

    def __init__(self, shape: FourierShape | NearShape, bounds: JointBounds) -> None:
        self.shape, self.bounds, self.harmonics = shape, bounds, shape.harmonics
        self.repeats, self.transfer = 1, 0.0
        self.free_middle = isinstance(shape, FourierShape) and shape.start is None
        if isinstance(shape, NearShape):
            self.poses, self.moving, self.ranges = shape.poses, [joint - 1 for joint in shape.joints], shape.ranges
            if len(self.poses) > 1:
                way = quickest(np.diff(self.poses, axis=0), _TRANSFER_SPEED * bounds.speed, bounds.acceleration)
                self.transfer = float(way[0]) + _TRANSFER_MORE
            stay = shape.duration / len(self.poses) - self.transfer
            if stay < _SHORTEST:
                left = f"{shape.duration:g} s leave {stay:.1f} s at each pose beside the way between them"
                raise InputError(f"{left}: give a longer --duration")
            self.repeats = max(1, round(stay / _PERIOD))
            self.period = stay / self.repeats
            # Weights of the order of 1 use the range at the first harmonics.
            self._scale = np.minimum(bounds.speed[self.moving], 2.0 * np.pi / self.period * self.ranges)
        else:
            about = bounds.middle if shape.start is None else np.asarray(shape.start, dtype=float)
            self.poses, self.moving, self.period = about[None], list(range(len(about))), shape.duration
            self.ranges, self._scale = np.maximum(bounds.high - about, about - bounds.low), bounds.speed
        ends = np.zeros((2, 2 * self.harmonics))
        ends[0, : self.harmonics], ends[1, self.harmonics :] = 1.0, np.arange(1, self.harmonics + 1)
        self.functions = np.asarray(np.linalg.svd(ends)[2][2:].T)
        self.layout = len(self.poses), len(self.moving), self.functions.shape[1] + self.free_middle
        self.size = int(np.prod(self.layout))
        self.low, self.high = np.full(self.size, -np.inf), np.full(self.size, np.inf)
        self._offsets = _from_offset(np.eye(self.harmonics), self.period)
        # The range of each moving joint about each pose, within its limits; any for joints at rest.
        self.reach = low, high = self.poses - 1.0, self.poses + 1.0
        low[:, self.moving] = np.maximum(self.poses[:, self.moving] - self.ranges, bounds.low[self.moving])
        high[:, self.moving] = np.minimum(self.poses[:, self.moving] + self.ranges, bounds.high[self.moving])

    def _pieces(self, x: Array) -> Pieces:
        weights, F = x.reshape(self.layout), self.functions
        c = (weights[..., : F.shape[1]] @ F.T) * self._scale[:, None]
        C = np.zeros((len(self.poses), 2 * self.harmonics, self.poses.shape[1]))
        C[:, :, self.moving] = self.period * c.swapaxes(1, 2)
        start = self.poses
        if self.free_middle:
            offset = start + self.ranges * weights[..., -1]
            start = offset + _from_offset(c[..., self.harmonics :], self.period)
        periods = np.full(len(start), self.period)
        return Pieces(start, C, periods, partial(_series, harmonics=self.harmonics))

    def sample(self, x: Array, finer: int = 1) -> Samples:
        """Evaluate states at even times of one period at each pose."""
        return self._pieces(x).sampled(_grid(self.harmonics, finer * self.harmonics * self.shape.samples))

    def pullback(self, x: Array, slope: Samples) -> Array:
        """Apply the Jacobian transposed to the slopes."""
        grid = _grid(self.harmonics, self.harmonics * self.shape.samples)
        by_start, by_C, _ = self._pieces(x).pullback(grid, slope)
        gradient, count = np.empty(self.layout), self.functions.shape[1]
        by_c = self.period * by_C[:, :, self.moving].swapaxes(1, 2)
        if self.free_middle:
            by_c[..., self.harmonics :] += by_start[..., None] * self._offsets
            gradient[..., -1] = by_start * self.ranges
        gradient[..., :count] = by_c @ self.functions * self._scale[:, None]
        return gradient.ravel()

    def random(self, draw: np.random.Generator, clear: Clear = lambda _: True) -> Array:
        """Draw random weights, as large as a first motion may be; then a middle; smaller until it is clear."""
        weights, count = np.zeros(self.layout), self.functions.shape[1]
        weights[..., :count] = draw.standard_normal((*self.layout[:2], count))
        states = np.stack(self.sample(weights.ravel())[1:4]).reshape(3, len(self.poses), -1, self.poses.shape[1])
        states[0] -= self.poses[:, None]
        most = [self.ranges, self.bounds.speed[self.moving], self.bounds.acceleration[self.moving]]
        used = (np.abs(states[..., self.moving]).max(axis=2) / np.array(most)[:, None]).max(axis=0)
        weights[..., :count] *= self.shape.span / used[..., None]
        if self.free_middle:
            for _ in range(_TRIES):
                weights[..., -1] = _SPAN * draw.uniform(-1.0, 1.0, self.layout[1])
                if clear(self.poses + self.ranges * weights[..., -1]):
                    break
        for _ in range(_SHRINKS):
            if clear(self.sample(weights.ravel()).q):
                break
            weights[..., :count] *= 0.8
        return weights.ravel()

    def plan(self, x: Array) -> Fourier:
        """Make the motion."""
        start, C, *_ = self._pieces(x)
        a, b = np.split(C.swapaxes(1, 2) / self.period, 2, axis=2)
        return Fourier(start, a, b, self.period, self.repeats, self.transfer)

    def eased(self, x: Array, slower: float, smaller: float) -> Array:
        """Shrink the motion about what q counts from; the period stays."""
        return np.asarray(x * (smaller / slower))
