"""Check of a log's joints against the robot's: tool poses by forward kinematics, and ways to read its columns.

Some readings no torque can tell apart: the zero of an upright first axis, and on an arm that is its own mirror
image the senses of all axes in the mirror plane together.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, groupby, pairwise, product
from typing import NamedTuple

import numpy as np

from ...common import Array, InputError
from ...common.progress import Progress, silent
from ...model import Pose, Processing, Recording, Robot, forward_kinematics
from .engine import States, System

_STARTS = np.vstack([np.zeros(3), 0.2 * np.eye(3), -0.2 * np.eye(3)])  # m: tool offsets to start from
_FOUND = 1e-3  # m: with errors below it no other start is tried
_LEVER = 0.2  # m: the length at which an angle between axes counts, when readings are ranked
_MOST, _SOME = 1000, 60  # poses that are fitted, and those by which readings are ranked; all of them are compared
_LEAST_MOVEMENT = 0.05  # m: a tool that moves by less proves nothing
_DETERMINED = 0.01  # movement of the tool, in m for each m or rad of base and tool, at which these are determined
_FAITHFUL = (5e-3, math.radians(1.0))  # m and rad, rms: calibrated arms differ from their data sheets by less
_FEWEST = 100  # moving states of a recording
_ROUNDS = 6
_WORTH = 0.03  # a change must lower the residual by this fraction to be kept
_FRONT = 3  # readings from which each round goes on: the best one may be a dead end
_ALIKE, _ROUNDING = 0.03, 1e-9  # residuals that differ by less do equally well
_CLEAR = 0.95  # the suggestion must lie below this fraction of the residual as recorded
_PARALLEL = 1e-3  # sine of the angle between axes
_DIGITS = 9  # of a residual: rounding decides nothing between readings that no torque tells apart


class Reading(NamedTuple):
    """Reading of joint j of the robot: q_j = sign_j q_log[order_j] + quarters_j 90 degrees + along_j q_(j-1).

    The last for joints whose log counts from the horizontal, as Fanuc's J3 = q3 - q2; torques are each joint's own.
    """

    order: tuple[int, ...]  # for each joint the column of the log, counted from 0
    sign: tuple[int, ...]  # +1 or -1: the log's sense of rotation, torque included
    quarters: tuple[int, ...]  # quarter turns to add, 0 to 3
    torque: tuple[int, ...]  # +1 or -1: sign of the torque alone
    along: tuple[int, ...]  # 1 or -1 where the joint before it is to be added or taken off, else 0

    @staticmethod
    def as_recorded(n: int) -> "Reading":
        """Take every column as it stands."""
        return Reading(tuple(range(n)), (1,) * n, (0,) * n, (1,) * n, (0,) * n)

    def changed(self, *joints: int, sign: int = 1, quarters: int = 0, torque: int = 1, along: int = 0) -> "Reading":
        """Count joints the other way (sign -1), from other zeros, along the joint before; or turn torques round."""
        order, *parts = map(list, self)
        signs, turns, torques, sums = parts
        for j in joints:
            signs[j], turns[j], torques[j] = sign * signs[j], (turns[j] + quarters) % 4, torque * torques[j]
            sums[j] = along or sums[j]
        return Reading(*map(tuple, (order, *parts)))

    @property
    def matrices(self) -> tuple[Array, Array, Array]:
        """Matrix M, turns t [rad] and matrix T of q = M q_log + t and tau = T tau_log, n x n and (n,)."""
        M = np.diag(self.sign) @ np.eye(len(self.sign))[list(self.order)]
        T, turns = np.diag(self.torque) @ M, np.array(self.quarters) * np.pi / 2
        for j in np.flatnonzero(self.along):
            M[j] += self.along[j] * M[j - 1]
            turns[j] += self.along[j] * turns[j - 1]
        return M, turns, T

    @property
    def changes(self) -> list[tuple[int, str]]:
        """Describe what of each joint is not taken as it stands, joints counted from 1."""
        joints = enumerate(zip(*self, strict=True), 1)
        every = (
            (j, differs, text)
            for j, (column, sign, quarters, torque, along) in joints
            for differs, text in (
                (column != j - 1, f"from column {column + 1}"),
                (sign < 0, "turned round (position and torque)"),
                (quarters, f"zero moved by {(90, 180, -90)[quarters - 1]} degrees"),
                (torque < 0, "torque turned round"),
                (along, f"counted from the horizontal: q{j} {'-+'[along < 0]} q{j - 1} is logged"),
            )
        )
        return [(j, text) for j, differs, text in every if differs]

    def described(self) -> str:
        """Describe the reading; "as recorded" if nothing is changed."""
        joints = groupby(self.changes, lambda change: change[0])
        parts = (f"joint {j} {', '.join(text for _, text in own)}" for j, own in joints)
        return "; ".join(parts) or "as recorded"


@dataclass(frozen=True)
class Readings:
    """Readings of a log, with the residual that each leaves."""

    unit: str  # of the residuals, as text
    as_recorded: float
    residuals: Mapping[Reading, float]  # the best first, and of equally good ones the simplest
    suggested: Reading | None  # the best, if it does clearly better than the log as recorded
    alike: tuple[Reading, ...]  # others that do as well as the best


class ToolPoses(NamedTuple):
    """Rows of a log: ``q`` N x n [rad or m], ``positions`` of the tool in any fixed frame N x 3 [m].

    ``rotations``: axes of the tool, N x 3 x 3; without them the sense and zero of the last joint stay open.
    """

    source: str
    q: Array
    positions: Array
    rotations: Array | None = None

    def evenly(self, most: int) -> "ToolPoses":
        """Take no more than so many of the poses."""
        rows = np.unique(np.linspace(0, len(self.q) - 1, most).astype(np.intp))
        rotations = None if self.rotations is None else self.rotations[rows]
        return ToolPoses(self.source, self.q[rows], self.positions[rows], rotations)


@dataclass(frozen=True)
class PoseCheck:
    """Logged poses compared with forward kinematics, with the constant base and tool that fit best."""

    source: str
    samples: int
    rms: float  # distance of the logged tool from the computed one [m]
    largest: float
    rms_angle: float | None  # between their axes [rad]; None where no axes were logged
    as_is: float  # rms distance without any fit, base and tool taken as identity [m]
    base: Pose  # the robot's base in the frame in which poses are logged
    tool: Pose  # in the payload's frame; its rotation is that of the flange if none was logged
    determined: bool  # whether the motion tells base and tool; else they are one choice of many
    scale: float  # spread of the logged positions over that of the flange's
    readings: Readings | None = None  # ways to read the joints' columns, where poses are not reproduced

    @property
    def reproduced(self) -> bool:
        """True if forward kinematics reproduces the log: within 5 mm and 1 degree, rms."""
        return self.rms <= _FAITHFUL[0] and (self.rms_angle or 0.0) <= _FAITHFUL[1]

    @property
    def wrong_unit(self) -> str:
        """Unit that the positions seem to be in; empty where theirs is plausible."""
        units = ((1e3, "mm that are read as m"), (1e-3, "m that are read as mm"))
        return next((text for factor, text in units if 0.3 < self.scale / factor < 3.0), "")


def check_pose(robot: Robot, poses: ToolPoses, progress: Progress = silent) -> PoseCheck:
    """Compare logged tool poses with forward kinematics; where they differ, rank readings of the joints.

    Raises:
        InputError: if shapes do not fit, there are fewer than 4 poses, or the tool hardly moves.
    """
    (source, q, positions, rotations), count = poses, len(poses.q)
    axes = (count, 3, 3) if rotations is None else rotations.shape
    if (q.shape, positions.shape, axes) != ((count, robot.n), (count, 3), (count, 3, 3)) or count < 4:
        raise InputError(
            f"joint positions {q.shape}, tool positions {positions.shape} and axes {axes} do not fit {robot.n} "
            "joints: give at least 4 poses, one row of each"
        )
    if max(np.ptp(positions, axis=0)) < _LEAST_MOVEMENT:
        raise InputError(
            f"{source}: the tool moves by less than {1e3 * _LEAST_MOVEMENT:g} mm: too little to check the "
            "kinematics by; is the unit of its pose right?"
        )
    progress(f"comparing tool poses of {source}")
    check = _fitted(robot, poses, _STARTS)
    if check.reproduced or check.wrong_unit:
        return check
    some = poses.evenly(_SOME)

    def residual(reading: Reading) -> float:
        M, turns, _ = reading.matrices
        fit = _fitted(robot, some._replace(q=some.q @ M.T + turns), _STARTS[:1], 1e-6)
        return math.hypot(fit.rms, _LEVER * (fit.rms_angle or 0.0))

    unit = "m, rms distance of the tool" + ("" if rotations is None else " and of its axes at 0.2 m")
    return replace(check, readings=_ranked(robot, residual, unit, False, progress))


def _fitted(robot: Robot, poses: ToolPoses, starts: Array, tolerance: float = 1e-14) -> PoseCheck:
    """Fit constant base B and tool O of X_k = B T_k(q_k) O to the positions, O's rotation to the axes.

    Only the tool's origin is searched for: the base that belongs to it has a closed form (Kabsch, A solution
    for the best rotation to relate two sets of vectors, 1976).
    """
    from scipy import optimize, spatial

    def flange(q: Array) -> tuple[Array, Array]:
        R, p = (np.array(value) for value in forward_kinematics(robot).map(len(q))(q.T))
        R, foot = R.reshape(3, len(q), 3).transpose(1, 0, 2), robot.base.inverse()
        return foot.R @ R @ robot.flange.R, (p.T + R @ robot.flange.p) @ foot.R.T + foot.p

    def placed(offset: Array) -> tuple[Array, Array, Array]:
        """Base that belongs to a tool's origin, and what is left of the positions."""
        points = p + R @ offset
        centre, target = points.mean(axis=0), few.positions.mean(axis=0)
        U, _, Vt = np.linalg.svd((few.positions - target).T @ (points - centre))
        U[:, 2] *= np.sign(np.linalg.det(U @ Vt))
        B = U @ Vt
        return B, target - B @ centre, ((points - centre) @ B.T + target - few.positions).ravel()

    few, least = poses.evenly(_MOST), math.inf
    R, p = flange(few.q)
    for start in starts:
        fit = optimize.least_squares(
            lambda tool: placed(tool)[2], start, method="lm", xtol=tolerance, ftol=tolerance, max_nfev=400
        )
        if fit.cost < least:
            least, offset = fit.cost, fit.x
        if 2.0 * least < len(p) * _FOUND**2:
            break
    B, b, _ = placed(offset)
    # Base and tool are determined if no small change of both leaves all points where they are.
    turns = np.cross((p - p.mean(axis=0) + (R - R.mean(axis=0)) @ offset)[:, None], np.eye(3))
    moves = np.concatenate([R, np.broadcast_to(np.eye(3), turns.shape), turns], axis=2).reshape(-1, 9)
    determined = np.linalg.svd(moves, compute_uv=False)[-1] > _DETERMINED * math.sqrt(len(p))
    R, p = flange(poses.q)
    errors = np.linalg.norm((p + R @ offset) @ B.T + b - poses.positions, axis=1)
    turn, rms_angle = np.eye(3), None
    if poses.rotations is not None:
        each = spatial.transform.Rotation.from_matrix((B @ R).transpose(0, 2, 1) @ poses.rotations)
        turn, rms_angle = each.mean().as_matrix(), _rms((each.mean().inv() * each).magnitude())
    spread, logged = (float(np.sqrt(x.var(axis=0).sum())) for x in (p, poses.positions))
    scale, as_is = logged / spread if spread else math.inf, _rms(np.linalg.norm(p - poses.positions, axis=1))
    base, tool, largest = Pose.of(B, b), Pose.of(turn, offset), float(errors.max())
    told = bool(determined)
    return PoseCheck(poses.source, len(p), _rms(errors), largest, rms_angle, as_is, base, tool, told, scale)


def _rms(values: Array) -> float:
    return float(np.sqrt((values**2).mean()))


def rank_readings(
    robot: Robot,
    recordings: Sequence[Recording],
    processing: Processing | None = None,
    progress: Progress = silent,
) -> Readings:
    """Rank readings by the residual of the robot's identification from recordings without payload.

    Raises:
        InputError: if there is too little motion to tell anything.
    """
    parts = [States.of(recording, processing or robot.processing) for recording in recordings]
    if few := [part for part in parts if len(part.t) < _FEWEST]:
        source, count = few[0].recordings[0].source, len(few[0].t)
        raise InputError(f"{source}: {count} moving samples are too few to check the kinematics")
    together = States.joined(parts)

    def residual(reading: Reading) -> float:
        system = System.of(robot, together.read(*reading.matrices))
        # Outside the spring's table: this cannot be the reading.
        return _rms(system.fit(1.0 / system.norms).left()[0]) if system.keep.any() else math.inf

    return _ranked(robot, residual, "relative torque residual", True, progress)


def _ranked(
    robot: Robot, residual: Callable[[Reading], float], unit: str, torques: bool, progress: Progress
) -> Readings:
    """Search from the log as recorded to ever better neighbours, a few at a time, while that is worth it."""

    def rank(reading: Reading) -> tuple[bool, float, float, int, Reading]:
        worse, value = residuals[reading] > limit, round(residuals[reading], _DIGITS)
        # Of those as good as the best the simplest comes first.
        return worse, value if worse else len(reading.changes), value, len(reading.changes), reading

    plain, seen = Reading.as_recorded(robot.n), set[Reading]()
    residuals, front = {plain: residual(plain)}, [plain]
    best = residuals[plain]
    for k in range(_ROUNDS):
        progress(f"trying readings of the joints, round {k + 1} of at most {_ROUNDS}", k / _ROUNDS)
        seen.update(front)
        new = [near for centre in front for near in _neighbours(robot, centre, torques)]
        residuals |= {near: residual(near) for near in dict.fromkeys(new) if near not in residuals}
        limit = min(residuals.values()) * (1.0 + _ALIKE) + _ROUNDING
        ranked, before = sorted(residuals, key=rank), best
        best = residuals[ranked[0]]
        if not best < (1.0 - _WORTH) * before:
            break
        front = [reading for reading in ranked if reading not in seen][:_FRONT]
    return Readings(
        unit,
        residuals[plain],
        {reading: residuals[reading] for reading in ranked},
        ranked[0] if best < _CLEAR * residuals[plain] else None,
        tuple(reading for reading in ranked[1:] if residuals[reading] <= limit),
    )


def _neighbours(robot: Robot, reading: Reading, torques: bool) -> Iterator[Reading]:
    """Change a reading in one thing, or in two that go together: two senses, sense and zero, zeros in a row."""
    turning = [j for j, joint in enumerate(robot.joints) if joint.revolute]
    for i, j in combinations(range(robot.n), 2):
        order = list(reading.order)
        order[i], order[j] = order[j], order[i]
        yield from (reading._replace(order=tuple(order)), reading.changed(i, j, sign=-1))
    for j in range(robot.n):
        yield from (reading.changed(j, sign=-1), *([reading.changed(j, torque=-1)] if torques else []))
    for j, step, sign in product(turning, (1, 2, 3), (1, -1)):
        yield reading.changed(j, sign=sign, quarters=step)
    for j in range(1, robot.n):
        if abs(math.sin(robot.joints[j].alpha)) < _PARALLEL and {j - 1, j} <= set(turning):
            yield from (reading.changed(j, along=along) for along in (1, -1))
    for (i, j), a, b in product(pairwise(turning), (1, 2, 3), (1, 2, 3)):
        yield reading.changed(i, quarters=a).changed(j, quarters=b)
