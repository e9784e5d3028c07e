"""Motions from rest to rest: each pose is reached by a small move from below, held, reached from above, and held.

Dry friction then pulls either way, and the mean of both is the torque of gravity.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ...common import Array, Brief, InputError, Mask
from ...model import Robot
from ...model.visibility import PayloadVisibility, visibility_in_states
from .family import Clear, JointBounds, Samples, check_pose, everywhere
from .via_points import ViaPoints, quickest

_POSES = 6, 12  # fewer leave no spread to judge them by, more take longer than a motion that tells more
_HOLD = 1.0, 10.0  # s: what settles, and what more does not average
_TRIES = 200  # to find a pose that can be reached
_SPAN = 0.75  # of the range that random poses use
_LOOKS = 6  # samples of the way to a pose while optimising
_SPEED = 0.5  # of the limits
_LEAST = 1.0  # s: of each move
_SLOWEST = 20.0  # times as long as that takes
_PASSING = 1e-9  # s: weight of a sample on the way; no weight at all has no slope
_STATES = 60  # random ones, for what can be seen at rest
_SIDES = np.array([-1.0, 0.0, 1.0, 0.0])  # of a pose, by approaches: from below, there, from above, there


@dataclass(frozen=True, eq=False, repr=False)
class StaticShape(Brief):
    """Shape of a motion that stands still in some poses, each reached from below and from above.

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
        for text, value, (least, most) in (("poses", self.count, _POSES), ("s at rest", self.hold, _HOLD)):
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

    def random(self, draw: np.random.Generator, clear: Clear = everywhere) -> Array:
        """Draw random poses, each reached from the one before on a straight line if ``_TRIES`` contain one.

        In one draw of two every other mirrors the one before if that can be: gravity often pulls the other way.
        """
        x, on_line, before = np.zeros(self.size), np.linspace(0.0, 1.0, 21)[:, None], self.shape.start
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
