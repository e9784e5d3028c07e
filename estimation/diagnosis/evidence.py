"""Evidence for a verdict, the findings that it gives, and the verdict that they add up to."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from ...common import Array, Document, Float, Vector
from ...model import Robot
from ...model.inertia import PayloadSpread
from ..fit.estimate import Estimate, Fit
from ..payload.by_joints import ByJoints, Repeats
from ..payload.long_motion import Source
from ..payload.methods import ConstrainedPayload, PayloadEstimate
from ..payload.short_motion import StaticMotion
from ..signals.filtering import AlignedPair
from .engine import Effect

Severity = Literal["error", "warning", "note"]
"""Severity: error: nothing may be used so; warning: numbers are poor or not all for use; note: worth knowing."""
Level = Literal["use", "mass_and_com_only", "identified_only", "do_not_use"]
"""Level of use: every number; of a payload mass and centre of mass; of gains those that are identified; none."""


class Finding(NamedTuple):
    """Fault or remark on recordings, or on numbers made from them."""

    severity: Severity
    about: str  # the quantity, joint or recording; "everything" where it is all of them
    text: str  # what, where, what to do
    cause: bool = False  # whether it says where other findings may come from
    explains: float = 0.0  # of a cause: fraction of the squared residual that it takes off


def error(text: str, about: str = "everything") -> Finding:
    """Make a finding against every number."""
    return Finding("error", about, text)


def warning(text: str, about: str = "inertia") -> Finding:
    """Make a finding against the inertia, or some other number, only."""
    return Finding("warning", about, text)


def note(text: str, about: str = "everything") -> Finding:
    """Make a finding that is worth knowing."""
    return Finding("note", about, text)


class Verdict(Document, frozen=True, dict=True, omit_defaults=True):
    """Verdict on the use of numbers: what speaks against them, and what else is worth knowing."""

    level: Level
    reasons: tuple[str, ...]
    notes: tuple[str, ...] = ()

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Findings that it was made from; none where it was read from a file."""
        return self.working or ()


Use = Literal["use", "not measured well enough", "not visible", "weighed", "assumed"]
"""Use of a quantity; ``weighed``: not by torques, by a scale."""
Judged = tuple[Use, str]  # use of one quantity, and why; empty where it may be used without more
KNOWN_WELL = 0.05  # relative standard deviation up to which a drive gain counts as identified
UNFREED = "friction not freed"
"""Name of the way to the mass that may differ: with the friction of the motion without payload."""


class Agreement(Document, frozen=True, eq=False):
    """Mass [kg] and centre of mass [m] by another way, nan where it gives none."""

    name: str
    mass: Float
    com: Vector


class Alternative(NamedTuple):
    """Comparison with another reading of the recordings."""

    kind: str  # "robot", "turned", "weightless" or "friction"
    name: str  # of the robot, or number of the joint
    fall: float  # fraction by which chi2 falls, negative where it rises
    z: float  # Vuong's statistic


class NominalGravity(NamedTuple):
    """Torques over those that gravity needs by the bodies of the robot's description."""

    ratio: Array  # of each joint, nan where it does not show it, shape (n,)
    gravity: Array  # that the torques of all joints show with these bodies, in frame 0 [m/s^2], shape (3,)
    gravity_sigma: float  # of that, all axes together
    explained: float  # by it, fraction of the squared torque beside friction
    by_joints: float  # the same by the described gravity and a ratio for each joint
    assumed: str  # rule by which bodies were assumed; empty where all are described


class Weighed(NamedTuple):
    """Mass of a short weighing and its standard deviation [kg], by the torques, else by the scale."""

    mass: float
    sigma: float
    from_scale: bool


@dataclass(frozen=True)
class Evidence:
    """Evidence computed from one set of recordings; checks of what a command does not compute are silent."""

    robot: Robot
    source: Source | None = None  # the recordings, in which causes are searched
    by_joints: ByJoints = ByJoints((), ())  # the payload as single joints see it
    disagreement: float = 1.0  # Birge ratio of the joints' payload ratios, a factor on every interval
    unexcused: float = 1.0  # the same with drive gains as exact
    effects: Mapping[str, Effect] = field(default_factory=dict)  # of the hypotheses that add columns, by name
    alternatives: tuple[Alternative, ...] = ()
    scales: tuple[Effect, ...] = ()  # another scale of the loaded torques: of all, of each joint's
    nominal: NominalGravity | None = None  # torques against the weight of the links by the description
    pairs: tuple[AlignedPair, ...] = ()  # recordings of one motion without and with payload
    condition: float | None = None  # number of the equations without payload, columns scaled to norm 1
    parameters: Estimate | None = None  # the robot's own, where they were identified or stored
    validation: Fit | None = None  # of those, on recordings that were held out
    possible: float | None = None  # p-value of the nearest robot that can exist, by blocks of time
    estimates: tuple[PayloadEstimate, ...] = ()  # free ones of the methods
    constrained: tuple[ConstrainedPayload, ...] = ()  # the possible payload of each method that has one
    recommended: ConstrainedPayload | None = None
    weighed: Weighed | None = None
    unexplained: Array = field(default_factory=lambda: np.zeros(0))
    """Error over torque of each joint of a short weighing, nan where it is at rest, shape (n,)."""
    agreement: tuple[Agreement, ...] = ()  # of a short weighing: the mass by other ways
    repeats: Repeats | None = None  # of several recordings of one
    at_rest: StaticMotion | None = None  # a weighing at rest
    spread: PayloadSpread | None = None  # half the intervals reported of what is recommended, over 1.96
    judged: Mapping[str, Judged] = field(default_factory=dict)  # of "mass", "centre of mass", "inertia"
    gained: Array | None = None  # relative standard deviations of drive gains, (n,), where these are asked for
    weights: tuple[tuple[int, float, float, float], ...] = ()
    """Of each mounting of a known weight its number, nominal mass, that by the gains, and its deviation [kg]."""

    @cached_property
    def white_noise(self) -> Array | None:
        """White noise of each joint's equations by the recordings' second differences [N·m or N], (n,)."""
        parts = list[Array]()
        if (source := self.source) is None:
            return None
        for one in (*source.unloaded, *source.loaded):
            thinned = source.processing.thinning(min(one.rate, source.rate or one.rate))
            parts.append(np.mean(np.diff(one.torque, 2, axis=0) ** 2, axis=0) / (6.0 * thinned))
        return np.asarray(np.sqrt(np.mean(parts, axis=0))) if parts else None

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
