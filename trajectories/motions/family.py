"""Motions made of pieces, and the families of them among which a design chooses.

In a piece q = start + B(s) C with s = t / T from 0 to 1: a basis in unit time, coefficients C and a duration T.
From that follow, alike for every kind of motion, its states, an optimiser's samples, and their exact gradients.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...common import Array, Brief, InputError
from ...model import Motion, Robot

Clear = Callable[[Array], bool]  # function that is true if the robot may take all of some poses, (N, n) [rad or m]
Factors = Array
"""Basis at some s: factors of the coefficients in q, in T qd and in T^2 qdd, (3, N, m)."""
Grid = tuple[Array, Factors]
"""Samples of a piece: the fraction of its time that each stands for, shape (N,), and the basis there."""
_END = 1e-12  # of the duration: what rounding may keep the last sample from falling on the end
LONGEST = 3600.0  # longest duration of a motion that is designed [s]
_TRIES = 100  # to find a pose that is clear
_MOST = 10_000_000  # samples of a motion: eleven hours at 250 Hz; memory would not hold much more


def sample_count(duration: float, rate: float) -> int:
    """Count samples of a motion of so many seconds at ``rate`` [Hz], its end included where one falls on it."""
    if not duration * rate < _MOST:
        raise InputError(
            f"a motion of {duration:g} s at {rate:g} Hz has more than {_MOST} samples: make it shorter"
        )
    return int(duration * rate * (1.0 + _END)) + 1


@dataclass(frozen=True, eq=False, repr=False)
class JointBounds(Brief):
    """Limits of all joints, each of shape (n,).

    Attributes:
        low, high: positions [rad or m].
        speed: [rad/s or m/s].
        acceleration: [rad/s^2 or m/s^2].
        torque: [N·m or N], infinite where there is none.
    """

    low: Array
    high: Array
    speed: Array
    acceleration: Array
    torque: Array

    @staticmethod
    def of(
        robot: Robot,
        *,
        override: float = 1.0,
        acceleration: Sequence[float] | None = None,
        torque: Sequence[float] | None = None,
    ) -> "JointBounds":
        """Collect the limits of a robot.

        Args:
            override: fraction of the nominal speed that may be used, as on a controller.
            acceleration: instead of the description's [rad/s^2 or m/s^2].
            torque: instead of the description's [N·m or N].

        Raises:
            InputError: if a limit is missing or does not fit.
        """
        if not 0.0 < override <= 1.0:
            raise InputError(f"the speed override is {override:g}: give a fraction above 0, at most 1")
        kinds = ("position", "speed", "acceleration", "torque")
        limits = {kind: np.array([getattr(joint.limits, kind) for joint in robot.joints]) for kind in kinds}
        for kind, values in (("acceleration", acceleration), ("torque", torque)):
            if values is not None:
                limits[kind] = np.array(values, dtype=float)
                if limits[kind].shape != (robot.n,) or not (limits[kind] > 0.0).all():
                    fault = f"{kind} limits {values} do not fit"
                    raise InputError(f"{fault}: robot {robot.name!r} needs {robot.n} positive numbers")
        for kind in kinds[:3]:
            finite = np.isfinite(limits[kind]).reshape(robot.n, -1).all(axis=1)
            if missing := ", ".join(str(j + 1) for j in np.flatnonzero(~finite)):
                fault = f"robot {robot.name!r} has no {kind} limit for joint {missing}"
                raise InputError(f"{fault}: a motion cannot be designed; add it to the description")
        low, high = limits["position"].T
        return JointBounds(low, high, override * limits["speed"], limits["acceleration"], limits["torque"])

    @property
    def middle(self) -> Array:
        """Middle of the position range [rad or m]."""
        return np.asarray(0.5 * (self.low + self.high))

    @property
    def half(self) -> Array:
        """Half of the position range [rad or m]."""
        return np.asarray(0.5 * (self.high - self.low))


def check_pose(pose: Array, robot: Robot, bounds: JointBounds) -> None:
    """Refuse a pose [rad or m] that is not within the limits."""
    if pose.shape == (robot.n,) and ((pose >= bounds.low) & (pose <= bounds.high)).all():
        return
    shown, ranges = f"of {len(pose)} numbers", list[str]()
    if len(pose) == robot.n:
        scales = np.array([180.0 / np.pi if joint.revolute else 1.0 for joint in robot.joints])
        shown = ", ".join(f"{x:g}" for x in scales * pose)
        for j in np.flatnonzero(~((pose >= bounds.low) & (pose <= bounds.high))):
            low, high = (scales[j] * end[j] for end in (bounds.low, bounds.high))
            ranges.append(f" (joint {j + 1}: {low:.4g} to {high:.4g}{' deg' * robot.joints[j].revolute})")
    fault = f"the pose {shown} must be {robot.n} positions within the limits of {robot.name}"
    raise InputError(fault + ", ".join(ranges))


class Samples(NamedTuple):
    """States with the time that each stands for, and a regressor there; or slopes of one number in all of them.

    ``weight`` (N,) [s]; ``q``, ``qd``, ``qdd`` (N, n) [rad or m, per second, per second squared]; ``entries`` of
    the regressor that are not zero, (entries, N), by a sign smoothed over ``width`` [rad/s or m/s], 0 for exact.
    """

    weight: Array
    q: Array
    qd: Array
    qdd: Array
    entries: Array = np.zeros((0, 0))
    width: Array = np.zeros(1)

    @staticmethod
    def at_rest(poses: Array) -> "Samples":
        """Stand still in poses (N, n), for a second in each."""
        return Samples(np.ones(len(poses)), poses, np.zeros_like(poses), np.zeros_like(poses))

    @staticmethod
    def of(motion: Motion) -> "Samples":
        """Take a motion's samples, each for its part of the time by the trapezoidal rule."""
        step = np.diff(motion.t, prepend=motion.t[0], append=motion.t[-1])
        return Samples(0.5 * (step[:-1] + step[1:]), motion.q, motion.qd, motion.qdd)


class Pieces(NamedTuple):
    """Pieces of a motion, one after the other."""

    start: Array  # position at the beginning of each [rad or m], K x n
    coefficients: Array  # of the basis [rad or m], K x m x n
    durations: Array  # [s], shape (K,)
    basis: Callable[[Array], Factors]  # in unit time, zero in q at s = 0

    def sampled(self, grid: Grid) -> Samples:
        """Evaluate the states on the same grid in each piece."""
        weights, (B, Bd, Bdd) = grid
        C, T, n = self.coefficients, self.durations[:, None, None], self.start.shape[1]
        q, qd, qdd = self.start[:, None] + B @ C, (Bd @ C) / T, (Bdd @ C) / T**2
        weight = self.durations[:, None] * weights
        return Samples(weight.ravel(), q.reshape(-1, n), qd.reshape(-1, n), qdd.reshape(-1, n))

    def pullback(self, grid: Grid, slope: Samples) -> tuple[Array, Array, Array]:
        """Gradient in start, coefficients and durations of a number whose gradient in the samples is ``slope``."""
        weights, (B, Bd, Bdd) = grid
        C, T = self.coefficients, self.durations[:, None, None]
        q, qd, qdd = (x.reshape(len(T), len(weights), -1) for x in slope[1:4])
        by_speed, by_acceleration = Bd.T @ (qd / T), Bdd.T @ (qdd / T**2)
        by_duration = slope.weight.reshape(len(T), -1) @ weights
        by_duration -= np.einsum("kmn,kmn->k", by_speed + 2.0 * by_acceleration, C) / self.durations
        return q.sum(axis=1), B.T @ q + by_speed + by_acceleration, by_duration


class Plan:
    """Motion to be run: it starts and ends at rest. A kind of motion says what its pieces are."""

    @cached_property
    def pieces(self) -> Pieces:
        """Make the pieces."""
        raise NotImplementedError(f"{type(self).__name__} is not made of pieces")

    @property
    def duration(self) -> float:
        """Time from rest to rest [s]."""
        return float(self.pieces.durations.sum())

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Position, speed and acceleration at times [s], each (N, n); at rest before 0 and after ``duration``."""
        pieces = self.pieces
        knots = np.concatenate([[0.0], np.cumsum(pieces.durations)])
        inside = np.clip(t, 0.0, knots[-1])
        k = np.clip(np.searchsorted(knots, inside, side="right") - 1, 0, len(pieces.durations) - 1)
        T, moves = pieces.durations[k][:, None], (t == inside)[:, None]
        factors = pieces.basis(np.clip((inside - knots[k]) / T[:, 0], 0.0, 1.0))
        q, qd, qdd = (np.einsum("Nm,Nmn->Nn", B, pieces.coefficients[k]) for B in factors)
        return pieces.start[k] + q, qd / T * moves, qdd / T**2 * moves

    def motion(self, rate: float) -> Motion:
        """Sample the motion at ``rate`` [Hz], its end included where a sample falls on it."""
        t = np.arange(sample_count(self.duration, rate)) / rate
        return Motion(t, *self.at(t))


class FreeStates:
    """Family of weighted sets of states, each within the joints' limits by itself; a set is no motion.

    x holds q, qd and qdd of each state over their limits, then the logs of the weights, which share one second.
    """

    def __init__(self, bounds: JointBounds, count: int) -> None:
        n = len(bounds.low)
        self._middle, self.reach, self._shape = bounds.middle, (bounds.low, bounds.high), (3, count, n)
        self._unit = np.stack([bounds.half, bounds.speed, bounds.acceleration])[:, None]
        self._linear, self.size = 3 * count * n, 3 * count * n + count
        self.low, self.high = -np.ones(self.size), np.ones(self.size)
        self.low[self._linear :], self.high[self._linear :] = -8.0, 8.0

    def random(self, draw: np.random.Generator, clear: Clear = lambda _: True) -> Array:
        """Draw random poses; speeds and accelerations mostly large."""
        x = np.zeros(self.size)
        states = x[: self._linear].reshape(self._shape)
        states[...] = draw.uniform(-1.0, 1.0, states.shape)
        states[1:] = np.sign(states[1:]) * np.sqrt(np.abs(states[1:]))
        for pose in states[0]:
            for _ in range(_TRIES):
                if clear(self._middle + self._unit[0] * pose):
                    break
                pose[...] = draw.uniform(-1.0, 1.0, len(pose))
        return x

    def sample(self, x: Array, finer: int = 1) -> Samples:
        """Take the states; there is nothing between them."""
        (q, qd, qdd), logs = self._unit * x[: self._linear].reshape(self._shape), x[self._linear :]
        weight = np.exp(logs - logs.max())
        return Samples(weight / weight.sum(), self._middle + q, qd, qdd)

    def pullback(self, x: Array, slope: Samples) -> Array:
        """Apply the Jacobian transposed to the slopes."""
        w = self.sample(x).weight
        return np.concatenate([(np.stack(slope[1:4]) * self._unit).ravel(), w * (slope.weight - w @ slope.weight)])
