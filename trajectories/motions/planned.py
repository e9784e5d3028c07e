"""Motions that somebody else plans: by a robot's controller from point to point, or given as samples.

A controller's synchronised moves turn all joints by the same law: a ramp to constant speed, and a ramp down. A
ramp's acceleration rises and falls linearly over part of its time, so that torques do not jump. At a via point the
next move starts before the last one has ended, as the VAL3 language's ``leave`` and ``reach`` have it; what both
give is added.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...common import Array, Brief, InputError, freeze_fields
from ...model import Motion, Robot
from .family import Factors, Pieces, Plan
from .via_points import ViaPoints, segments

_STRETCH = 1.02  # steps in which moves too short for their ramps are made longer
_REST = 0.01  # of the largest speed: what still counts as rest at the ends
_ROUNDING = 1e-6  # of a step: what times written in decimals are longer
_OVER = 1.02  # of a limit: rounding and the curve between samples


@dataclass(frozen=True, eq=False, repr=False)
class PointToPoint(Plan, Brief):
    """Motion through points by synchronised moves.

    Attributes:
        points: positions [rad or m], shape (K, n).
        durations: of the moves, from the middle of a ramp up to the middle of the ramp down [s], shape (K - 1,).
        ramps: durations of the ramps up and down of each move [s], shape (K - 1, 2).
        blend: part of a ramp for which moves overlap at a via point: 1 passes it at speed, 0 stops there.
        smoothing: part of a ramp in which its acceleration rises, and again falls; in (0, 0.5].
    """

    points: Array
    durations: Array
    ramps: Array
    blend: float = 1.0
    smoothing: float = 0.25

    def __post_init__(self) -> None:
        moves = len(self.points) - 1
        freeze_fields(self, points=(None, None), durations=(moves,), ramps=(moves, 2))
        if moves < 1 or not (self.ramps > 0.0).all():
            raise ValueError("a motion needs two points and positive ramps")
        if (self.durations < self.ramps.mean(axis=1) * (1.0 - 1e-12)).any():
            raise ValueError("a move is shorter than its ramps")
        if not 0.0 <= self.blend <= 1.0 or not 0.0 < self.smoothing <= 0.5:
            raise ValueError("blend must be in [0, 1], smoothing in (0, 0.5]")

    @cached_property
    def pieces(self) -> Pieces:
        """The sum of all ramps: a cubic between each two of their corners."""
        speed = np.diff(self.points, axis=0) / self.durations[:, None]
        (rising, falling), lengths = self.ramps.T, self.ramps.T.ravel()
        # A ramp down begins when its move's constant speed ends, the next move before the ramp has ended.
        apart = self.durations - 0.5 * (rising + falling) + rising
        up = np.cumsum([0.0, *(apart + (1.0 - self.blend) * falling)])[:-1]
        starts = np.concatenate([up, up + apart])
        change = np.concatenate([speed, -speed])
        corners = np.array([0.0, self.smoothing, 1.0 - self.smoothing, 1.0])
        knots = np.unique(starts[:, None] + lengths[:, None] * corners)
        # A ramp of unit time and height: its integral, itself, and its slope, a trapezoid of height 1 / (1 - s).
        x, s = (knots[:, None] - starts) / lengths, self.smoothing
        a, b, c = (np.maximum(np.clip(x, 0.0, 1.0) - corner, 0.0) for corner in (0.0, s, 1.0 - s))
        integral, ramp, slope = ((a**m - b**m - c**m) / (s * (1.0 - s)) for m in (3, 2, 1))
        q = self.points[0] + ((integral / 6.0 + np.maximum(x - 1.0, 0.0)) * lengths) @ change
        qd, qdd = (ramp / 2.0) @ change, (slope / lengths) @ change
        T = np.diff(knots)
        step = T[:, None]
        coefficients = np.stack([step * qd[:-1], step**2 * qdd[:-1], step**2 * np.diff(qdd, axis=0)], axis=1)
        return Pieces(q[:-1], coefficients, T, _cubic)


def _cubic(s: Array) -> Factors:
    """Factors of T qd and T^2 qdd at the beginning, and of T^3 times the constant jerk."""
    still, one = np.zeros_like(s), np.ones_like(s)
    powers = np.stack([still, one, s, s**2 / 2.0, s**3 / 6.0], axis=1)
    return np.stack([powers[:, 2:], powers[:, 1:4], powers[:, :3]])


def plan_point_to_point(
    robot: Robot,
    points: Array,
    speed: float | Array = 0.5,
    acceleration: float | Array = 0.5,
    blend: float | None = 1.0,
    smoothing: float = 0.25,
) -> PointToPoint:
    """Plan the quickest such motion through points that keeps the speed and acceleration limits.

    Args:
        robot: its joints' limits; a joint without limits sets no bound.
        points: positions [rad or m], shape (K, n).
        speed: fraction of the speed limits to use; for each move its own with shape (K - 1, 1).
        acceleration: fraction of the acceleration limits to use; at each point its own with shape (K, 1).
        blend: None for stops at every point by the quickest law; an acceleration may then be each move's own.

    Raises:
        ValueError: if no limit bounds a move, or two neighbouring points are the same.
    """
    step, limits = np.diff(np.asarray(points, dtype=float), axis=0), [joint.limits for joint in robot.joints]
    top = np.array([limit.speed for limit in limits]) * speed
    strong = np.array([limit.acceleration for limit in limits]) * acceleration * (1.0 - smoothing)
    durations = (np.abs(step) / top).max(axis=1)
    # A move of duration D and ramps R <= D: speed step / D <= top, acceleration step / (D R) <= strong.
    by_acceleration = (np.abs(step) / strong).max(axis=1) if blend is None else durations
    if not ((durations > 0.0).all() and (by_acceleration > 0.0).all() and np.isfinite(strong).any()):
        raise ValueError("no speed or acceleration limit bounds a move, or two points are the same")
    if blend is None:
        durations = np.maximum(durations, np.sqrt(by_acceleration))
        return PointToPoint(points, durations, np.tile(by_acceleration / durations, (2, 1)).T, 0.0, smoothing)
    while True:
        moving = np.pad(step / durations[:, None], ((1, 1), (0, 0)))  # at rest before and after
        before, after = moving[:-1], moving[1:]
        # While both moves act, each with its own part of its speed, no combination accelerates more than these.
        change = np.maximum(np.abs(after - before), np.maximum(np.abs(before), np.abs(after)))
        ramps = (change / strong).max(axis=1)
        short = durations < 0.5 * (ramps[:-1] + ramps[1:])
        if not short.any():
            return PointToPoint(points, durations, np.column_stack([ramps[:-1], ramps[1:]]), blend, smoothing)
        durations = np.where(short, durations * _STRETCH, durations)


@dataclass(frozen=True, eq=False, repr=False)
class SampledTrajectory(Plan, Brief):
    """A smooth curve through samples; it rests before the first and after the last.

    With speeds and accelerations quintics between samples, with speeds alone cubics, with neither a quintic spline.

    Attributes:
        t: times [s], shape (N,), rising; counted from the first.
        q: positions [rad or m], shape (N, n).
        qd, qdd: speeds and accelerations there, shape (N, n), or None.
        source: name for messages.
    """

    t: Array
    q: Array
    qd: Array | None = None
    qdd: Array | None = None
    source: str = "trajectory"

    def __post_init__(self) -> None:
        object.__setattr__(self, "t", np.asarray(self.t) - self.t[0])
        shape = (len(self.t), np.shape(self.q)[-1])
        freeze_fields(self, t=(None,), q=shape, qd=shape, qdd=shape)
        if len(self.t) < 6:
            raise InputError(f"{self.source}: {len(self.t)} samples do not make a trajectory")
        qd = np.gradient(self.q, self.t, axis=0) if self.qd is None else self.qd
        for k, where in ((0, "start"), (-1, "end")):
            moving = np.abs(qd[k]) > _REST * np.abs(qd).max() + 1e-9
            if moving.any():
                fault = f"{self.source}: joint {int(np.argmax(moving)) + 1} moves at the {where}"
                raise InputError(f"{fault}: a trajectory must start and end at rest")

    @cached_property
    def pieces(self) -> Pieces:
        """A polynomial between each two samples."""
        from scipy.interpolate import make_interp_spline

        T, qd, qdd = np.diff(self.t), self.qd, self.qdd
        if qd is None:
            rest = [(order, np.zeros(self.q.shape[1])) for order in (1, 2)]
            curve = make_interp_spline(self.t, self.q, k=5, bc_type=(rest, rest))
            qd, qdd = curve(self.t, 1), curve(self.t, 2)
        if qdd is not None:
            return segments(self.q, qd, qdd, T)
        cubic = segments(self.q, qd, np.zeros_like(qd), T)
        v0, a0, a1, v1, step = cubic.coefficients.swapaxes(0, 1)
        a0[:], a1[:] = 6.0 * step - 4.0 * v0 - 2.0 * v1, -6.0 * step + 2.0 * v0 + 4.0 * v1
        return cubic

    def check_limits(self, robot: Robot) -> None:
        """Refuse a trajectory that the robot's joints may not run."""
        limits, (q, qd, qdd) = [joint.limits for joint in robot.joints], self.at(self.t)
        ranges = [limit.position for limit in limits]
        middle = np.array([0.5 * (low + high) if np.isfinite(high - low) else 0.0 for low, high in ranges])
        shares = {"position": np.abs(q - middle) / (0.5 * np.diff(ranges)[:, 0])}
        for kind, x in (("speed", qd), ("acceleration", qdd)):
            shares[kind] = np.abs(x) / [getattr(limit, kind) for limit in limits]
        for quantity, share in shares.items():
            k, j = np.unravel_index(int(np.argmax(share)), share.shape)
            if share[k, j] > _OVER:
                fault = f"{self.source}: joint {j + 1} goes beyond its {quantity} limit at {self.t[k]:.3f} s"
                raise InputError(f"{fault} ({share[k, j]:.2f} times): make the trajectory smaller or slower")


def joined(motion: Motion, rate: float) -> Motion:
    """Refine samples to no less than ``rate`` [Hz]: more on the quintics through those that lie farther apart."""
    parts = np.ceil(np.diff(motion.t) * rate * (1.0 - _ROUNDING)).astype(int)
    if (parts <= 1).all():
        return motion
    k = np.repeat(np.arange(len(parts)), parts)  # the sample before
    fraction = (np.arange(len(k)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[k]
    t, last = motion.t[k] + fraction * np.diff(motion.t)[k], (motion.q, motion.qd, motion.qdd)
    between = ViaPoints(motion.q, np.diff(motion.t), motion.qd, motion.qdd).at(t - motion.t[0])
    return Motion(np.append(t, motion.t[-1]), *(np.vstack([x, y[-1]]) for x, y in zip(between, last, strict=True)))
