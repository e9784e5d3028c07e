"""Ways to read the joint columns of a log, ranked by torques or by tool poses.

Some readings no torque can tell apart: the zero of an upright first axis, and on an arm that is its own mirror
image the senses of all axes in the mirror plane together.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise, product
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.progress import Progress, silent
from ...model import Processing, Recording, Robot
from .engine import System
from .poses import quick_residual
from .reading import Reading
from .states import States

_FEWEST = 100  # moving states of a recording
_ROUNDS = 6
_WORTH = 0.03  # a change must lower the residual by this fraction to be kept
_FRONT = 3  # readings from which each round goes on: the best one may be a dead end
_ALIKE, _ROUNDING = 0.03, 1e-9  # residuals that differ by less do equally well
_CLEAR = 0.95  # the suggestion must lie below this fraction of the residual as recorded
_DIGITS = 9


def neighbours(robot: Robot, reading: Reading, torques: bool = True) -> Iterator[Reading]:
    """Readings one or two changes away, in a fixed order.

    Single changes of order (two columns swapped), sense, torque sign and zero; then two joints' senses, one
    joint's sense and zero, and the zeros of two joints in a row.

    Args:
        robot: zeros of its revolute joints are changed by quarter turns.
        reading: where to start.
        torques: whether the torque's sign alone is in question.
    """
    joints, steps = range(robot.n), (1, 2, 3)
    turning = [j for j in joints if robot.joints[j].revolute]
    yield from (reading.swapped(i, j) for i, j in combinations(joints, 2))
    for j in joints:
        yield reading.turned(j)
        if torques:
            yield reading.pushed(j)
    yield from (reading.moved(j, step) for j, step in product(turning, steps))
    yield from (reading.turned(i, j) for i, j in combinations(joints, 2))
    yield from (reading.turned(j).moved(j, step) for j, step in product(turning, steps))
    for (i, j), a, b in product(pairwise(turning), steps, steps):
        yield reading.moved(i, a).moved(j, b)


class Ranked(NamedTuple):
    """A reading, and the relative torque residual or rms distance of the tool [m] that it leaves."""

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
        return tuple(reading for reading in self.ranked[1:] if reading.residual <= limit)


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
    parts = [States.of(recording, processing or robot.processing) for recording in recordings]
    for part in parts:
        if len(part.t) < _FEWEST:
            raise InputError(f"{part.source}: {len(part.t)} moving samples are too few to check the kinematics")
    together = States.joined(parts)

    def residual(reading: Reading) -> float:
        states = reading.of(together)
        norms = np.linalg.norm(np.where(states.keep, states.torque, 0.0), axis=0)
        try:
            fit = System.of(robot, states).fit(1.0 / np.where(norms == 0.0, 1.0, norms))
            return float(np.sqrt(np.mean(fit.relative() ** 2)))
        except InputError:  # outside the spring's table: this cannot be the reading
            return float("inf")

    return _ranked(robot, residual, "relative torque residual", True, progress)


def rank_readings_by_pose(
    robot: Robot, q: Array, positions: Array, rotations: Array | None = None, progress: Progress = silent
) -> KinematicsCheck:
    """Rank readings by how well forward kinematics reproduces the logged tool.

    Args:
        q: joint positions [rad or m], N x n.
        positions: of the tool in any fixed frame [m], N x 3.
        rotations: axes of the tool, N x 3 x 3; without them the sense and zero of the last joint stay open.
    """
    some = np.unique(np.linspace(0, len(q) - 1, 60).astype(int))

    def residual(reading: Reading) -> float:
        axes = None if rotations is None else rotations[some]
        return quick_residual(robot, reading.positions(q[some]), positions[some], axes)

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
        progress(f"trying readings of the joints, round {k + 1} of at most {_ROUNDS}", k / _ROUNDS)
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
        front = sorted(fresh, key=_order)[:_FRONT]
    return KinematicsCheck(start, tuple(_best_first(tried.values())), unit)


def _alike(candidates: Iterable[Ranked]) -> float:
    """Residual up to which readings do as well as the best."""
    return min(reading.residual for reading in candidates) * (1.0 + _ALIKE) + _ROUNDING


def _best_first(candidates: Iterable[Ranked]) -> list[Ranked]:
    """Sort readings: those as good as the best by the number of their changes, then the others by their
    residual."""
    candidates = list(candidates)
    limit = _alike(candidates)

    def rank(entry: Ranked) -> tuple[bool, int, tuple[float, int, Reading]]:
        worse = entry.residual > limit
        return worse, 0 if worse else entry.reading.changes, _order(entry)

    return sorted(candidates, key=rank)


def _order(entry: Ranked) -> tuple[float, int, Reading]:
    """Residual, then simplicity: rounding decides nothing between readings that no torque tells apart."""
    return round(entry.residual, _DIGITS), entry.reading.changes, entry.reading
