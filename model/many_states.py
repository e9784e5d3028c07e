"""Regressor at many states by NumPy: for a robot that is tried once, generated code does not pay.

The recursion of ``regressors`` with one number for each state: arrays end in the states' axis.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ..common.arrays import Array
from .drives import DriveState, drive_terms, joint_of, parameter_kind
from .pose import cos_sin
from .robot import INERTIAL, Joint, Robot

_FIRST_MOMENT = 6  # of a link's ten; inertia before it gives no force
_TOGETHER = 1024
"""States that are treated together: their wrenches stay near the processor."""
_Frame = tuple[Array, Array, tuple[float, float], Array]
"""Cosine and sine of the joint's angle, of its alpha, and its origin in the frame before (3, N)."""


def own_columns(robot: Robot) -> tuple[str, ...]:
    """Standard parameters whose columns span what all of them do; of the last link all ten come last.

    Links that turn pass three of their ten to the link before, links that slide their inertia.
    """
    names: list[str] = []
    for link, joint in enumerate(robot.joints, start=1):
        passed = ("YY", "MZ", "M") if joint.revolute else INERTIAL[:6]
        names += [f"{kind}{link}" for kind in INERTIAL if kind not in passed]
    drives = [name for joint in range(1, robot.n + 1) for name in robot.drives.names(joint)]
    return (*names, *drives, *robot.drives.coupling_names())


def regressor_at(
    robot: Robot, columns: Sequence[str], q: Array, qd: Array, qdd: Array, load: Array | None = None
) -> Array:
    """Columns of the standard regressor at N states, n x ``len(columns)`` x N.

    Args:
        robot: the robot, n joints.
        columns: standard parameters, the inertial ones link by link; offsets whether the robot has them or not.
        q: positions [rad or m], N x n.
        qd: speeds, N x n.
        qdd: accelerations, N x n.
        load: torques that the gears carry [N·m or N], N x n, for friction that depends on them; zero by default.
    """
    W = np.zeros((robot.n, len(columns), len(q)))
    kinds: list[list[int]] = [[] for _ in robot.joints]
    indices: list[list[int]] = [[] for _ in robot.joints]
    for k, name in enumerate(columns):
        if parameter_kind(name) in INERTIAL:
            link = joint_of(name)
            kinds[link].append(INERTIAL.index(parameter_kind(name)))
            indices[link].append(k)
    for start in range(0, len(q), _TOGETHER):
        part = slice(start, start + _TOGETHER)
        _rigid(robot, kinds, indices, (q[part].T, qd[part].T, qdd[part].T), W[:, :, part])
    drives = replace(robot.drives, offsets=True)
    state = DriveState(q.T, qd.T, qdd.T, np.zeros(q.T.shape) if load is None else load.T)
    for name, rows in drive_terms(drives, state, np.sign).items():
        for row, values in rows.items() if name in columns else ():
            W[row, columns.index(name)] = values
    return W


def point_at(robot: Robot, point: Array, q: Array) -> tuple[Array, Array]:
    """Position of a point of the last link at N states, in frame 0 [m], and its Jacobian; 3 x (n x) N.

    Args:
        robot: the robot, n joints.
        point: in frame n [m].
        q: positions [rad or m], N x n.
    """
    position = point[:, None] + np.zeros(len(q))
    moved = np.zeros((3, 0, len(q)))
    none = np.zeros(len(q))
    for joint, angle in zip(reversed(robot.joints), q.T[::-1], strict=True):
        frame = _frame(joint, angle)
        own = np.array([-position[1], position[0], none] if joint.revolute else [none, none, none + 1.0])
        moved = _out_of(frame, np.concatenate([own[:, None], moved], axis=1))
        position = _out_of(frame, position) + frame[3]
    return position, moved


def _rigid(
    robot: Robot, kinds: list[list[int]], indices: list[list[int]], states: tuple[Array, Array, Array], W: Array
) -> None:
    """Fill in the inertial columns: each link's ``kinds`` at its ``indices``.

    The torque of a joint is the power of a link's wrench at the joint's own unit speed.
    """
    q, qd, qdd = states
    frames = [_frame(joint, angle) for joint, angle in zip(robot.joints, q, strict=True)]
    turning = along = np.zeros((3, 0, q.shape[1]))
    own = np.zeros((3, 1, q.shape[1]))
    own[2] = 1.0
    none = 0.0 * own
    for k, (force, moment) in enumerate(_wrenches(robot, frames, qd, qdd)):
        if k:
            along = _into(frames[k], along + _cross(turning, frames[k][3][:, None]))
            turning = _into(frames[k], turning)
        revolute = robot.joints[k].revolute
        turning = np.concatenate([turning, own if revolute else none], axis=1)
        along = np.concatenate([along, none if revolute else own], axis=1)
        chosen, at = np.array(kinds[k], dtype=int), np.array(indices[k], dtype=int)
        if len(at):
            W[: k + 1, at] = np.einsum("ajn,acn->jcn", turning, moment[:, chosen])
            moved = chosen >= _FIRST_MOMENT
            W[: k + 1, at[moved]] += np.einsum("ajn,acn->jcn", along, force[:, chosen[moved]])


def _frame(joint: Joint, q: Array) -> _Frame:
    """Change of frame before a joint at positions (N,)."""
    c0, s0 = cos_sin(joint.theta)
    ca, sa = cos_sin(joint.alpha)
    if not joint.revolute:
        along = joint.r + q
        return np.array(c0), np.array(s0), (ca, sa), np.array([joint.d + 0.0 * q, -sa * along, ca * along])
    c, s = np.cos(q), np.sin(q)
    origin = np.array([joint.d, -sa * joint.r, ca * joint.r])[:, None] + 0.0 * q
    return c * c0 - s * s0, s * c0 + c * s0, (ca, sa), origin


def _into(frame: _Frame, x: Array) -> Array:
    """Rotate vectors (3, ..., N) of the frame before into the joint's own axes."""
    c, s, (ca, sa), _ = frame
    across = ca * x[1] + sa * x[2]
    return np.array([c * x[0] + s * across, c * across - s * x[0], ca * x[2] - sa * x[1]])


def _out_of(frame: _Frame, x: Array) -> Array:
    """Rotate vectors (3, ..., N) of the joint's own axes into the frame before."""
    c, s, (ca, sa), _ = frame
    across = s * x[0] + c * x[1]
    return np.array([c * x[0] - s * x[1], ca * across - sa * x[2], sa * across + ca * x[2]])


def _cross(a: Array, b: Array) -> Array:
    """Cross product along the first axis."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _wrenches(robot: Robot, frames: Sequence[_Frame], qd: Array, qdd: Array) -> Iterator[Array]:
    """Force and moment of each link at its origin per unit of its ten, 2 x 3 x 10 x N (Newton, Euler)."""
    none = np.zeros((3, qd.shape[1]))
    w, angular, a = none, none, none - np.array(robot.gravity)[:, None]
    for joint, frame, speed, pace in zip(robot.joints, frames, qd, qdd, strict=True):
        a = _into(frame, a + _cross(angular, frame[3]) + _cross(w, _cross(w, frame[3])))
        w, angular = _into(frame, w), _into(frame, angular)
        aside = np.array([w[1] * speed, -w[0] * speed, none[0]])  # w x speed along the axis
        if joint.revolute:
            angular += aside
            angular[2] += pace
            w[2] += speed
        else:
            a += 2.0 * aside
            a[2] += pace
        yield _wrench(w, angular, a)


def _wrench(w: Array, angular: Array, a: Array) -> Array:
    """Force and moment of one link, 2 x 3 x 10 x N."""
    force, moment = wrench = np.zeros((2, 3, 10, w.shape[1]))
    (x, y, z), (p, q, r) = w, angular
    xx, yy, zz, xy, xz, yz = x * x, y * y, z * z, x * y, x * z, y * z
    force[0, 6], force[1, 7], force[2, 8] = -(yy + zz), -(xx + zz), -(xx + yy)
    for k, (i, j, product) in enumerate(((1, 2, yz), (2, 0, xz), (0, 1, xy))):
        force[j, 6 + i] = product + angular[k]
        force[i, 6 + j] = product - angular[k]
        moment[i, 6 + k], moment[j, 6 + k] = -a[j], a[i]
    force[:, 9] = a
    moment[:, 0], moment[:, 3], moment[:, 5] = (p, xz, -xy), (-yz, q, xy), (yz, -xz, r)
    moment[:, 1] = q - xz, p + yz, xx - yy
    moment[:, 2] = r + xy, zz - xx, p - yz
    moment[:, 4] = yy - zz, r - xy, q + xz
    return wrench
