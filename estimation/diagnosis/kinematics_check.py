"""Is the log's kinematics the robot's? Readings of the log, ranked by what they leave unexplained.

The best reading is a suggestion. Some readings no torque can tell apart: the zero of an upright first axis, and
on an arm that is its own mirror image the senses of all axes in the mirror plane together.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import least_squares
from ...common.progress import Progress, silent
from ...model import Processing, Recording, Robot, base_parameters, base_regressor
from ...model.kernel import Kernel
from ...model.motion import Measurement
from ..equations.problem import triangular
from ..signals.filtering import lowpass, measurement
from ..signals.rows import kept_rows
from .pose_check import quick_residual
from .readings import Reading, neighbours

_SAMPLES = 400
"""Samples that a reading is tried on: enough to rank, few enough to try hundreds."""
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

    Args:
        robot: the robot.
        recordings: without payload.
        processing: settings; the robot's own by default.
        progress: told what is being worked on.

    Raises:
        InputError: if there is too little motion to tell anything.
    """
    processing = processing or robot.processing
    residual = _TorqueResidual(robot, [_thinned(one, processing, len(recordings)) for one in recordings])
    return _ranked(robot, residual, "relative torque residual", True, progress)


def rank_readings_by_pose(
    robot: Robot, q: Array, positions: Array, rotations: Array | None = None, progress: Progress = silent
) -> KinematicsCheck:
    """Rank readings by how well forward kinematics reproduces the logged tool.

    Args:
        robot: the robot.
        q: joint positions [rad or m], N x n.
        positions: of the tool in any fixed frame [m], N x 3.
        rotations: axes of the tool, N x 3 x 3; without them the sense and zero of the last joint stay open.
        progress: told what is being worked on.
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
        before = _simplest(tried.values())
        for one in front:
            spread.add(one.reading)
            for reading in neighbours(robot, one.reading, torques):
                if reading not in tried:
                    tried[reading] = Ranked(reading, residual(reading))
        best = _simplest(tried.values())
        if k > 0 and not best.residual < (1.0 - _WORTH) * before.residual:
            break
        fresh = [one for one in tried.values() if one.reading not in spread]
        front = sorted(fresh, key=lambda one: (one.residual, one.reading.changes))[:_FRONT]
        if not best.residual < (1.0 - _WORTH) * start.residual:
            break
    limit = _alike(tried.values())
    ranked = sorted(tried.values(), key=lambda one: (one.residual, one.reading.changes))
    ranked.sort(key=lambda one: (one.residual > limit, one.reading.changes if one.residual <= limit else 0))
    return KinematicsCheck(start, tuple(ranked), unit)


def _alike(candidates: Iterable[Ranked]) -> float:
    """Residual up to which readings do as well as the best."""
    return min(one.residual for one in candidates) * (1.0 + _ALIKE) + _ROUNDING


def _simplest(candidates: Iterable[Ranked]) -> Ranked:
    """Of the readings that do as well as the best, the one with the fewest changes."""
    candidates = list(candidates)
    limit = _alike(candidates)
    return min(
        (one for one in candidates if one.residual <= limit), key=lambda one: (one.reading.changes, one.residual)
    )


def _thinned(recording: Recording, processing: Processing, count: int) -> Measurement:
    """Few moving samples of a filtered recording; the torque is filtered alike."""
    filtered = measurement(recording, processing)
    step = float(filtered.motion.t[1] - filtered.motion.t[0])
    torque = lowpass(filtered.torque, step, processing.cutoff, recording.source)
    moving = kept_rows(filtered.motion, replace(processing, slow_fraction=0.0)).any(axis=1)
    places = np.flatnonzero(moving)
    if len(places) < 100:
        raise InputError(f"{recording.source}: {len(places)} moving samples are too few to check the kinematics")
    places = places[np.unique(np.linspace(0, len(places) - 1, max(_SAMPLES // count, 100)).astype(int))]
    motion = filtered.motion
    thin = type(motion)(motion.t[places], motion.q[places], motion.qd[places], motion.qdd[places])
    return Measurement(thin, torque[places])


class _TorqueResidual:
    """Residual of the robot's identification for one reading of the recordings."""

    def __init__(self, robot: Robot, recordings: Sequence[Measurement]) -> None:
        self._robot = robot
        base = base_parameters(robot)
        self._columns = len(base.columns)
        self._kernel = Kernel(base_regressor(robot, base))
        motions = [one.motion for one in recordings]
        self._q, self._qd, self._qdd = (
            np.vstack([getattr(motion, name) for motion in motions]) for name in ("q", "qd", "qdd")
        )
        self._torque = np.vstack([one.torque for one in recordings])

    def __call__(self, reading: Reading) -> float:
        n = self._robot.n
        q = reading.positions(self._q)
        torque = reading.torques(self._torque)
        spring = self._robot.spring
        if spring is not None:
            try:
                torque[:, spring.joint - 1] += spring.torque(q[:, spring.joint - 1])
            except InputError:  # outside the spring's table: this cannot be the reading
                return float("inf")
        equations = np.zeros((n, len(q), self._columns + 1))
        entries = self._kernel(*(np.ascontiguousarray(x) for x in (q, *map(reading.rates, (self._qd, self._qdd)))))
        equations[self._kernel.rows, :, self._kernel.columns] = entries
        equations[:, :, -1] = torque.T
        norms = np.linalg.norm(torque, axis=0)
        # Every joint counts alike, whatever its torques' size.
        scaled = equations / np.where(norms > 0.0, norms, 1.0)[:, None, None]
        R = triangular(scaled.reshape(n * len(q), -1))
        x = least_squares(R[:, :-1], R[:, -1])
        return float(np.linalg.norm(R[:, -1] - R[:, :-1] @ x)) / float(np.sqrt(n))
