"""What the checks look at, and what they return."""

from dataclasses import dataclass
from typing import Literal, NamedTuple

from ...fit.estimate import Estimate, Fit
from ...payload.by_joints import ByJoints
from ...payload.constrained import ConstrainedPayload
from ...payload.over_time import Stretch
from ...payload.problem import PayloadProblem
from ...payload.result import PayloadEstimate

Severity = Literal["everything", "inertia"]
"""What a reason speaks against using: every number, or the inertia only."""


class Reason(NamedTuple):
    """Why numbers should not be used, in words; ``cause``: where that may come from."""

    against: Severity
    text: str
    cause: bool = False


@dataclass(frozen=True)
class Evidence:
    """All that was computed from one set of recordings.

    Attributes:
        problem: the reduced recordings.
        estimates: the methods' free estimates.
        constrained: the possible payload of each method for which one was found.
        recommended: the one of them that is to be used, if there is one.
        robot: the robot's own parameters without payload, where they were identified.
        validation: fit of the same parameters on recordings that were held out.
        by_joints: the payload as single joints see it.
        stretches: the payload in the order of time.
    """

    problem: PayloadProblem
    estimates: tuple[PayloadEstimate, ...]
    constrained: tuple[ConstrainedPayload, ...]
    recommended: ConstrainedPayload | None
    robot: Estimate | None
    validation: Fit | None
    by_joints: ByJoints
    stretches: tuple[Stretch, ...]

    @property
    def robot_fit(self) -> Fit | None:
        """How well the robot's own parameters explain the torques without payload."""
        return self.robot.fit if self.robot is not None else None

    @property
    def best(self) -> PayloadEstimate:
        """The free estimate of the method that is to be used."""
        return self.recommended.free if self.recommended is not None else self.estimates[-1]


def against_all(text: str) -> Reason:
    """A reason against every number."""
    return Reason("everything", text)


def against_inertia(text: str) -> Reason:
    """A reason against the inertia only."""
    return Reason("inertia", text)


def by(estimates: "tuple[PayloadEstimate, ...] | list[PayloadEstimate]") -> str:
    """The methods in words."""
    numbers = ", ".join(str(estimate.method) for estimate in estimates)
    return f"method {numbers}" if len(estimates) == 1 else f"each of methods {numbers}"
