"""Which torques a drive gain rests on: gravity, inertia, a known spring."""

import numpy as np

from ...model import Robot, standard_columns, standard_regressor
from ...model.base.rank import random_states
from ...model.kernel.kernel import Kernel
from ...model.names import parameter_kind


def gravity_acts(robot: Robot) -> tuple[bool, ...]:
    """Per motor, whether some mass of the robot or payload weighs on it in some pose."""
    q, qd, _ = random_states(robot, 20, seed=0)
    kernel = Kernel(standard_regressor(robot))
    entries = kernel(q, 0.0 * qd, 0.0 * qd)
    heavy = [parameter_kind(name) in ("MX", "MY", "MZ", "M") for name in standard_columns(robot)]
    weights = np.zeros((len(heavy), 20, robot.n))
    for row, column, values in zip(kernel.rows, kernel.columns, entries, strict=True):
        weights[column, :, row] = values
    flat = weights[heavy].reshape(-1, robot.n)
    motors = robot.coupling.motor_torques(flat) if robot.coupling else flat
    return tuple(bool(weight > 1e-9) for weight in np.abs(motors).max(axis=0))


def rests_on(robot: Robot) -> tuple[str, ...]:
    """Per motor, in words, which torques its gain rests on."""
    words = [
        "gravity and inertia" if gravity else "inertia only: no gravity acts on this joint"
        for gravity in gravity_acts(robot)
    ]
    if robot.spring is not None:
        words[robot.spring.joint - 1] += ", and the known spring"
    if robot.coupling is not None:
        j, k = robot.coupling.joints
        words[j - 1] += f" (the torque of joint {j} less that of joint {k})"
        words[k - 1] += f" (motor {k} turns with joints {j} and {k})"
    return tuple(words)
