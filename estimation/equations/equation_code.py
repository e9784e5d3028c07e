"""Generated code of the observation system: what one sample adds to each joint's equations."""

import functools

import casadi as ca
import numpy as np

from ...common.arrays import Array
from ...model import Robot
from ...model.kernel.kernel import Kernel
from ...model.regressors import regressor_expression
from .shared_torque import NO_MOTOR, known_spring, sharing

PATH = "path"
"""The column of a difference's torque that is taken off its right-hand side because the paths differ."""


@functools.lru_cache(maxsize=16)
def equation_code(robot: Robot, columns: tuple[str, ...]) -> tuple[Kernel, tuple[Array, ...]]:
    """Kernel of q, qd, qdd, torque to each joint's entries and torques, and the columns of the entries.

    With a known spring its torque in the recording that was subtracted is one more input; of the column ``PATH``,
    which is taken off the torques, its values are.
    """
    standard = [name for name in columns if name != PATH]
    motors, (q, qd, qdd), phi = sharing(robot), *regressor_expression(robot, standard)
    torque, path = ca.SX.sym("torque", robot.n), ca.SX.sym("path", robot.n)
    left = ca.SX(torque)
    with_path = PATH in columns
    if with_path:
        left -= path
        place = columns.index(PATH)
        phi = ca.horzcat(phi[:, :place], path, phi[:, place:])
    inputs, apart = [q, qd, qdd, torque], {motor: left[motor] for motor in range(robot.n)}
    spring = known_spring(robot)
    if spring is not None:
        joint, before = spring.joint - 1, ca.SX.sym("before")
        apart[NO_MOTOR] = spring.torque_symbol(q[joint]) - before
        left[joint] += apart[NO_MOTOR]
        inputs.append(before)
    if with_path:
        inputs.append(path)
    phi, left = _of_each_motor(robot, phi, left)
    rows, touched = [], []
    for j in range(robot.n):
        own = phi[j, :].sparsity().get_triplet()[1]
        touched.append(np.array(own, dtype=int))
        rows += [phi[j, k] for k in own] + [left[j], *(apart[motor] for motor in motors[j])]
    return Kernel(ca.Function("equations", inputs, [ca.cse(ca.vertcat(*rows))])), tuple(touched)


def _of_each_motor(robot: Robot, phi: ca.SX, left: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Rows of the regressor and their torques, of coupled drives those of the motors where these are asked for."""
    if robot.coupling is None or robot.coupling.rows == "joint":
        return phi, left
    j, k = (joint - 1 for joint in robot.coupling.joints)
    # Joint j holds both motors' torque (9); less joint k's, motor j's is left.
    phi[j, :] -= phi[k, :]
    left[j] -= left[k]
    return ca.sparsify(phi), left
