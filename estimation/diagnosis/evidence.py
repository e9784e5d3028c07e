"""What the checks look at."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from ...common.arrays import Array
from ...model import Robot
from ...model.inertia import PayloadSpread
from ..equations.equations import Equations
from ..fit.estimate import Estimate, Fit
from ..payload.by_joints import ByJoints
from ..payload.constrained import ConstrainedPayload
from ..payload.problem import Source
from ..payload.repeats import Repeats
from ..payload.result import PayloadEstimate
from ..signals.alignment import AlignedPair
from .finding import Finding
from .loaded_rows import Scale
from .nuisances import Bursts, Nuisance, Tilt
from .pull import Pull
from .quantities import Agreement, Judged
from .rivals import Rival


class Sampled(NamedTuple):
    """What samples alone show, kept for when only their equations are left.

    ``rivals``: other ways to take the recordings; ``alignment`` and ``zeros``: findings on pairs; ``causes``: what
    most likely went wrong; ``held_out``: equations of recordings that were not fitted; ``tilt``, ``bursts``,
    ``nuisances`` and ``pulls``: what else is in the torques; ``scales`` beside a stored robot.
    """

    rivals: tuple[Rival, ...] = ()
    alignment: tuple[Finding, ...] = ()
    causes: tuple[Finding, ...] = ()
    held_out: Equations | None = None
    zeros: tuple[Finding, ...] = ()
    tilt: Tilt | None = None
    bursts: Bursts | None = None
    nuisances: tuple[Nuisance, ...] = ()
    scales: tuple[Scale, ...] = ()
    pulls: tuple[Pull, ...] = ()


KNOWN_WELL = 0.05
"""Relative standard deviation up to which a drive gain counts as identified."""


class KnownWeight(NamedTuple):
    """A weight of known mass, and the mass that the gains give it.

    ``mounting``: its number; ``told``: its mass [kg]; ``mass`` by the torques that the gains give, with its
    standard deviation ``sigma`` [kg].
    """

    mounting: int
    told: float
    mass: float
    sigma: float


@dataclass(frozen=True)
class Gained:
    """Drive gains that were identified.

    Attributes:
        sigma: their relative standard deviations, shape (n,).
        weights: in each mounting.
    """

    sigma: Array
    weights: tuple[KnownWeight, ...]


@dataclass(frozen=True)
class Weighed:
    """A short weighing.

    Attributes:
        mass: by the torques, else by the scale [kg].
        sigma: its standard deviation [kg].
        unexplained: each joint's error over its torque, nan for held ones, shape (n,).
        judged: "mass", "centre of mass", "inertia".
        repeats: with several recordings, each of them alone.
        agreement: other ways to the mass.
    """

    mass: float
    sigma: float
    from_scale: bool
    unexplained: Array
    judged: dict[str, Judged]
    repeats: Repeats | None = None
    agreement: tuple[Agreement, ...] = ()


@dataclass(frozen=True)
class Evidence:
    """All that was computed from one set of recordings; checks of what a command does not compute are silent.

    Attributes:
        source: the recordings themselves, to look for causes in.
        pairs: recordings of one motion without and with payload.
        condition: condition number of the equations without payload, columns scaled to norm 1.
        parameters: the robot's own, where they were identified or stored.
        validation: fit of those on recordings that were held out.
        estimates: the methods' free estimates.
        constrained: the possible payload of each method for which one was found.
        recommended: the one of them that is to be used, if there is one.
        stretches: the payload in the order of time.
        spread: standard deviations of what is recommended: half the reported intervals, over 1.96.
        disagreement: factor on every interval by which all joints' shares together disagree; 1 where they do not.
        scales: of the loaded torques, where one may differ from that of the unloaded ones.
        gained: drive gains, where they are what is asked for.
        compared: recordings without and with payload side by side, whether of one motion or not.
        sampled: what the samples showed, where they are not here any more.
    """

    robot: Robot
    source: Source | None = None
    pairs: tuple[AlignedPair, ...] = ()
    condition: float | None = None
    parameters: Estimate | None = None
    validation: Fit | None = None
    estimates: tuple[PayloadEstimate, ...] = ()
    constrained: tuple[ConstrainedPayload, ...] = ()
    recommended: ConstrainedPayload | None = None
    by_joints: ByJoints = ByJoints((), ())
    stretches: tuple[Estimate, ...] = ()
    weighed: Weighed | None = None
    spread: PayloadSpread | None = None
    disagreement: float = 1.0
    rivals: tuple[Rival, ...] = ()
    scales: tuple[Scale, ...] = ()
    bursts: Bursts | None = None
    gained: Gained | None = None
    tilt: Tilt | None = None
    nuisances: tuple[Nuisance, ...] = ()
    pulls: tuple[Pull, ...] = ()
    compared: tuple[AlignedPair, ...] = ()
    sampled: Sampled | None = None

    @property
    def robot_fit(self) -> Fit | None:
        """How well the robot's own parameters explain the torques without payload."""
        return self.parameters.fit if self.parameters is not None else None

    @property
    def best(self) -> PayloadEstimate | None:
        """The free estimate of the method that is to be used."""
        if self.recommended is not None:
            return self.recommended.free
        return self.estimates[-1] if self.estimates else None

    @property
    def of_robot(self) -> bool:
        """Whether it is of a robot alone, without a payload."""
        return self.best is None and self.weighed is None

    @property
    def mass(self) -> float:
        """The answer's mass [kg]; nan without one."""
        if self.weighed is not None:
            return self.weighed.mass
        return self.best.mass if self.best is not None else float("nan")

    @property
    def pull(self) -> Pull | None:
        """What pulls at the flange hardest, of what stands out: it looks like a scale or another robot, too."""
        return max((pull for pull in self.pulls if pull.stands_out), key=lambda pull: pull.z, default=None)

    @property
    def modelled(self) -> list[PayloadEstimate]:
        """Estimates of methods that model the robot: the residual of method 3 is that of a torque difference."""
        return [estimate for estimate in self.estimates if estimate.method != 3]


def by(estimates: Sequence[PayloadEstimate]) -> str:
    """The methods in words."""
    numbers = ", ".join(str(estimate.method) for estimate in estimates)
    return f"method {numbers}" if len(estimates) == 1 else f"each of methods {numbers}"
