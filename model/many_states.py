"""The regressor at many states by NumPy alone: for a robot that is tried once, generated code does not pay.

The recursion of ``regressors`` with one number for each state: arrays end in the states' axis.
"""

from collections.abc import Sequence

import numpy as np

from ..common.arrays import Array
from .drives import drive_terms
from .names import parameter_kind
from .pose import cos_sin
from .robot import INERTIAL, Joint, Robot

_CACHED = 256
"""States that are treated together: their wrenches stay in the processor's cache."""
_Frame = tuple[Array, Array, tuple[float, float], Array]
"""Cosine and sine of the joint's angle, of its alpha, and its origin in the frame before (3, 1) or (3, N)."""


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


def regressor_at(robot: Robot, columns: Sequence[str], q: Array, qd: Array, qdd: Array) -> Array:
    """Columns of the standard regressor at N states, n x ``len(columns)`` x N.

    Args:
        robot: the robot, n joints.
        columns: standard parameters, the inertial ones link by link.
        q: positions [rad or m], N x n.
        qd: speeds, N x n.
        qdd: accelerations, N x n.
    """
    W = np.zeros((robot.n, len(columns), len(q)))
    kinds: list[list[int]] = [[] for _ in robot.joints]
    places: list[list[int]] = [[] for _ in robot.joints]
    for k, name in enumerate(columns):
        if parameter_kind(name) in INERTIAL:
            link = int(name.removeprefix(parameter_kind(name))) - 1
            kinds[link].append(INERTIAL.index(parameter_kind(name)))
            places[link].append(k)
    for start in range(0, len(q), _CACHED):
        part = slice(start, start + _CACHED)
        _rigid(robot, kinds, places, (q[part].T, qd[part].T, qdd[part].T), W[:, :, part])
    for name, rows in drive_terms(robot.drives, qd.T, qdd.T, np.sign, np.ones(len(q))).items():
        for row, values in rows.items() if name in columns else ():
            W[row, columns.index(name)] = values
    return W


def _rigid(
    robot: Robot, kinds: list[list[int]], places: list[list[int]], states: tuple[Array, Array, Array], W: Array
) -> None:
    """Fill in the inertial columns: each link's ``kinds`` at its ``places``."""
    q, qd, qdd = states
    frames = [_frame(joint, angle) for joint, angle in zip(robot.joints, q, strict=True)]
    wrenches = [wrench[:, :, own] for wrench, own in zip(_wrenches(robot, frames, qd, qdd), kinds, strict=True)]
    later: list[int] = []
    force = moment = np.zeros((3, 0, q.shape[1]))
    for j in reversed(range(robot.n)):
        force, moment = (np.concatenate(pair, axis=1) for pair in zip(wrenches[j], (force, moment), strict=True))
        later = [*places[j], *later]
        W[j, later] = (moment if robot.joints[j].revolute else force)[2]
        if j:
            force, moment = _carried_back(frames[j], force, moment)


def _frame(joint: Joint, q: Array) -> _Frame:
    """The change of frame before a joint at positions (N,)."""
    c0, s0 = cos_sin(joint.theta)
    ca, sa = cos_sin(joint.alpha)
    if not joint.revolute:
        along = joint.r + q
        return np.array(c0), np.array(s0), (ca, sa), np.array([joint.d + 0.0 * q, -sa * along, ca * along])
    c, s = np.cos(q), np.sin(q)
    origin = np.array([[joint.d], [-sa * joint.r], [ca * joint.r]])
    return c * c0 - s * s0, s * c0 + c * s0, (ca, sa), origin


def _into(frame: _Frame, x: Array) -> Array:
    """Vectors (3, N) of the frame before in the joint's own axes."""
    c, s, (ca, sa), _ = frame
    across = ca * x[1] + sa * x[2]
    return np.array([c * x[0] + s * across, c * across - s * x[0], ca * x[2] - sa * x[1]])


def _back(frame: _Frame, x: Array) -> Array:
    """Vectors (3, ..., N) of the joint's own axes in the frame before."""
    c, s, (ca, sa), _ = frame
    across = s * x[0]
    across += c * x[1]
    result = np.empty_like(x)
    np.multiply(c, x[0], out=result[0])
    result[0] -= s * x[1]
    for row, (a, b) in enumerate(((ca, -sa), (sa, ca)), start=1):
        np.multiply(a, across, out=result[row])
        if b:
            result[row] += b * x[2]
    return result


def _carried_back(frame: _Frame, force: Array, moment: Array) -> tuple[Array, Array]:
    """Wrenches (3, m, N) about the origin of the frame before, in its axes."""
    force, moment = _back(frame, force), _back(frame, moment)
    for k, along in enumerate(frame[3]):
        if along.any():
            moment[(k + 1) % 3] -= along * force[(k + 2) % 3]
            moment[(k + 2) % 3] += along * force[(k + 1) % 3]
    return force, moment


def _cross(a: Array, b: Array) -> Array:
    """Cross product along the first axis."""
    result = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        np.multiply(a[i], b[j], out=result[k])
        result[k] -= a[j] * b[i]
    return result


def _wrenches(robot: Robot, frames: Sequence[_Frame], qd: Array, qdd: Array) -> list[Array]:
    """Force and moment of each link at its origin per unit of its ten, 2 x 3 x 10 x N (Newton, Euler)."""
    none = np.zeros((3, qd.shape[1]))
    w, angular, a = none, none, none - np.array(robot.gravity)[:, None]
    wrenches = []
    for joint, frame, speed, pace in zip(robot.joints, frames, qd, qdd, strict=True):
        origin = np.broadcast_to(frame[3], none.shape)
        a = _into(frame, a + _cross(angular, origin) + _cross(w, _cross(w, origin)))
        w, angular = _into(frame, w), _into(frame, angular)
        along = np.array([none[0], none[0], speed])
        if joint.revolute:
            angular = angular + np.array([none[0], none[0], pace]) + _cross(w, along)
            w = w + along
        else:
            a = a + np.array([none[0], none[0], pace]) + 2.0 * _cross(w, along)
        wrenches.append(_wrench(w, angular, a))
    return wrenches


def _wrench(w: Array, angular: Array, a: Array) -> Array:
    """Force and moment of one link, 2 x 3 x 10 x N."""
    force, moment = wrench = np.zeros((2, 3, 10, w.shape[1]))
    squares = w * w
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        force[k, 6 + k] = -(squares[i] + squares[j])
        product = w[i] * w[j]
        force[j, 6 + i], force[i, 6 + j] = product + angular[k], product - angular[k]
        moment[i, 6 + k], moment[j, 6 + k] = -a[j], a[i]
    force[:, 9] = a
    moment[:, :6] = _inertia_times(angular) + _cross(w[:, None], _inertia_times(w))
    return wrench


def _inertia_times(v: Array) -> Array:
    """K with J v = K [XX XY XZ YY YZ ZZ]', 3 x 6 x N."""
    x, y, z = v
    K = np.zeros((3, 6, v.shape[1]))
    K[0, :3] = v
    K[1, [1, 3, 4]] = v
    K[2, [2, 4, 5]] = np.array([x, y, z])
    return K
