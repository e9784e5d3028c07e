"""Is the log's kinematics the robot's? Ways to read its joint columns, ranked by what they leave unexplained.

The best reading is a suggestion. Some readings no torque can tell apart: the zero of an upright first axis, and
on an arm that is its own mirror image the senses of all axes in the mirror plane together.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise, product
from math import pi

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.progress import Progress, silent
from ...model import Processing, Recording, Robot
from .misfit import Model, Sample, compiled
from .poses import quick_residual

_FEWEST = 100  # moving samples of a recording
_ROUNDS = 6
_WORTH = 0.03
"""A change must lower the residual by this fraction to be kept."""
_FRONT = 3
"""Readings from which each round goes on: the best alone may be a dead end."""
_ALIKE = 0.03
_ROUNDING = 1e-9
"""Residuals that differ by less do equally well."""
_CLEAR = 0.95
"""The suggestion must lie below this fraction of the residual as recorded."""


@dataclass(frozen=True)
class Reading:
    """How joint j of the robot is read: q_j = sign_j q_log[order_j] + quarters_j 90 degrees.

    Attributes:
        order: for each joint the column of the log, counted from 0.
        sign: +1 or -1: the log's sense of rotation, torque included.
        quarters: quarter turns to add, 0 to 3.
        torque: +1 or -1: sign of the torque alone.
    """

    order: tuple[int, ...]
    sign: tuple[int, ...]
    quarters: tuple[int, ...]
    torque: tuple[int, ...]

    @staticmethod
    def as_recorded(n: int) -> "Reading":
        """Every column as it stands."""
        return Reading(tuple(range(n)), (1,) * n, (0,) * n, (1,) * n)

    def positions(self, q: Array) -> Array:
        """Joint positions [rad or m] from a log's, N x n."""
        return np.asarray(q[:, list(self.order)] * np.array(self.sign) + np.array(self.quarters) * (pi / 2))

    def of(self, sample: Sample) -> Sample:
        """A log's sample as it is read."""
        sign = np.array(self.sign)
        read = sample.reordered(self.order).turned(sign)
        torque = read.torque * (sign * np.array(self.torque))
        return replace(read, q=self.positions(sample.q), torque=torque)

    @property
    def changes(self) -> int:
        """Number of joints and columns that are not taken as they stand."""
        moved = sum(column != j for j, column in enumerate(self.order))
        signs = sum(sign < 0 for sign in (*self.sign, *self.torque))
        return moved + signs + sum(quarter != 0 for quarter in self.quarters)

    def told(self) -> str:
        """In words, joints counted from 1; "as recorded" if nothing is changed."""
        parts = []
        for j in range(len(self.order)):
            words = []
            if self.order[j] != j:
                words.append(f"from column {self.order[j] + 1}")
            if self.sign[j] < 0:
                words.append("turned round (position and torque)")
            if self.quarters[j]:
                words.append(f"zero moved by {(90, 180, -90)[self.quarters[j] - 1]} degrees")
            if self.torque[j] < 0:
                words.append("torque turned round")
            if words:
                parts.append(f"joint {j + 1} {', '.join(words)}")
        return "; ".join(parts) or "as recorded"


def neighbours(robot: Robot, reading: Reading, torques: bool = True) -> Iterator[Reading]:
    """Readings one or two changes away, in a fixed order.

    Single changes of order (two columns swapped), sense, torque sign and zero; then two joints' senses, one
    joint's sense and zero, and the zeros of two joints in a row.

    Args:
        robot: zeros of its revolute joints are changed by quarter turns.
        reading: where to start.
        torques: whether the torque's sign alone is in question.
    """
    joints = range(robot.n)
    turning = [j for j in joints if robot.joints[j].revolute]
    for i, j in combinations(joints, 2):
        order = list(reading.order)
        order[i], order[j] = order[j], order[i]
        yield replace(reading, order=tuple(order))
    for j in joints:
        yield replace(reading, sign=_flipped(reading.sign, j))
        if torques:
            yield replace(reading, torque=_flipped(reading.torque, j))
    for j, step in product(turning, (1, 2, 3)):
        yield replace(reading, quarters=_turned(reading.quarters, j, step))
    for i, j in combinations(joints, 2):
        yield replace(reading, sign=_flipped(_flipped(reading.sign, i), j))
    for j, step in product(turning, (1, 2, 3)):
        flipped = _flipped(reading.sign, j)
        yield replace(reading, sign=flipped, quarters=_turned(reading.quarters, j, step))
    for i, j in pairwise(turning):
        for a, b in product((1, 2, 3), repeat=2):
            yield replace(reading, quarters=_turned(_turned(reading.quarters, i, a), j, b))


def _flipped(signs: tuple[int, ...], j: int) -> tuple[int, ...]:
    return (*signs[:j], -signs[j], *signs[j + 1 :])


def _turned(quarters: tuple[int, ...], j: int, step: int) -> tuple[int, ...]:
    return (*quarters[:j], (quarters[j] + step) % 4, *quarters[j + 1 :])


@dataclass(frozen=True)
class Ranked:
    """A reading and what it leaves unexplained.

    Attributes:
        reading: how the log is read.
        residual: relative torque residual, or rms distance of the tool [m].
    """

    reading: Reading
    residual: float


@dataclass(frozen=True)
class KinematicsCheck:
    """Readings of a log, best first.

    Attributes:
        as_recorded: every column as it stands.
        ranked: what was tried, best first; of readings that do equally well the simplest first.
        unit: of the residuals.
    """

    as_recorded: Ranked
    ranked: tuple[Ranked, ...]
    unit: str

    @property
    def suggested(self) -> Ranked | None:
        """The best reading, if it does clearly better than the log as recorded."""
        best = self.ranked[0]
        return best if best.residual < _CLEAR * self.as_recorded.residual else None

    @property
    def alike(self) -> tuple[Ranked, ...]:
        """Other readings that do as well as the best."""
        limit = _alike(self.ranked)
        return tuple(one for one in self.ranked[1:] if one.residual <= limit)


def rank_readings(
    robot: Robot,
    recordings: Sequence[Recording],
    processing: Processing | None = None,
    progress: Progress = silent,
) -> KinematicsCheck:
    """Rank readings by the residual of the robot's identification from recordings without payload.

    Raises:
        InputError: if there is too little motion to tell anything.
    """
    samples = [Sample.of(recording, processing or robot.processing) for recording in recordings]
    for sample in samples:
        if len(sample.t) < _FEWEST:
            raise InputError(f"{sample.source}: {len(sample.t)} moving samples are too few to check the kinematics")
    together, evaluate = Sample.joined(samples), compiled(robot)

    def residual(reading: Reading) -> float:
        try:
            return Model.of(robot, reading.of(together), evaluate).misfit()
        except InputError:  # outside the spring's table: this cannot be the reading
            return float("inf")

    return _ranked(robot, residual, "relative torque residual", True, progress)


def rank_readings_by_pose(
    robot: Robot, q: Array, positions: Array, rotations: Array | None = None, progress: Progress = silent
) -> KinematicsCheck:
    """Rank readings by how well forward kinematics reproduces the logged tool.

    Args:
        robot: as described.
        q: joint positions [rad or m], N x n.
        positions: of the tool in any fixed frame [m], N x 3.
        rotations: axes of the tool, N x 3 x 3; without them the sense and zero of the last joint stay open.
        progress: hears what is being worked on.
    """
    places = np.unique(np.linspace(0, len(q) - 1, 60).astype(int))

    def residual(reading: Reading) -> float:
        axes = None if rotations is None else rotations[places]
        return quick_residual(robot, reading.positions(q[places]), positions[places], axes)

    unit = (
        "m, rms distance of the tool"
        if rotations is None
        else "m, rms distance of the tool and of its axes at 0.2 m"
    )
    return _ranked(robot, residual, unit, False, progress)


def _ranked(
    robot: Robot, residual: Callable[[Reading], float], unit: str, torques: bool, progress: Progress
) -> KinematicsCheck:
    """Search from the log as recorded to ever better neighbours, a few at a time, while that is worth it."""
    start = Ranked(Reading.as_recorded(robot.n), residual(Reading.as_recorded(robot.n)))
    tried = {start.reading: start}
    front, spread = [start], set[Reading]()
    for k in range(_ROUNDS):
        progress(f"trying readings of the joints, round {k + 1}")
        before = _best_first(tried.values())[0]
        for centre in front:
            spread.add(centre.reading)
            for reading in neighbours(robot, centre.reading, torques):
                if reading not in tried:
                    tried[reading] = Ranked(reading, residual(reading))
        best = _best_first(tried.values())[0]
        if not best.residual < (1.0 - _WORTH) * before.residual:
            break
        fresh = [entry for entry in tried.values() if entry.reading not in spread]
        front = sorted(fresh, key=lambda entry: (entry.residual, entry.reading.changes))[:_FRONT]
    return KinematicsCheck(start, tuple(_best_first(tried.values())), unit)


def _alike(candidates: Iterable[Ranked]) -> float:
    """Residual up to which readings do as well as the best."""
    return min(one.residual for one in candidates) * (1.0 + _ALIKE) + _ROUNDING


def _best_first(candidates: Iterable[Ranked]) -> list[Ranked]:
    """Those that do as well as the best by the number of their changes, then the others by their residual."""
    candidates = list(candidates)
    limit = _alike(candidates)

    def rank(entry: Ranked) -> tuple[bool, int, float, int]:
        changes, worse = entry.reading.changes, entry.residual > limit
        return worse, 0 if worse else changes, entry.residual, changes

    return sorted(candidates, key=rank)
