"""Whether a log's joints are the robot's: tool poses against forward kinematics, and ways to read its columns.

Some readings no torque can tell apart: the zero of an upright first axis, and on an arm that is its own mirror
image the senses of all axes in the mirror plane together.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise, product
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.progress import Progress, silent
from ...model import Pose, Processing, Recording, Robot, forward_kinematics
from .engine import System
from .states import Index, States

_STARTS = np.vstack([np.zeros(3), 0.2 * np.eye(3), -0.2 * np.eye(3)])
"""m: tool offsets to start from."""
_FOUND = 1e-3
"""m: with errors below it no other start is tried."""
_LEVER = 0.2
"""m: the length at which an angle between axes counts, when readings are ranked."""
_MOST, _SOME = 1000, 60
"""Poses that are fitted, and those by which readings are ranked, evenly taken; all of them are compared."""
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
_DIGITS = 9  # of a residual: rounding decides nothing between readings that no torque tells apart


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
    count = len(q)
    axes = (count, 3, 3) if rotations is None else rotations.shape
    if (q.shape, positions.shape, axes) != ((count, robot.n), (count, 3), (count, 3, 3)) or count < 4:
        raise InputError(
            f"joint positions {q.shape}, tool positions {positions.shape} and axes {axes} do not fit {robot.n} "
            "joints: give at least 4 poses, one row of each"
        )
    R, p = _flange_poses(robot, q)
    few = _evenly(count, _MOST)
    fits = list[tuple[Array, float]]()
    for start in _STARTS:
        fits.append(_tool_offset(R[few], p[few], positions[few], start, 1e-14))
        if fits[-1][1] < _FOUND:
            break
    offset = min(fits, key=lambda fit: fit[1])[0]
    points = p + R @ offset
    B, b = _carrying(points[few], positions[few])
    errors = np.linalg.norm(points @ B.T + b - positions, axis=1)
    turn, angles = _turn(B @ R, rotations) if rotations is not None else (np.eye(3), None)
    as_is = float(np.sqrt(((p - positions) ** 2).sum(axis=1).mean()))
    spread, logged = (float(np.sqrt(x.var(axis=0).sum())) for x in (p, positions))
    # Base and tool are determined if no small change of both leaves all points where they are.
    x, y, z = (points[few] - points[few].mean(axis=0)).T
    none = np.zeros_like(x)
    turns = np.stack([none, z, -y, -z, none, x, y, -x, none], axis=1).reshape(-1, 3, 3)
    moves = np.concatenate([R[few], np.broadcast_to(np.eye(3), turns.shape), turns], axis=2).reshape(-1, 9)
    determined = bool(np.linalg.svd(moves, compute_uv=False)[-1] > _DETERMINED * math.sqrt(len(few)))
    scale = logged / spread if spread else math.inf
    return PoseCheck(errors, angles, Pose.of(B, b), Pose.of(turn, offset), as_is, determined, scale)


def _evenly(count: int, most: int) -> Index:
    return np.unique(np.linspace(0, count - 1, most).astype(np.intp))


def _flange_poses(robot: Robot, q: Array) -> tuple[Array, Array]:
    """Axes (N x 3 x 3) and origin (N x 3 [m]) of the payload's frame in the base."""
    R, p = (np.array(value) for value in forward_kinematics(robot).map(len(q))(q.T))
    R = R.reshape(3, len(q), 3).transpose(1, 0, 2)
    base = robot.base.inverse()
    origin = p.T + R @ robot.flange.p
    return base.R @ R @ robot.flange.R, origin @ base.R.T + base.p


def _tool_offset(R: Array, p: Array, positions: Array, start: Array, tolerance: float) -> tuple[Array, float]:
    """The tool's origin in the flange [m], (3,), and the rms distance it leaves [m]; the base in closed form."""
    from scipy.optimize import least_squares

    def misfit(offset: Array) -> Array:
        points = p + R @ offset
        B, b = _carrying(points, positions)
        return np.asarray((points @ B.T + b - positions).ravel())

    fit = least_squares(misfit, start, method="lm", xtol=tolerance, ftol=tolerance, max_nfev=400)
    return np.asarray(fit.x), float(np.sqrt(2.0 * fit.cost / len(p)))


def _carrying(points: Array, targets: Array) -> tuple[Array, Array]:
    """Rotation and translation that carry ``points`` to ``targets`` with the least squares of distance."""
    centre, target = points.mean(axis=0), targets.mean(axis=0)
    B = _nearest((targets - target).T @ (points - centre))
    return B, target - B @ centre


def _turn(carried: Array, rotations: Array) -> tuple[Array, Array]:
    """The constant rotation that fits best between two sets of axes, and the angles [rad] it leaves."""
    turn = _nearest(np.einsum("kji,kjl->il", carried, rotations))
    # |A - B| of two rotations is 2 sqrt(2) sin(angle / 2): exact where the angle is small.
    sines = np.linalg.norm(carried @ turn - rotations, axis=(1, 2)) / (2.0 * math.sqrt(2.0))
    return turn, np.asarray(2.0 * np.arcsin(np.minimum(sines, 1.0)))


def _nearest(M: Array) -> Array:
    """The rotation nearest to a matrix (Kabsch)."""
    U, _, Vt = np.linalg.svd(M)
    U[:, 2] *= np.sign(np.linalg.det(U @ Vt))
    return np.asarray(U @ Vt)


@dataclass(frozen=True, order=True)
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

    def swapped(self, i: int, j: int) -> "Reading":
        """The columns of two joints exchanged."""
        order = {i: self.order[j], j: self.order[i]}
        return replace(self, order=tuple(order.get(k, column) for k, column in enumerate(self.order)))

    def turned(self, *joints: int) -> "Reading":
        """Some joints counted the other way."""
        return replace(self, sign=tuple(-s if j in joints else s for j, s in enumerate(self.sign)))

    def pushed(self, joint: int) -> "Reading":
        """The torque of one joint alone with the other sign."""
        return replace(self, torque=tuple(-s if j == joint else s for j, s in enumerate(self.torque)))

    def moved(self, joint: int, quarters: int) -> "Reading":
        """The zero of one joint moved."""
        there = tuple((k + quarters) % 4 if j == joint else k for j, k in enumerate(self.quarters))
        return replace(self, quarters=there)

    def positions(self, q: Array) -> Array:
        """Joint positions [rad or m] from a log's, N x n."""
        return np.asarray(q[:, list(self.order)] * np.array(self.sign) + np.array(self.quarters) * (math.pi / 2))

    def of(self, states: States) -> States:
        """Read the states of a log."""
        order, sign = list(self.order), np.array(self.sign)
        turned = {name: getattr(states, name)[:, order] * sign for name in ("qd", "qdd", "torque", "slope")}
        turned["torque"], turned["slope"] = (turned[name] * np.array(self.torque) for name in ("torque", "slope"))
        return replace(states, q=self.positions(states.q), keep=states.keep[:, order], **turned)

    @property
    def changes(self) -> int:
        """Number of joints and columns that are not taken as they stand."""
        order, signs = enumerate(self.order), (*self.sign, *self.torque)
        return sum(j != column for j, column in order) + signs.count(-1) + sum(k != 0 for k in self.quarters)

    def described(self) -> str:
        """Describe the reading, joints counted from 1; "as recorded" if nothing is changed."""
        parts = []
        for j, (column, sign, quarters, torque) in enumerate(
            zip(self.order, self.sign, self.quarters, self.torque, strict=True)
        ):
            changes = [f"from column {column + 1}"] if column != j else []
            changes += ["turned round (position and torque)"] if sign < 0 else []
            changes += [f"zero moved by {(90, 180, -90)[quarters - 1]} degrees"] if quarters else []
            changes += ["torque turned round"] if torque < 0 else []
            if changes:
                parts.append(f"joint {j + 1} {', '.join(changes)}")
        return "; ".join(parts) or "as recorded"


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
        limit = _limit(self.ranked)
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
        try:
            system = System.of(robot, reading.of(together))
            return float(np.sqrt(np.mean(system.fit(1.0 / system.norms()).relative() ** 2)))
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
    some = _evenly(len(q), _SOME)

    def residual(reading: Reading) -> float:
        R, p = _flange_poses(robot, reading.positions(q[some]))
        offset, rms = _tool_offset(R, p, positions[some], _STARTS[0], 1e-6)
        if rotations is None:
            return rms
        angles = _turn(_carrying(p + R @ offset, positions[some])[0] @ R, rotations[some])[1]
        return float(np.hypot(rms, _LEVER * np.sqrt((angles**2).mean())))

    unit = "m, rms distance of the tool" + ("" if rotations is None else " and of its axes at 0.2 m")
    return _ranked(robot, residual, unit, False, progress)


def _ranked(
    robot: Robot, residual: Callable[[Reading], float], unit: str, torques: bool, progress: Progress
) -> KinematicsCheck:
    """Search from the log as recorded to ever better neighbours, a few at a time, while that is worth it."""

    def order(entry: Ranked) -> tuple[float, int, Reading]:
        return round(entry.residual, _DIGITS), entry.reading.changes, entry.reading

    def rank(entry: Ranked) -> tuple[bool, int, tuple[float, int, Reading]]:
        worse = entry.residual > limit  # of those as good as the best the simplest comes first
        return worse, 0 if worse else entry.reading.changes, order(entry)

    start = Ranked(Reading.as_recorded(robot.n), residual(Reading.as_recorded(robot.n)))
    tried, front, left = {start.reading: start}, [start], set[Reading]()
    limit = best = start.residual
    for k in range(_ROUNDS):
        progress(f"trying readings of the joints, round {k + 1} of at most {_ROUNDS}", k / _ROUNDS)
        for centre in front:
            left.add(centre.reading)
            for reading in _neighbours(robot, centre.reading, torques):
                if reading not in tried:
                    tried[reading] = Ranked(reading, residual(reading))
        limit, before = _limit(tried.values()), best
        best = min(tried.values(), key=rank).residual
        if not best < (1.0 - _WORTH) * before:
            break
        front = sorted((entry for entry in tried.values() if entry.reading not in left), key=order)[:_FRONT]
    return KinematicsCheck(start, tuple(sorted(tried.values(), key=rank)), unit)


def _limit(tried: Iterable[Ranked]) -> float:
    """Residual up to which readings do as well as the best."""
    return min(entry.residual for entry in tried) * (1.0 + _ALIKE) + _ROUNDING


def _neighbours(robot: Robot, reading: Reading, torques: bool) -> Iterator[Reading]:
    """Readings one or two changes away, in a fixed order.

    Single changes of order (two columns swapped), sense, torque sign and zero; then two joints' senses, one
    joint's sense and zero, and the zeros of two joints in a row.
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
