"""How far errors of the drive gains carry: the torque of motor j is 1 + e_j times what it is taken for, always.

No residual shows such an error: all recordings of one arm share it. It is an uncertainty to be given. Motor j acts
on joint j; where drives are coupled, motor k acts on joints j and k (9).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import is_covariance
from ..equations.equations import Equations
from .gain_recordings import GainRecordings

NOT_TOLD = (
    "the stored robot parameters do not tell how they depend on the drive gains: identify the robot again with "
    "this version to use an uncertainty of the gains"
)


@dataclass(frozen=True)
class GainErrors:
    """Standard deviations of the relative errors e_j of the motors' torques.

    Attributes:
        per_joint: of the own error of each joint's motor (0.02 for 2 %); one number stands for all joints.
        common: of an error that all joints share, as from one current sensor or supply.
        identified: covariance of gains that were identified, n x n, which comes on top; empty where they were not.
        recordings: from which those were.
        mass: of the payload with which those were [kg]; None where it is not known.
        notes: what else a reader must know of them, one line each.
    """

    per_joint: Sequence[float] = (0.0,)
    common: float = 0.0
    identified: Sequence[Sequence[float]] = ()
    recordings: GainRecordings = GainRecordings()
    mass: float | None = None
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what is no standard deviation of a relative error."""
        object.__setattr__(self, "identified", tuple(tuple(float(v) for v in row) for row in self.identified))
        object.__setattr__(self, "per_joint", tuple(float(sigma) for sigma in self.per_joint))
        sigmas = (*self.per_joint, self.common)
        if not self.per_joint or not all(0.0 <= sigma < 1.0 for sigma in sigmas):
            told = ", ".join(f"{sigma:g}" for sigma in sigmas)
            raise InputError(f"relative errors of drive gains {told}: give standard deviations from 0 to below 1")
        square = all(len(row) == len(self.identified) for row in self.identified)
        if self.identified and not (square and is_covariance(np.array(self.identified))):
            raise InputError("the identified gains' matrix is no covariance: identify them again")

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

    def says_as(self, other: "GainErrors", n: int) -> bool:
        """Whether both are the same uncertainty of n gains, however it is written."""
        return np.allclose(self.covariance(n), other.covariance(n), rtol=1e-9, atol=0.0)


def motor_torques(problem: Equations, motor: int) -> tuple[Array, ...]:
    """What a motor (counted from 0) makes of each joint's right-hand side, rows as those of the joint's factor.

    All motors' add up to the right-hand side, but for the torque of a known spring, which no gain scales.
    """
    found = [np.zeros(len(factor)) for factor in problem.factors]
    found[motor] += problem.factors[motor][:, -1]
    for one in problem.shared:
        if one.joint == motor:
            found[motor] -= one.torque
        elif one.motor == motor:
            found[one.joint] += one.torque
    return tuple(found)
