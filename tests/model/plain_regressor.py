"""The standard regressor once more, as plain NumPy over all states: no symbols to build, for many robots."""

import numpy as np
from dynident.common.arrays import Array
from dynident.model import INERTIAL, Robot, standard_columns
from dynident.model.pose import cos_sin
from dynident.model.robot import Joint


def plain_regressor(robot: Robot, q: Array, qd: Array, qdd: Array) -> Array:
    """Standard regressor of a robot without coupled drives on all states: (n * count) x N_s, joint by joint."""
    count, n = q.shape
    columns = standard_columns(robot)
    W = np.zeros((n, count, len(columns)))
    w, alpha = np.zeros((2, count, 3))
    a = np.tile(-np.array(robot.gravity), (count, 1))
    turn, slide = np.zeros((2, count, 0, 3))
    for j, joint in enumerate(robot.joints):
        R, p = _frames(joint, q[:, j])
        a = _into(R, a + np.cross(alpha, p) + np.cross(w, np.cross(w, p)))
        w, alpha = _into(R, w), _into(R, alpha)
        turn, slide = turn @ R, (slide + np.cross(turn, p[:, None, :])) @ R
        z = np.tile([0.0, 0.0, 1.0], (count, 1))
        still = np.zeros((count, 3))
        own = (z, still) if joint.revolute else (still, z)
        speed, rate = qd[:, j, None], qdd[:, j, None]
        alpha = alpha + own[0] * rate + np.cross(w, own[0] * speed)
        w = w + own[0] * speed
        a = a + own[1] * rate + 2.0 * np.cross(w, own[1] * speed)
        turn = np.concatenate([turn, own[0][:, None]], axis=1)
        slide = np.concatenate([slide, own[1][:, None]], axis=1)
        force, moment = _wrench(w, alpha, a)
        first = columns.index(f"{INERTIAL[0]}{j + 1}")
        W[: j + 1, :, first : first + 10] = (turn @ moment + slide @ force).transpose(1, 0, 2)
        factors = {"IA": qdd[:, j], "FS": np.sign(qd[:, j]), "FV": qd[:, j], "OFF": np.ones(count)}
        for name in robot.drives.names(j + 1):
            W[j, :, columns.index(name)] = factors[name.rstrip("0123456789")]
    return W.reshape(n * count, -1)


def _frames(joint: Joint, q: Array) -> tuple[Array, Array]:
    (ca, sa), unit = cos_sin(joint.alpha), np.ones(len(q))
    if joint.revolute:
        co, so = cos_sin(joint.theta)
        ct, st = np.cos(q) * co - np.sin(q) * so, np.sin(q) * co + np.cos(q) * so
    else:
        ct, st = (value * unit for value in cos_sin(joint.theta))
    r = joint.r if joint.revolute else joint.r + q
    R = np.array([[ct, -st, 0 * unit], [ca * st, ca * ct, -sa * unit], [sa * st, sa * ct, ca * unit]])
    return R.transpose(2, 0, 1), np.stack([joint.d * unit, -sa * r * unit, ca * r * unit], axis=1)


def _into(R: Array, v: Array) -> Array:
    return np.asarray(np.einsum("nji,nj->ni", R, v))


def _wrench(w: Array, alpha: Array, a: Array) -> tuple[Array, Array]:
    """Force and moment per unit of the ten parameters, each count x 3 x 10."""
    turning = _skew(w)
    force, moment = np.zeros((2, len(w), 3, 10))
    force[:, :, 6:9], force[:, :, 9] = _skew(alpha) + turning @ turning, a
    moment[:, :, :6] = _inertia_times(alpha) + turning @ _inertia_times(w)
    moment[:, :, 6:9] = -_skew(a)
    return force, moment


def _skew(v: Array) -> Array:
    x, y, z = v.T
    zero = 0.0 * x
    return np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)


def _inertia_times(v: Array) -> Array:
    """K with J v = K [XX XY XZ YY YZ ZZ]', count x 3 x 6."""
    x, y, z = v.T
    zero = 0.0 * x
    rows = [[x, y, z, zero, zero, zero], [zero, x, zero, y, z, zero], [zero, zero, x, zero, y, z]]
    return np.array(rows).transpose(2, 0, 1)
