"""Drive gains of a problem: free, of possible bodies, with covariances."""

from dataclasses import replace

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import InertialParameters
from ..equations.equations import PAYLOAD, Equations
from ..fit.estimate import Estimate, Fit
from ..fit.robust import RobustCovariance, jackknife
from ..gains.known_load import KnownLoad
from ..gains.possible import possible_gains
from ..gains.problem import GainProblem, free_gains
from ..gains.result import DriveGains, gravity_acts, rests_on


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

    def solve(part: Equations) -> Array:
        return -np.log(possible_gains(problem, part, load, best, held).k)

    if problem.deletions:
        try:
            jackknifed = jackknife(solve, problem.deletions, -np.log(best.k), problem.block_length)
            robust = replace(jackknifed, covariance=jackknifed.covariance + scale)
        except InputError as error:
            reason = str(error)
    factors = zip(problem.equations.factors, best.k, strict=True)
    errors = np.array([np.linalg.norm(R[:, -1] - k * R[:, :-1] @ best.x) for R, k in factors])
    logarithms = Estimate(
        names=tuple(f"K{j}" for j in range(1, problem.robot.n + 1)),
        values=-np.log(best.k),
        covariance=free.covariance + scale,
        degrees_of_freedom=free.degrees_of_freedom,
        fit=Fit(errors, problem.equations.torque_norms, problem.equations.rows),
        weights=problem.weights,
        robust=robust,
    )
    return DriveGains(
        robot=problem.robot.name,
        logarithms=logarithms,
        free_values=1.0 / free.k,
        gravity=gravity_acts(problem.robot),
        rests_on=rests_on(problem.robot),
        load=load,
        payload=InertialParameters(best.x[-len(PAYLOAD) :]),
        without_robust=reason,
        recordings=problem.recordings,
    )
