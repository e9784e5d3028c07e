"""Whether a log's joints are the robot's: tool poses against forward kinematics, and ways to read its columns.

Some readings no torque can tell apart: the zero of an upright first axis, and on an arm that is its own mirror
image the senses of all axes in the mirror plane together.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise, product
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.progress import Progress, silent
from ...model import Pose, Processing, Recording, Robot, forward_kinematics
from .engine import System
from .states import Reading, States

_STARTS = np.vstack([np.zeros(3), 0.2 * np.eye(3), -0.2 * np.eye(3)])
"""m: tool offsets to start from."""
_FOUND = 1e-3
"""m: with errors below it no other start is tried."""
_LEVER = 0.2
"""m: the length at which an angle between axes counts, when readings are ranked."""
_MOST = 1000
"""Poses that are fitted, evenly taken; all of them are compared."""
_DETERMINED = 0.01
"""Least movement of the tool, in m for each m or rad of base and tool, at which these are determined."""
_FAITHFUL = (5e-3, math.radians(1.0))
"""m and rad, rms: calibrated arms differ from their data sheets by less."""
_FEWEST = 100  # moving states of a recording
_ROUNDS = 6
_WORTH = 0.03  # a change must lower the residual by this fraction to be kept
_FRONT = 3  # readings from which each round goes on: the best one may be a dead end
_ALIKE, _ROUNDING = 0.03, 1e-9  # residuals that differ by less do equally well
_CLEAR = 0.95  # the suggestion must lie below this fraction of the residual as recorded
_DIGITS = 9


@dataclass(frozen=True)
class PoseCheck:
    """Logged poses against forward kinematics, with the constant base and tool that fit best.

    Attributes:
        errors: distance of the logged tool from the computed one [m], shape (N,).
        angles: angle between their axes [rad], shape (N,), where axes were logged.
        base: the robot's base in the frame in which poses are logged.
        tool: the logged tool in the payload's frame; its rotation is that of the flange if none was logged.
        as_is: rms distance without any fit, base and tool taken as identity [m].
        determined: whether the motion tells base and tool; else they are one choice of many.
        scale: spread of the logged positions over that of the flange's.
    """

    errors: Array
    angles: Array | None
    base: Pose
    tool: Pose
    as_is: float
    determined: bool
    scale: float

    @property
    def reproduced(self) -> bool:
        """Whether forward kinematics reproduces the log: within 5 mm and 1 degree, rms."""
        return self.rms <= _FAITHFUL[0] and (self.rms_angle or 0.0) <= _FAITHFUL[1]

    @property
    def rms(self) -> float:
        """Root mean square of ``errors`` [m]."""
        return float(np.sqrt((self.errors**2).mean()))

    @property
    def rms_angle(self) -> float | None:
        """Root mean square of ``angles`` [rad]."""
        return None if self.angles is None else float(np.sqrt((self.angles**2).mean()))


def check_pose(robot: Robot, q: Array, positions: Array, rotations: Array | None = None) -> PoseCheck:
    """Compare logged tool poses with forward kinematics.

    X_k = B T_k(q_k) O: B and O, constant, are fitted to the positions (O's rotation to the axes).

    Args:
        q: joint positions [rad or m], N x n.
        positions: of the tool [m], N x 3.
        rotations: axes of the tool, N x 3 x 3.

    Raises:
        InputError: if shapes do not fit or there are fewer than 4 poses.
    """
    _check_shapes(robot, q, positions, rotations)
    R, p = _flange_poses(robot, q)
    few = np.unique(np.linspace(0, len(q) - 1, _MOST).astype(int))
    offset = _best_offset(R[few], p[few], positions[few])
    B, b = _rigid((p + R @ offset)[few], positions[few])
    errors = np.linalg.norm((p + R @ offset) @ B.T + b - positions, axis=1)
    O, angles = np.eye(3), None  # noqa: E741
    if rotations is not None:
        O, angles = _turned(B @ R, rotations)  # noqa: E741
    as_is = float(np.sqrt(((p - positions) ** 2).sum(axis=1).mean()))
    spread = float(np.sqrt(p.var(axis=0).sum()))
    scale = float(np.sqrt(positions.var(axis=0).sum())) / spread if spread else math.inf
    return PoseCheck(
        errors, angles, Pose.of(B, b), Pose.of(O, offset), as_is, _determined(R[few], (p + R @ offset)[few]), scale
    )


def _turned(carried: Array, rotations: Array) -> tuple[Array, Array]:
    """The constant rotation that fits best between two sets of axes, and the angles [rad] it leaves."""
    O = _nearest(np.einsum("kji,kjl->il", carried, rotations))  # noqa: E741
    apart = carried @ O - rotations
    # |A - B| of two rotations is 2 sqrt(2) sin(angle / 2): exact where the angle is small.
    sines = np.linalg.norm(apart, axis=(1, 2)) / (2.0 * math.sqrt(2.0))
    return O, np.asarray(2.0 * np.arcsin(np.minimum(sines, 1.0)))


def _determined(R: Array, points: Array) -> bool:
    """Whether no small change of base and tool together leaves all ``points`` where they are."""
    x, y, z = (points - points.mean(axis=0)).T
    none = np.zeros_like(x)
    turns = np.stack([none, z, -y, -z, none, x, y, -x, none], axis=1).reshape(-1, 3, 3)
    moves = np.concatenate([R, np.broadcast_to(np.eye(3), R.shape), turns], axis=2).reshape(-1, 9)
    return bool(np.linalg.svd(moves, compute_uv=False)[-1] > _DETERMINED * math.sqrt(len(points)))


def _check_shapes(robot: Robot, q: Array, positions: Array, rotations: Array | None) -> None:
    count = len(q)
    if q.shape != (count, robot.n) or positions.shape != (count, 3):
        raise InputError(
            f"joint positions {q.shape} and tool positions {positions.shape} do not fit {robot.n} joints: one row "
            "of each per sample"
        )
    if rotations is not None and rotations.shape != (count, 3, 3):
        raise InputError(f"tool rotations have shape {rotations.shape}, expected {(count, 3, 3)}")
    if count < 4:
        raise InputError(f"{count} poses are too few to compare: give at least 4")


def _flange_poses(robot: Robot, q: Array) -> tuple[Array, Array]:
    """Axes (N x 3 x 3) and origin (N x 3 [m]) of the payload's frame in the base."""
    R, p = (np.array(value) for value in forward_kinematics(robot).map(len(q))(q.T))
    R = R.reshape(3, len(q), 3).transpose(1, 0, 2)
    base = robot.base.inverse()
    origin = p.T + R @ robot.flange.p
    return base.R @ R @ robot.flange.R, origin @ base.R.T + base.p


def quick_residual(robot: Robot, q: Array, positions: Array, rotations: Array | None = None) -> float:
    """Root mean square of ``check_pose``'s errors [m] from one start, angles at a lever of 0.2 m, to rank by."""
    R, p = _flange_poses(robot, q)
    offset, rms = _fitted(R, p, positions, _STARTS[0], 1e-6)
    if rotations is None:
        return rms
    B, _ = _rigid(p + R @ offset, positions)
    angles = _turned(B @ R, rotations)[1]
    return float(np.hypot(rms, _LEVER * np.sqrt((angles**2).mean())))


def _best_offset(R: Array, p: Array, positions: Array) -> Array:
    """Origin of the tool in the flange [m]; the base follows from it in closed form."""
    fits = []
    for start in _STARTS:
        fits.append(_fitted(R, p, positions, start, 1e-14))
        if fits[-1][1] < _FOUND:
            break
    return min(fits, key=lambda fit: fit[1])[0]


def _fitted(R: Array, p: Array, positions: Array, start: Array, tolerance: float) -> tuple[Array, float]:
    """The tool's origin in the flange [m], (3,), and the rms distance it leaves [m]."""
    from scipy.optimize import least_squares

    def misfit(offset: Array) -> Array:
        points = p + R @ offset
        B, b = _rigid(points, positions)
        return np.asarray((points @ B.T + b - positions).ravel())

    fit = least_squares(misfit, start, method="lm", xtol=tolerance, ftol=tolerance, max_nfev=400)
    return np.asarray(fit.x), float(np.sqrt(2.0 * fit.cost / len(p)))


def _rigid(points: Array, targets: Array) -> tuple[Array, Array]:
    """Rotation and translation that carry ``points`` to ``targets`` with the least squares of distance."""
    centre, target = points.mean(axis=0), targets.mean(axis=0)
    B = _nearest((targets - target).T @ (points - centre))
    return B, target - B @ centre


def _nearest(M: Array) -> Array:
    """The rotation nearest to a matrix (Kabsch)."""
    U, _, Vt = np.linalg.svd(M)
    U[:, 2] *= np.sign(np.linalg.det(U @ Vt))
    return np.asarray(U @ Vt)


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
        try:
            system = System.of(robot, states)
            fit = system.fit(1.0 / system.norms())
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
