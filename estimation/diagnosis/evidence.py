"""Evidence for a verdict: the diagnosis of the recordings, and the numbers that were computed from them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

from ...common.arrays import Array
from ...model import Robot
from ...model.inertia import PayloadSpread
from ..fit.estimate import Estimate, Fit
from ..gains.current_side import RelativeScales
from ..payload.by_joints import ByJoints
from ..payload.long_motion import Source
from ..payload.repeats import Repeats
from ..payload.result import ConstrainedPayload, PayloadEstimate
from ..signals.alignment import AlignedPair
from .engine import Effect

Use = Literal["use", "not measured well enough", "not visible", "weighed", "assumed"]
"""Use of a quantity; ``weighed``: not by torques, by a scale."""


class Judged(NamedTuple):
    """Use of one quantity, and why; empty where it may be used without more."""

    use: Use
    why: str = ""


class Agreement(NamedTuple):
    """Mass [kg] and centre of mass [m] by another way, nan where it gives none.

    ``counts``: whether a large difference speaks against the numbers.
    """

    name: str
    mass: float
    com: Array
    counts: bool = True


class Alternative(NamedTuple):
    """Comparison with another reading of the recordings.

    ``kind``: "robot", "turned", "weightless" or "friction"; ``name``: of the robot, or number of the joint;
    ``fall``: fraction by which chi2 falls, negative where it rises; ``z``: Vuong's statistic.
    """

    kind: str
    name: str
    fall: float
    z: float


@dataclass(frozen=True)
class Diagnosis:
    """Diagnosis of what else than robot and payload one set of recordings shows, for every command alike.

    Attributes:
        by_joints: the payload as single joints see it.
        disagreement: Birge ratio of the joints' payload ratios, a factor on every interval; 1 where they agree.
        effects: of the hypotheses that add columns.
        alternatives: other readings of the recordings.
        scales: effects of another scale of the loaded torques, of all and of each joint's.
        signals: scales of the joints' signals, of a robot alone.
    """

    by_joints: ByJoints = ByJoints((), ())
    disagreement: float = 1.0
    effects: tuple[Effect, ...] = ()
    alternatives: tuple[Alternative, ...] = ()
    scales: tuple[Effect, ...] = ()
    signals: RelativeScales | None = None

    def effect(self, name: str) -> Effect | None:
        """Effect of one hypothesis."""
        return next((effect for effect in self.effects if effect.name == name), None)


KNOWN_WELL = 0.05
"""Relative standard deviation up to which a drive gain counts as identified."""


class KnownWeight(NamedTuple):
    """A weight of nominal mass and the ``mass`` that the gains give it, with its deviation ``sigma`` [kg]."""

    mounting: int
    nominal: float
    mass: float
    sigma: float


class Gained(NamedTuple):
    """Identified drive gains: their relative standard deviations, (n,), and the weight of each mounting."""

    sigma: Array
    weights: tuple[KnownWeight, ...]


@dataclass(frozen=True)
class Weighed:
    """Evidence of a short weighing only.

    Attributes:
        mass: by the torques, else by the scale [kg].
        sigma: its standard deviation [kg].
        from_scale: whether a scale gave it.
        unexplained: error over torque of each joint, nan where it is at rest, shape (n,).
        repeats: of several recordings, the mass by each.
        agreement: other ways to the mass.
    """

    mass: float
    sigma: float
    from_scale: bool
    unexplained: Array
    repeats: Repeats | None = None
    agreement: tuple[Agreement, ...] = ()


@dataclass(frozen=True)
class Evidence:
    """Evidence computed from one set of recordings; checks of what a command does not compute are silent.

    Attributes:
        source: the recordings, in which causes are searched.
        diagnosis: what they show besides robot and payload.
        pairs: recordings of one motion without and with payload.
        compared: recordings without and with payload, whether of one motion or not.
        condition: condition number of the equations without payload, columns scaled to norm 1.
        parameters: the robot's own, where they were identified or stored.
        validation: fit of those on recordings that were held out.
        estimates: the methods' free estimates.
        constrained: the possible payload of each method for which one was found.
        recommended: the one of them that is to be used, if there is one.
        spread: standard deviations of what is recommended: half the reported intervals, over 1.96.
        judged: "mass", "centre of mass", "inertia": whether they were measured well enough.
        gained: drive gains, where they are what is asked for.
    """

    robot: Robot
    source: Source | None = None
    diagnosis: Diagnosis = Diagnosis()
    pairs: tuple[AlignedPair, ...] = ()
    compared: tuple[AlignedPair, ...] = ()
    condition: float | None = None
    parameters: Estimate | None = None
    validation: Fit | None = None
    estimates: tuple[PayloadEstimate, ...] = ()
    constrained: tuple[ConstrainedPayload, ...] = ()
    recommended: ConstrainedPayload | None = None
    weighed: Weighed | None = None
    spread: PayloadSpread | None = None
    judged: Mapping[str, Judged] = field(default_factory=dict)
    gained: Gained | None = None

    @property
    def best(self) -> PayloadEstimate | None:
        """Free estimate of the method that is to be used."""
        if self.recommended is not None:
            return self.recommended.free
        return self.estimates[-1] if self.estimates else None

    @property
    def of_robot(self) -> bool:
        """True for a robot without a payload."""
        return self.best is None and self.weighed is None

    @property
    def mass(self) -> float:
        """The answer's mass [kg]; nan without one."""
        if self.weighed is not None:
            return self.weighed.mass
        return self.best.mass if self.best is not None else float("nan")

    @property
    def modelled(self) -> list[PayloadEstimate]:
        """Estimates of methods that model the robot: the residual of method 3 is that of a torque difference."""
        return [estimate for estimate in self.estimates if estimate.method != 3]


def by(estimates: Sequence[PayloadEstimate]) -> str:
    """Name the methods."""
    numbers = ", ".join(str(estimate.method) for estimate in estimates)
    return f"method {numbers}" if len(estimates) == 1 else f"each of methods {numbers}"
