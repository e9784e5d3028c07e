"""Does forward kinematics reproduce a logged tool pose, up to a constant base and tool?"""

import math
from dataclasses import dataclass

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Pose, Robot, forward_kinematics

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
        errors, angles, Pose.of(B, b), Pose.of(O, offset), as_is, _told(R[few], (p + R @ offset)[few]), scale
    )


def _turned(carried: Array, rotations: Array) -> tuple[Array, Array]:
    """The constant rotation that fits best between two sets of axes, and the angles [rad] it leaves."""
    O = _nearest(np.einsum("kji,kjl->il", carried, rotations))  # noqa: E741
    apart = carried @ O - rotations
    # |A - B| of two rotations is 2 sqrt(2) sin(angle / 2): exact where the angle is small.
    sines = np.linalg.norm(apart, axis=(1, 2)) / (2.0 * math.sqrt(2.0))
    return O, np.asarray(2.0 * np.arcsin(np.minimum(sines, 1.0)))


def _told(R: Array, points: Array) -> bool:
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
