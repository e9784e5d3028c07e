"""Torques of coupled drives: what a joint feels of another joint's motor (9), kept apart beside its equations.

An error of that motor's gain is in both joints' torques. Where drives are not coupled nothing is shared.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import qr

from ..model import Robot
from ..model.arrays import Array


class SharedTorque(NamedTuple):
    """The part of a joint's right-hand side Y_j that another joint's motor makes.

    ``joint``: whose equations; ``motor``: whose torque, both from 0; ``torque``: row by row as Y_j [N·m or N].
    """

    joint: int
    motor: int
    torque: Array


def sharing(robot: Robot) -> tuple[tuple[int, ...], ...]:
    """Per joint the other joints' motors whose torque it feels, both from 0."""
    motors: list[tuple[int, ...]] = [()] * robot.n
    if robot.coupling is not None and robot.coupling.rows == "joint":
        j, k = robot.coupling.joints
        motors[j - 1] = (k - 1,)
    return tuple(motors)


def compressed(rows: Array, beside: int = 0) -> tuple[Array, Array]:
    """R of a QR decomposition, and Q' times some last columns that take no part in it.

    Fewer rows than columns are kept as they are.

    Args:
        rows: columns of the factor, then those beside, N x (c + beside).
        beside: number of the latter.
    """
    width = rows.shape[1] - beside
    if len(rows) > width:
        # What stands below is of the last columns alone.
        rows = np.asarray(qr(rows, mode="r", check_finite=False)[0][:width])
    return rows[:, :width], rows[:, width:]


def beside(shared: Sequence[SharedTorque], joint: int, rows: int) -> Array:
    """Torques that others' motors make in a joint's equations, side by side, rows x their number."""
    own = [one.torque for one in shared if one.joint == joint]
    return np.column_stack(own) if own else np.zeros((rows, 0))


def refilled(shared: Sequence[SharedTorque], joint: int, columns: Array) -> list[SharedTorque]:
    """The same joint's torques with other rows, as ``beside`` orders them."""
    own = [one for one in shared if one.joint == joint]
    return [one._replace(torque=columns[:, k]) for k, one in enumerate(own)]
