"""What a joint's right-hand side holds beside its own motor's torque, kept apart beside its equations.

Of coupled drives it is another joint's motor (9): an error of that motor's gain is in both joints' torques. Of a
known spring it is the spring's torque, which no gain scales. Elsewhere nothing is kept apart.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from ...common.arrays import Array
from ...common.linear import upper
from ...model import Robot, Spring

NO_MOTOR = -1
"""In a motor's place: a known spring makes the torque."""


class SharedTorque(NamedTuple):
    """The part of a joint's right-hand side Y_j that another joint's motor makes, or a known spring.

    ``joint``: whose equations; ``motor``: whose torque, both from 0, or ``NO_MOTOR``; ``torque``: row by row
    as Y_j [N·m or N].
    """

    joint: int
    motor: int
    torque: Array


def known_spring(robot: Robot) -> Spring | None:
    """The spring whose torque is moved to the left-hand side, if there is one."""
    return robot.spring if robot.spring is not None and not robot.spring.column else None


def sharing(robot: Robot) -> tuple[tuple[int, ...], ...]:
    """Per joint (from 0) what else stands in its right-hand side: other joints' motors (from 0), ``NO_MOTOR``."""
    motors: list[tuple[int, ...]] = [()] * robot.n
    if robot.coupling is not None and robot.coupling.rows == "joint":
        j, k = robot.coupling.joints
        motors[j - 1] = (k - 1,)
    spring = known_spring(robot)
    if spring is not None:
        motors[spring.joint - 1] += (NO_MOTOR,)
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
        rows = upper(lapack.dgeqrf(rows)[0][:width])
    return rows[:, :width], rows[:, width:]


def beside(shared: Sequence[SharedTorque], joint: int, rows: int) -> Array:
    """What is not of a joint's own motor in its equations, side by side, rows x number of torques."""
    own = [torque.torque for torque in shared if torque.joint == joint]
    return np.column_stack(own) if own else np.zeros((rows, 0))


def refilled(shared: Sequence[SharedTorque], joint: int, columns: Array) -> list[SharedTorque]:
    """Replace the rows of a joint's torques by others, ordered as by ``beside``."""
    own = [torque for torque in shared if torque.joint == joint]
    return [torque._replace(torque=columns[:, k]) for k, torque in enumerate(own)]
