"""Drive gains of a problem: free, of possible bodies, with covariances."""

from dataclasses import replace

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Robot, standard_columns, standard_regressor
from ...model.base import random_states
from ...model.kernel import Kernel
from ...model.names import parameter_kind
from ..equations.problem import ReducedProblem
from ..fit.estimate import Fit
from ..fit.robust import RobustCovariance, jackknife
from ..gains.known_load import KnownLoad
from ..gains.possible import possible_gains
from ..gains.problem import GainProblem, free_gains
from ..gains.result import DriveGains


def identify_gains(problem: GainProblem, load: KnownLoad) -> DriveGains:
    """Identify the drive gains on the current side, with bodies that can exist.

    Args:
        problem: the reduced currents.
        load: what is known of the payload.

    Raises:
        InputError: if the recordings do not determine the gains.
    """
    free = free_gains(problem.equations, problem.weights, load)
    held = int(np.argmin(np.diag(free.covariance)))
    best = possible_gains(problem, problem.equations, load, free, held)
    scale = (load.mass_sigma / load.mass) ** 2  # an error of the mass scales all gains alike
    robust: RobustCovariance | None = None
    reason = problem.without_blocks

    def solve(part: ReducedProblem) -> Array:
        return -np.log(possible_gains(problem, part, load, best, held).k)

    if problem.deletions:
        try:
            found = jackknife(solve, problem.deletions, -np.log(best.k), problem.block_length)
            robust = replace(found, covariance=found.covariance + scale)
        except InputError as error:
            reason = str(error)
    errors = np.array(
        [
            np.linalg.norm(R[:, -1] - k * R[:, :-1] @ best.x)
            for R, k in zip(problem.equations.factors, best.k, strict=True)
        ]
    )
    return DriveGains(
        robot=problem.robot.name,
        values=1.0 / best.k,
        free_values=1.0 / free.k,
        relative_covariance=free.covariance + scale,
        robust=robust,
        gravity=gravity_acts(problem.robot),
        rests_on=rests_on(problem.robot),
        load=load,
        payload=best.payload,
        fit=Fit(errors, problem.equations.torque_norms, problem.equations.rows),
        degrees_of_freedom=free.degrees_of_freedom,
        without_robust=reason,
        recordings=problem.recordings,
    )


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
