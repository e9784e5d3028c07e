"""Motions about a pose: a Fourier series of some joints, the others at rest, perhaps again about a second pose."""

from dataclasses import dataclass, replace

import numpy as np

from ...common.arrays import Array, frozen_array
from ...common.brief import Brief
from ...common.errors import InputError
from ...model import Robot
from ...model.visibility import PayloadVisibility, checked_joints, payload_visibility
from .family import LONGEST, Clear, JointBounds, Plan, everywhere
from .fourier import RestingSeries, fourier_basis
from .via_points import ViaPoints, quickest

_PERIOD = 7.5  # s: about how long a series lasts before it is repeated
_SHORTEST = 1.0  # s: at each pose
_HARMONICS = 8
_SAMPLES = 16  # per period of the highest harmonic while optimising
_SPAN = 0.7  # of range, speed and acceleration that a random start uses
_SHRINKS = 20
_TRANSFER_SPEED = 0.5  # of the limits
_TRANSFER_MORE = 0.01  # s: beyond the shortest transfer, so that rounding breaks no limit


@dataclass(frozen=True, repr=False)
class NearMotion(Plan, Brief):
    """Equal periods of a Fourier series at one or two poses, at rest before and after each.

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
        """Duration from rest to rest, transfers included [s]."""
        count = len(self.poses)
        return count * (self.repeats * self.period + self.transfer)

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Position, speed and acceleration at times [s], each (N, n); at rest before 0 and after the end."""
        t = np.clip(t, 0.0, self.duration)
        stay, count = self.repeats * self.period, len(self.poses)
        index = np.minimum((t / (stay + self.transfer)).astype(int), count - 1)
        own = t - index * (stay + self.transfer)
        q, qd, qdd = (np.empty((len(t), self.poses.shape[1])) for _ in range(3))
        for p, pose in enumerate(self.poses):
            here, away = (index == p) & (own <= stay), (index == p) & (own > stay)
            B, Bd, Bdd = fourier_basis(own[here], self.a.shape[2], self.period)
            c = np.hstack([self.a[p], self.b[p]]).T
            first = fourier_basis(np.zeros(1), self.a.shape[2], self.period)[0]
            q[here], qd[here], qdd[here] = pose + (B - first) @ c, Bd @ c, Bdd @ c
            if count > 1:
                way = ViaPoints(np.stack([pose, self.poses[(p + 1) % count]]), np.array([self.transfer]))
                q[away], qd[away], qdd[away] = way.at(np.minimum(own[away] - stay, self.transfer))
        return q, qd, qdd

    def slowed(self, speed: float) -> "NearMotion":
        """Slow one period down to a fraction of the speed, the same way: to be watched before the real run."""
        slow = replace(self, a=self.a * speed, b=self.b * speed, period=self.period / speed)
        return replace(slow, repeats=1, transfer=self.transfer / speed)


@dataclass(frozen=True, eq=False)
class NearShape:
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

    def check(self, robot: Robot, bounds: JointBounds) -> None:
        """Refuse what the robot cannot do."""
        moving = checked_joints(robot, self.joints)
        if len(self.ranges) != len(moving) or not (self.ranges > 0.0).all() or not np.isfinite(self.ranges).all():
            raise InputError(f"the range must be one positive number, or one for each of {len(moving)} joints")
        if not 0.0 < self.duration <= LONGEST:
            raise InputError(f"a duration of {self.duration:g} s: give a positive one, at most {LONGEST:g} s")
        for pose in self.poses:
            if pose.shape != (robot.n,) or not ((pose > bounds.low) & (pose < bounds.high)).all():
                shown = f"of {len(pose)} numbers"
                if len(pose) == robot.n:
                    scales = [180.0 / np.pi if joint.revolute else 1.0 for joint in robot.joints]
                    shown = ", ".join(f"{scale * x:g}" for scale, x in zip(scales, pose, strict=True))
                raise InputError(f"the pose {shown} must be {robot.n} positions within the limits of {robot.name}")

    def family(self, robot: Robot, bounds: JointBounds) -> "FreeNear":
        """Make the family of motions of this shape.

        Raises:
            InputError: if the duration leaves no time beside the way between two poses.
        """
        self.check(robot, bounds)
        return FreeNear(bounds, self)

    def visibility(self, robot: Robot) -> PayloadVisibility:
        """Visibility of the payload in torques near the poses, before any motion."""
        return payload_visibility(robot, list(self.poses), self.joints, self.ranges.tolist())


class FreeNear(RestingSeries):
    """Family of Fourier series of some joints about given poses."""

    def __init__(self, bounds: JointBounds, shape: NearShape) -> None:
        """Divide the duration among poses, periods and the ways between poses."""
        self.moving = moving = [joint - 1 for joint in shape.joints]
        self._transfer = 0.0
        if len(shape.poses) > 1:
            way = quickest(np.diff(shape.poses, axis=0), _TRANSFER_SPEED * bounds.speed, bounds.acceleration)
            self._transfer = float(way[0]) + _TRANSFER_MORE
        stay = shape.duration / len(shape.poses) - self._transfer
        if stay < _SHORTEST:
            raise InputError(
                f"{shape.duration:g} s leave {stay:.1f} s at each pose beside the way between them: give a longer "
                "--duration"
            )
        self._repeats = max(1, round(stay / _PERIOD))
        period = stay / self._repeats
        # Coefficients of the order of 1 use the whole range at the first harmonics.
        scale = np.minimum(bounds.speed[moving], 2.0 * np.pi / period * shape.ranges)
        super().__init__(_HARMONICS, period, _SAMPLES * _HARMONICS, shape.poses, scale)
        self._most = (shape.ranges, bounds.speed[moving], bounds.acceleration[moving])
        # The range of each moving joint about each pose, within its limits; any for joints at rest.
        low, high = shape.poses - 1.0, shape.poses + 1.0
        low[:, moving] = np.maximum(shape.poses[:, moving] - shape.ranges, bounds.low[moving])
        high[:, moving] = np.minimum(shape.poses[:, moving] + shape.ranges, bounds.high[moving])
        self.reach = low, high

    def random(self, draw: np.random.Generator, clear: Clear = everywhere) -> Array:
        """Draw random coefficients as large as range, speed and acceleration allow."""
        c = draw.standard_normal(self._shape)
        states = self._at_poses(self.sample(c.ravel()))
        for own, pose, q, qd, qdd in zip(c, self._poses, *states, strict=True):
            sizes = zip((q - pose[self.moving], qd, qdd), self._most, strict=True)
            own *= (_SPAN / np.max([np.abs(y).max(axis=0) / size for y, size in sizes], axis=0))[:, None]
        x = np.asarray(c.ravel())
        for _ in range(_SHRINKS):
            if clear(self.sample(x).q):
                break
            x = 0.8 * x
        return x

    def plan(self, x: Array) -> NearMotion:
        """Make the motion."""
        c = np.zeros((*self._poses.shape, len(self.null)))
        c[:, self.moving] = self._unpacked(x)[1]
        a, b = np.split(c, 2, axis=2)
        return NearMotion(self._poses, a, b, self._period, self._repeats, self._transfer)
