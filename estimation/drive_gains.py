"""How far errors of the drive gains carry: the torque of joint j is 1 + e_j times what it is taken for, always.

No residual shows such an error: all recordings of one arm share it. It is an uncertainty to be given.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..model import InputError, Robot
from ..model.arrays import Array
from .problem import ReducedProblem, triangular


@dataclass(frozen=True)
class GainErrors:
    """Standard deviations of the relative errors e_j of the joints' torques.

    Attributes:
        per_joint: of each joint's own error (0.02 for 2 %); one number stands for all joints.
        common: of an error that all joints share, as from one current sensor or supply.
        identified: covariance of gains that were identified, n x n, which comes on top; empty where they were not.
        notes: what else a reader must know of them, one line each.
    """

    per_joint: Sequence[float] = (0.0,)
    common: float = 0.0
    identified: Sequence[Sequence[float]] = ()
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what is no standard deviation of a relative error."""
        object.__setattr__(self, "identified", tuple(tuple(float(v) for v in row) for row in self.identified))
        object.__setattr__(self, "per_joint", tuple(float(sigma) for sigma in self.per_joint))
        sigmas = (*self.per_joint, self.common)
        if not self.per_joint or not all(0.0 <= sigma < 1.0 for sigma in sigmas):
            told = ", ".join(f"{sigma:g}" for sigma in sigmas)
            raise InputError(f"relative errors of drive gains {told}: give standard deviations from 0 to below 1")

    def covariance_of(self, robot: Robot) -> Array:
        """Of a robot's e_1 .. e_n, n x n.

        Raises:
            InputError: for identified gains of coupled drives, each of which acts on two joints.
        """
        if self.identified and robot.coupling is not None:
            j, k = robot.coupling.joints
            raise InputError(
                f"{robot.name}: how sure identified gains are is not carried through the coupled drives {j} and "
                f"{k}: give the gains as numbers, --drive-gains K1,K2,.."
            )
        return self.covariance(robot.n)

    def covariance(self, n: int) -> Array:
        """Of e_1 .. e_n, n x n.

        Raises:
            InputError: if there are neither one nor n numbers.
        """
        if len(self.per_joint) not in (1, n):
            raise InputError(f"{len(self.per_joint)} uncertainties of drive gains for {n} joints: give 1 or {n}")
        own = np.broadcast_to(self.per_joint, (n,))
        known = np.array(self.identified) if self.identified else np.zeros((n, n))
        if known.shape != (n, n):
            raise InputError(f"a covariance of {len(known)} drive gains for {n} joints: identify gains of this arm")
        return np.asarray(np.diag(np.square(own)) + self.common**2 + known)


def scaled_torque(problem: ReducedProblem, joint: int, factor: float) -> ReducedProblem:
    """The equations had the torque of one joint (counted from 0) been ``factor`` times as large.

    A known spring's torque, which is in Y, is scaled with it.
    """
    factors = list(problem.factors)
    factors[joint] = np.column_stack([factors[joint][:, :-1], factor * factors[joint][:, -1]])
    return ReducedProblem(problem.columns, tuple(factors), problem.rows, problem.effective_rows)


def gain_sensitivity(problem: ReducedProblem, weights: Array) -> Array:
    """Derivatives of a weighted least-squares solution by e_j, weights fixed, c x n; exact, it is linear in Y.

    They add up to the solution: an error common to all joints scales it.
    """
    c, n = len(problem.columns), len(problem.factors)
    rows = []
    for j, (factor, weight) in enumerate(zip(problem.factors, weights, strict=True)):
        torques = np.zeros((len(factor), n))
        torques[:, j] = factor[:, -1]
        rows.append(weight * np.column_stack([factor[:, :-1], torques]))
    R = triangular(np.vstack(rows))
    return np.asarray(np.linalg.solve(R[:c, :c], R[:c, c:]))
