"""Designed motions through points: via points, and rests in poses.

A segment between two points is a quintic, or a trapezoid of speed that rests at both ends. Its coefficients are
T v0, T^2 a0, T^2 a1 and T v1 at its ends, and the step p1 - p0: a joint that stays put does so exactly.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np

from ...common import Array, Brief, Indices, InputError, Mask, freeze_fields
from ...model import Robot
from ...model.base import PayloadVisibility, visibility_in_states
from .family import LONGEST, Clear, Factors, Grid, JointBounds, Pieces, Plan, Samples, check_pose

_MOST = 500  # points: a search takes half an hour then
_TRIES = 200  # to find a point or a pose that can be reached
_SPAN = 0.75  # of the range that random points and poses use
_SLOWER = 1.3  # start: so many times the shortest durations
_PARTS = 12  # of a segment between samples while optimising, about
_DURATIONS = (0.1, 3.0)  # s: shortest and longest time from point to point
_POWERS = np.array([1.0, 2.0, 2.0, 1.0, 0.0])  # of T, in the coefficients of a segment
_REST_POSES = 6, 12  # fewer leave no spread to judge them by, more take longer than a motion that tells more
_HOLD = 1.0, 10.0  # s: what settles, and what more does not average
_LOOKS = 6  # samples of the way to a pose while optimising
_SPEED = 0.5  # of the limits
_LEAST = 1.0  # s: of each move
_SLOWEST = 20.0  # times as long as that takes
_PASSING = 1e-9  # s: weight of a sample on the way; no weight at all has no slope
_STATES = 60  # random ones, for what can be seen at rest
_SIDES = np.array([-1.0, 0.0, 1.0, 0.0])  # of a pose, by approaches: from below, there, from above, there

# Quintic Hermite polynomials on 0 <= s <= 1: row k holds the factors of 1, s, ..., s^5 in coefficient k.
_HERMITE = np.array(
    [
        [0.0, 1.0, 0.0, -6.0, 8.0, -3.0],
        [0.0, 0.0, 0.5, -1.5, 1.5, -0.5],
        [0.0, 0.0, 0.0, 0.5, -1.0, 0.5],
        [0.0, 0.0, 0.0, -4.0, 7.0, -3.0],
        [0.0, 0.0, 0.0, 10.0, -15.0, 6.0],
    ]
)


@dataclass(frozen=True)
class Quintic:
    """Quintic segment between position, speed and acceleration at both ends."""

    name = "quintic"
    passes = True
    peak_speed = 15.0 / 8.0
    peak_acceleration = 10.0 / 3.0**0.5
    phases = (0.0, 1.0)

    def basis(self, s: Array, phase: Indices | None = None) -> Factors:
        """Evaluate the Hermite polynomials."""
        powers, k = s[:, None] ** np.arange(6), np.arange(1, 6)
        first, second = np.zeros_like(powers), np.zeros_like(powers)
        first[:, 1:] = k * powers[:, :5]
        second[:, 2:] = k[1:] * k[:4] * powers[:, :4]
        return np.asarray(np.stack([powers, first, second]) @ _HERMITE.T)


QUINTIC = Quintic()


@dataclass(frozen=True)
class Trapezoid:
    """Trapezoidal segment: a ramp to constant speed and a ramp down, as in a controller's synchronised joint move.

    It rests at both ends. All joints follow one law q0 + (q1 - q0) f(t / T), with constant acceleration in a phase.

    Attributes:
        ramp: fraction of the time that each of the two ramps takes, above 0, at most 0.5 (no constant speed then).

    Raises:
        InputError: if the ramp is out of range.
    """

    ramp: float = 0.25

    name = "trapezoid"
    passes = False

    def __post_init__(self) -> None:
        if not 0.0 < self.ramp <= 0.5:
            raise InputError(f"a ramp of {self.ramp:g} of a move's time: give a share above 0, at most 0.5")

    @property
    def peak_speed(self) -> float:
        """Peak speed, reached over the whole constant phase."""
        return 1.0 / (1.0 - self.ramp)

    @property
    def peak_acceleration(self) -> float:
        """Peak acceleration, held over the whole ramps."""
        return 1.0 / (self.ramp * (1.0 - self.ramp))

    @property
    def phases(self) -> tuple[float, ...]:
        """Times at which the ramp up, the constant speed and the ramp down begin and end, where they last."""
        return (0.0, self.ramp, 1.0 - self.ramp, 1.0) if self.ramp < 0.5 else (0.0, 0.5, 1.0)

    def basis(self, s: Array, phase: Indices | None = None) -> Factors:
        """Evaluate the basis in the ``phases`` with these indices.

        Without them a step of the acceleration has its value after the step, and s = 1 that before.
        """
        if phase is None:
            phase = np.searchsorted(self.phases[1:-1], s, side="right")
        v, a, left = self.peak_speed, self.peak_acceleration, 1.0 - s
        up, down = phase == 0, phase == len(self.phases) - 2
        f = np.select([up, down], [0.5 * a * s**2, 1.0 - 0.5 * a * left**2], v * (s - 0.5 * self.ramp))
        slope = np.select([up, down], [a * s, a * left], v)
        curve = np.select([up, down], [a, -a], 0.0)
        return np.asarray(np.stack([f, slope, curve])[..., None] * [0.0, 0.0, 0.0, 0.0, 1.0])


Segment = Quintic | Trapezoid
"""Segment between points: its name, whether it ``passes`` points in motion, the peak speed and acceleration of a
step of 1 in unit time, at rest at both ends, and its ``phases`` of smooth acceleration."""


@lru_cache(maxsize=64)
def _grid(segment: Segment, parts: int) -> Grid:
    """Divide each phase into even parts; both sides of every step of the acceleration are sampled."""
    ends = [*pairwise(segment.phases)]
    s = [np.linspace(begin, end, max(round(parts * (end - begin)), 2) + 1) for begin, end in ends]
    weights = [np.full(len(own), 1.0 / (len(own) - 1)) for own in s]
    for own, (begin, end) in zip(weights, ends, strict=True):
        own[[0, -1]] *= 0.5
        own *= end - begin
    phase = np.repeat(np.arange(len(s)), [*map(len, s)])
    return np.concatenate(weights), segment.basis(np.concatenate(s), phase)


def segments(p: Array, v: Array, a: Array, T: Array, segment: Segment = QUINTIC) -> Pieces:
    """Pieces between states at points, each (K + 1, n), in times T of shape (K,)."""
    t = T[:, None]
    C = np.stack([t * v[:-1], t**2 * a[:-1], t**2 * a[1:], t * v[1:], np.diff(p, axis=0)], axis=1)
    return Pieces(p[:-1], C, T, segment.basis)


@dataclass(frozen=True, eq=False, repr=False)
class ViaPoints(Plan, Brief):
    """Motion through via points: the durations between them, and the speeds and accelerations there.

    Attributes:
        points: positions [rad or m], shape (points, n).
        durations: of the segments [s], shape (points - 1,).
        speeds: at the points [rad/s or m/s], shape (points, n); None for rest in each.
        accelerations: at the points [rad/s^2 or m/s^2], shape (points, n); None for zero.
        segment: how it goes from point to point.
    """

    points: Array
    durations: Array
    speeds: Array | None = None
    accelerations: Array | None = None
    segment: Segment = QUINTIC

    def __post_init__(self) -> None:
        shape = np.shape(self.points)
        freeze_fields(self, points=(None, None), durations=(shape[0] - 1,), speeds=shape, accelerations=shape)
        if shape[0] < 2 or not (self.durations > 0.0).all():
            raise ValueError("a motion needs two points and positive durations")
        if not (self.rests or self.segment.passes):
            raise ValueError(f"a {self.segment.name} rests in every point: leave speeds and accelerations out")

    @property
    def rests(self) -> bool:
        """True if the robot rests in every point."""
        return not any(x is not None and x.any() for x in (self.speeds, self.accelerations))

    @property
    def held(self) -> Array:
        """Poses in which it stays for a while, in their order [rad or m]."""
        return self.points[1:][~np.diff(self.points, axis=0).any(axis=1)]

    @cached_property
    def pieces(self) -> Pieces:
        """A segment between each two points."""
        v, a = (np.zeros_like(self.points) if x is None else x for x in (self.speeds, self.accelerations))
        return segments(self.points, v, a, self.durations, self.segment)


@dataclass(frozen=True)
class ViaPointShape:
    """Shape of a motion through via points.

    Attributes:
        passing: whether it passes the inner points, or rests in each.
        fixed: the times from point to point themselves [s], count - 1 of them or one for all; None for free.
        longest: time that the whole motion may take [s]; None for any.
        start: where it begins [rad or m], n numbers; None for anywhere.
        segment: ``Quintic()``, or ``Trapezoid(ramp)``, which rests in each point.
    """

    count: int = 14
    passing: bool = True
    fixed: float | tuple[float, ...] | None = None
    segment: Segment = QUINTIC
    longest: float | None = None
    start: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        _check_count(self.count)
        if self.passing and not self.segment.passes:
            raise InputError(f"a {self.segment.name} rests in every via point: set passing to False")
        if self.fixed is None:
            return
        if self.longest is not None:
            raise InputError("the durations of the moves are fixed: leave the longest duration of the motion out")
        times, moves = np.asarray(self.fixed, dtype=float), self.count - 1
        if times.shape not in ((), (moves,)) or not ((times > 0.0) & (times <= LONGEST)).all():
            given = f"fixed durations {', '.join(f'{time:g}' for time in times.ravel())}"
            raise InputError(f"{given}: {self.count} via points need {moves} positive ones [s], or one for all")

    def family(self, robot: Robot, bounds: JointBounds) -> "FreeViaPoints":
        """Make the family of motions of this shape."""
        if self.start is not None:
            check_pose(np.asarray(self.start, dtype=float), robot, bounds)
        return FreeViaPoints(bounds, self)


class FreeViaPoints:
    """Family of motions through via points; for given durations their states are linear in those at the points.

    x holds (p - middle) / half range of the points, v / speed limit and a / acceleration limit of the inner ones,
    then log(T / 1 s) of the segments unless fixed. A given start is not free; first and last point are at rest.
    """

    def __init__(self, bounds: JointBounds, shape: ViaPointShape) -> None:
        self.shape, self._bounds, self.reach = shape, bounds, (bounds.low, bounds.high)
        n, moves, self.free_duration = len(bounds.low), shape.count - 1, shape.fixed is None
        begin = () if shape.start is None else shape.start
        self._start = np.reshape(begin, (-1, n)).astype(float)  # no row where it is free
        self._fixed = np.broadcast_to(np.asarray(1.0 if shape.fixed is None else shape.fixed), (moves,))
        inner = (shape.count - 2) * n if shape.passing else 0
        sizes = ((shape.count - len(self._start)) * n, inner, inner, moves if self.free_duration else 0)
        *self._splits, self.size = np.cumsum(sizes).tolist()
        self.low, self.high = -np.ones(self.size), np.ones(self.size)
        self.low[self._splits[2] :], self.high[self._splits[2] :] = np.log(_DURATIONS)

    def random(self, draw: np.random.Generator, clear: Clear = lambda _: True) -> Array:
        """Draw random points, at rest and rather slow, each on a clear line from the last if one can be found."""
        bounds, n, segment = self._bounds, len(self._bounds.low), self.shape.segment
        on_line, points = np.linspace(0.0, 1.0, 21)[:, None], [*self._start]
        while len(points) < self.shape.count:
            for _ in range(_TRIES):
                point = bounds.middle + _SPAN * bounds.half * draw.uniform(-1.0, 1.0, n)
                before = points[-1] if points else point
                if not self.free_duration and points:  # as near to it as the limits allow in the time
                    T, step = self._fixed[len(points) - 1] / _SLOWER, np.abs(point - before)
                    by_speed = bounds.speed * T / (segment.peak_speed * step)
                    by_acceleration = bounds.acceleration * T**2 / (segment.peak_acceleration * step)
                    fraction = min(1.0, float(by_speed.min()), float(by_acceleration.min()))
                    point = before + fraction * (point - before)
                if clear(before + on_line * (point - before)):
                    break
            points.append(point)
        x = np.zeros(self.size)
        p, *_, T = np.split(x, self._splits)
        p[:] = ((np.array(points) - bounds.middle) / bounds.half)[len(self._start) :].ravel()
        if self.free_duration:
            T[:] = np.log(quickest(np.diff(points, axis=0), bounds.speed, bounds.acceleration, segment) * _SLOWER)
        return np.asarray(np.clip(x, self.low, self.high))

    def sample(self, x: Array, finer: int = 1) -> Samples:
        """Evaluate states at times of each segment, its ends included: accelerations have corners there."""
        segment = self.shape.segment
        return segments(*self._unpacked(x), segment).sampled(_grid(segment, finer * _PARTS))

    def pullback(self, x: Array, slope: Samples) -> Array:
        """Apply the Jacobian transposed to the slopes."""
        pieces, bounds = segments(*self._unpacked(x), self.shape.segment), self._bounds
        by_start, by_C, by_T = pieces.pullback(_grid(self.shape.segment, _PARTS), slope)
        by_p = np.zeros((len(by_T) + 1, by_start.shape[1]))
        by_p[:-1] += by_start - by_C[:, 4]
        by_p[1:] += by_C[:, 4]
        blocks, t = [(by_p * bounds.half)[len(self._start) :]], pieces.durations[:, None]
        if self.shape.passing:
            by_v = (t * by_C[:, 3])[:-1] + (t * by_C[:, 0])[1:]
            by_a = (t**2 * by_C[:, 2])[:-1] + (t**2 * by_C[:, 1])[1:]
            blocks += [by_v * bounds.speed, by_a * bounds.acceleration]
        if self.free_duration:
            # T dC/dT = power C for each coefficient, and T is the exponential of x.
            in_C = np.einsum("kmn,kmn,m->k", by_C, pieces.coefficients, _POWERS)
            blocks.append(by_T * pieces.durations + in_C)
        return np.concatenate([block.ravel() for block in blocks])

    def plan(self, x: Array) -> ViaPoints:
        """Make the motion."""
        p, v, a, T = self._unpacked(x)
        return ViaPoints(p, T, v, a) if self.shape.passing else ViaPoints(p, T, segment=self.shape.segment)

    def _unpacked(self, x: Array) -> tuple[Array, Array, Array, Array]:
        """Unpack points, speeds and accelerations there (count, n), durations (count - 1,)."""
        bounds, n = self._bounds, len(self._bounds.low)
        own_p, own_v, own_a, log_T = np.split(x, self._splits)
        p = np.vstack([self._start, bounds.middle + bounds.half * own_p.reshape(-1, n)])
        v, a = np.zeros_like(p), np.zeros_like(p)
        if self.shape.passing:
            v[1:-1] = bounds.speed * own_v.reshape(-1, n)
            a[1:-1] = bounds.acceleration * own_a.reshape(-1, n)
        return p, v, a, np.exp(log_T) if self.free_duration else self._fixed

    def eased(self, x: Array, slower: float, smaller: float) -> Array:
        """Slow the motion by longer durations, shrink it about start or middle; at fixed durations shrink it."""
        eased, ratio = x.copy(), smaller if self.free_duration else smaller / slower
        p, v, a, log_T = np.split(eased, self._splits)
        about = ((self._start - self._bounds.middle) / self._bounds.half).sum(axis=0)  # zero where it is free
        p[:] = ratio * p + (1.0 - ratio) * np.tile(about, self.shape.count - len(self._start))
        v *= smaller / slower
        a *= smaller / slower**2 if self.free_duration else ratio
        log_T += np.log(slower)
        return np.asarray(np.clip(eased, self.low, self.high)) if self.free_duration else eased


def quickest(
    step: Array, speed: Array, acceleration: Array, segment: Segment = QUINTIC, least: float = 0.0
) -> Array:
    """Compute durations (K,), ``least`` or more, in which steps (K, n) from rest to rest keep both limits, (n,)."""
    # In a time T speeds fall as 1/T and accelerations as 1/T^2.
    by_speed = segment.peak_speed * np.abs(step) / speed
    by_acceleration = np.sqrt(segment.peak_acceleration * np.abs(step) / acceleration)
    durations = np.maximum(by_speed, by_acceleration).max(axis=1, initial=least)
    if not (durations > 0.0).all():
        raise ValueError("no speed or acceleration limit bounds a segment, or two points are the same")
    return np.asarray(durations)


def _check_count(count: int) -> None:
    if not 2 <= count <= _MOST:
        raise InputError(f"{count} via points: give 2 to {_MOST}, more take longer than anybody waits")


def random_points(robot: Robot, count: int, seed: int, span: float = 0.8) -> Array:
    """Draw random positions within a fraction ``span`` of the position range about its middle, shape (count, n).

    Raises:
        ValueError: if a joint has no position limits, or for a count that makes no motion.
    """
    _check_count(count)
    ranges = np.array([joint.limits.position for joint in robot.joints])
    if not np.isfinite(ranges).all():
        raise ValueError(f"robot {robot.name!r} has joints without position limits")
    middle, half = ranges.mean(axis=1), 0.5 * span * np.diff(ranges, axis=1)[:, 0]
    draw = np.random.default_rng(seed)
    return np.asarray(middle + half * draw.uniform(-1.0, 1.0, (count, robot.n)))


def random_via_points(robot: Robot, count: int, seed: int, speed: float = 0.5, span: float = 0.8) -> ViaPoints:
    """Draw ``random_points``, with the shortest durations at a fraction ``speed`` of the speed limits.

    Raises:
        ValueError: if a joint has no position limits.

    >>> random_via_points(robot, count=8, seed=0).points.shape
    (8, 6)
    """
    points = random_points(robot, count, seed, span)
    limits = [joint.limits for joint in robot.joints]
    top, strong = speed * np.array([x.speed for x in limits]), np.array([x.acceleration for x in limits])
    return ViaPoints(points, quickest(np.diff(points, axis=0), top, strong))


@dataclass(frozen=True, eq=False, repr=False)
class StaticShape(Brief):
    """Shape of a motion that stands still in some poses, each reached from below and from above.

    Dry friction then pulls either way, and the mean of both is the torque of gravity.

    Attributes:
        start: where it begins and ends; joints that do not move stay there [rad or m], shape (n,).
        joints: numbers of the joints that move, k.
        low, high: positions that they keep to [rad or m], shape (k,).
        approach: small move of each of them to a pose [rad or m], shape (k,).
        count: number of poses.
        hold: time at rest after each approach [s].
    """

    start: Array
    joints: tuple[int, ...]
    low: Array
    high: Array
    approach: Array
    count: int = 8
    hold: float = 1.5

    mass_alike = 0.5  # at rest a mass twice as sure costs the centre of mass of most arms little

    def __post_init__(self) -> None:
        for text, value, (least, most) in (("poses", self.count, _REST_POSES), ("s at rest", self.hold, _HOLD)):
            if not least <= value <= most:
                raise InputError(f"a weighing at rest needs {least:g} to {most:g} {text}, not {value:g}")

    @property
    def duration(self) -> float:
        """Time at rest [s]."""
        return 2.0 * self.count * self.hold

    @property
    def poses(self) -> Array:
        """Pose in which the robot waits before [rad or m], shape (1, n)."""
        return self.start[None]

    def family(self, robot: Robot, bounds: JointBounds) -> "FreeRests":
        """Make the family of motions of this shape; refuse ranges without room for an approach from both sides."""
        check_pose(self.start, robot, bounds)
        for joint, room, approach in zip(self.joints, self.high - self.low, self.approach, strict=True):
            if not 0.0 < 2.0 * approach < room:
                scale, unit = (180.0 / np.pi, "deg") if robot.joints[joint - 1].revolute else (1.0, "m")
                fault = f"joint {joint} has {scale * room:.3g} {unit} of room in its range: none for a pose and"
                advice = "give a wider --range, a smaller approach, or remove it from --joints"
                raise InputError(f"{fault} {scale * approach:.3g} {unit} to either side; {advice}")
        return FreeRests(self, bounds)

    def visibility(self, robot: Robot) -> PayloadVisibility:
        """Visibility of the payload in torques at rest, before any motion."""
        poses, draw = np.tile(self.start, (_STATES, 1)), np.random.default_rng(0)
        poses[:, [joint - 1 for joint in self.joints]] = draw.uniform(self.low, self.high, (_STATES, len(self.low)))
        return visibility_in_states(robot, self.joints, poses, 0.0 * poses, 0.0 * poses)


class FreeRests:
    """Family of motions that rest in poses; samples are poses on straight lines in joint space, none in motion.

    x holds the poses of the joints that move, -1 to 1 in their range less the approach, then log of how many times
    slower than usual it moves. It teaches by what is seen at rest, so that samples on the way have no weight.
    """

    def __init__(self, shape: StaticShape, bounds: JointBounds) -> None:
        self.shape, self._bounds = shape, bounds
        self._moving = moving = [joint - 1 for joint in shape.joints]
        self._middle, self._half = 0.5 * (shape.low + shape.high), 0.5 * (shape.high - shape.low) - shape.approach
        self.size = shape.count * len(moving) + 1
        self.low, self.high = -np.ones(self.size), np.ones(self.size)
        self.low[-1], self.high[-1] = 0.0, np.log(_SLOWEST)
        self.reach = low, high = bounds.low.copy(), bounds.high.copy()
        low[moving], high[moving] = shape.low, shape.high
        self._fixed = np.tile(shape.start, (4 * shape.count + 2, 1))
        self._fixed[1:-1, moving] = np.outer(np.tile(_SIDES, shape.count), shape.approach)

    def random(self, draw: np.random.Generator, clear: Clear = lambda _: True) -> Array:
        """Draw random poses, each on a clear line from the last if ``_TRIES`` contain one."""
        x, on_line, before = np.zeros(self.size), np.linspace(0.0, 1.0, 21)[:, None], self.shape.start
        # In one draw of two every other pose mirrors the last if it can: gravity often pulls the other way.
        poses, pairs = x[:-1].reshape(self.shape.count, -1), draw.random() < 0.5
        for k, pose in enumerate(poses):
            for trial in range(_TRIES):
                mirrored = pairs and k % 2 == 1 and trial == 0
                pose[:] = -poses[k - 1] if mirrored else _SPAN * draw.uniform(-1.0, 1.0, len(pose))
                q = self._points(x)[4 * k + 2]
                if clear(before + on_line * (q - before)):
                    break
            before = q
        return x

    def sample(self, x: Array, finer: int = 1) -> Samples:
        """Evaluate poses on the lines, at rest."""
        mixed, rests = _lines(self.shape.count, finer)
        q = mixed @ self._points(x)
        return Samples(np.where(rests, self.shape.hold, _PASSING), q, np.zeros_like(q), np.zeros_like(q))

    def pullback(self, x: Array, slope: Samples) -> Array:
        """Apply the Jacobian transposed to the slopes."""
        by_point = _lines(self.shape.count, 1)[0].T @ slope.q[:, self._moving]
        by_pose = by_point[1:-1].reshape(self.shape.count, 4, -1).sum(axis=1)
        return np.append(by_pose * self._half, 0.0)

    def plan(self, x: Array) -> ViaPoints:
        """Make the motion: quintics from rest to rest, and the time at rest."""
        points, fastest, strongest = self._points(x), self._bounds.speed, self._bounds.acceleration
        times = quickest(np.diff(points, axis=0), _SPEED * fastest, _SPEED * strongest, least=_LEAST)
        order = np.repeat(np.arange(len(points)), [1, *np.tile(1 + (_SIDES == 0.0), self.shape.count), 1])
        held = np.diff(order) == 0
        return ViaPoints(points[order], np.where(held, self.shape.hold, np.exp(x[-1]) * times[order[1:] - 1]))

    def eased(self, x: Array, slower: float, smaller: float) -> Array:
        """Slow down the ways, and shrink them about the middle of the range."""
        return np.append(smaller * x[:-1], min(x[-1] + np.log(slower), self.high[-1]))

    def _points(self, x: Array) -> Array:
        points, poses = self._fixed.copy(), self._middle + self._half * x[:-1].reshape(self.shape.count, -1)
        points[1:-1, self._moving] += np.repeat(poses, 4, axis=0)
        return points


@lru_cache(maxsize=16)
def _lines(count: int, finer: int) -> tuple[Array, Mask]:
    """Samples on the lines as mixtures of the points, (N, 4 count + 2); and those that are at rest."""
    points = np.arange(4 * count + 2)
    parts = finer * np.where(points[:-1] % 4 == 0, _LOOKS, 1)
    s = np.concatenate([[0.0], *(k + np.arange(1, part + 1) / part for k, part in enumerate(parts))])
    mixed = np.maximum(1.0 - np.abs(s[:, None] - points), 0.0)
    return mixed, np.isin(s, points[2::2])
