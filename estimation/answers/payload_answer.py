"""What ``payload`` and ``weigh`` answer: estimates, quantities with intervals, and whether to use them."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.speech import Speaks
from ...model import InertialParameters, Recording
from ...model.inertia import PayloadSpread, payload_spread
from ..diagnosis.checks import allowing, judge_com, judge_inertia, judge_mass
from ..diagnosis.evidence import Agreement, Judged
from ..diagnosis.finding import Verdict
from ..fit.covariance import NORMAL95, student95
from ..fit.drive_gains import Gains
from ..fit.essential import Elimination
from ..fit.estimate import Estimate, Fit, error_model
from ..fit.least_squares import Excitation, excitation
from ..payload.by_joints import ByJoints
from ..payload.constrained import ConstrainedPayload
from ..payload.long_motion import LongMotion
from ..payload.methods import PayloadProblem, combined
from ..payload.recommended import Recommendation, recommended_method
from ..payload.repeats import Repeats
from ..payload.result import PayloadEstimate
from ..payload.short_motion import ShortMotion
from ..payload.stand_in import StandIn
from ..possible.constraints import KnownMass
from ..possible.result import Weighing
from .system import DRAWN, TorquePrediction, payload_prediction, robot_prediction


class Quantity(NamedTuple):
    """A number with its 95 % interval, nan where it is not determined.

    Attributes:
        low, high: bounds of its 95 % interval.
        unit: of all three.
        use: whether it may be used.
    """

    value: float
    low: float
    high: float
    unit: str
    use: bool

    def __float__(self) -> float:
        """The number alone."""
        return self.value

    def __str__(self) -> str:
        """Number, interval and unit."""
        return f"{self.value:.6g} {self.unit} (95 % from {self.low:.6g} to {self.high:.6g})"


class CentreOfMass(NamedTuple):
    """The centre of mass [m] along the axes of the payload's frame."""

    x: Quantity
    y: Quantity
    z: Quantity


class Inertia(NamedTuple):
    """Entries of the inertia matrix at the centre of mass [kg m^2], axes of the payload's frame."""

    xx: Quantity
    yy: Quantity
    zz: Quantity
    xy: Quantity
    xz: Quantity
    yz: Quantity


class NamedPayload(NamedTuple):
    """A payload with its intervals by name.

    Attributes:
        mass: [kg].
        com: centre of mass [m].
        inertia: at the centre of mass [kg m^2].
        frame: they are given in, in words.
        body: as a body; None where not all ten parameters are determined.
    """

    mass: Quantity
    com: CentreOfMass
    inertia: Inertia
    frame: str
    body: InertialParameters | None


_UNKNOWN = np.full(10, np.nan)
_ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Places of the inertia's entries, moments first."""


@dataclass(frozen=True, repr=False)
class PayloadAnswer(Speaks):
    """Payload estimates with what is needed to judge them; of a short motion as far as it shows the payload.

    Attributes:
        estimates: one per method, in the order of the methods; methods for which no possible payload was found are
            left out.
        constrained: for each complete one of ``estimates`` the nearest payload that holds the constraints, with
            intervals.
        left_out: method -> why it gave no estimate.
        validation: fit of the robot's own parameters on recordings that were held out.
        elimination: essential parameters of robot and payload together, where method 4 was used.
        warnings: what speaks against a robot or payload with the eliminated parameters zero.
        held_out: recordings without payload of ``validation``.
        agreement: other ways to the numbers of a short motion.
        repeats: of several recordings of a short motion, each of them alone.
        stand_in: an assumed inertia, where it was asked for and none was measured well enough.
    """

    problem: PayloadProblem
    estimates: tuple[PayloadEstimate, ...]
    constrained: tuple[ConstrainedPayload, ...]
    left_out: dict[int, str]
    by_joints: ByJoints
    verdict: Verdict
    scale: KnownMass | None = None
    gains: Gains | None = None
    validation: Fit | None = None
    elimination: Elimination | None = None
    warnings: tuple[str, ...] = ()
    held_out: tuple[Recording, ...] = ()
    agreement: tuple[Agreement, ...] = ()
    repeats: Repeats | None = None
    stand_in: StandIn | None = None

    @property
    def headline(self) -> str:
        """Mass, interval and verdict in a line."""
        mass = self.payload.mass
        return f"{self.problem.robot.name}, mass {mass}, {self.verdict.level.replace('_', ' ')}"

    @cached_property
    def payload(self) -> NamedPayload:
        """Mass, centre of mass and inertia with their 95 % intervals by name: ``answer.payload.mass.low``."""
        uses, places = self._uses, zip(self.com, self.com_interval, strict=True)
        com = [_quantity(x, bounds, "m", uses["centre of mass"]) for x, bounds in places]
        inertia, bounds = np.full((3, 3), np.nan), np.full((3, 3, 2), np.nan)
        if self.possible is not None:
            inertia, bounds = self.possible.body.inertia_com, self.possible.intervals.inertia_com
        entries = [_quantity(inertia[at], bounds[at], "kg m^2", uses["inertia"]) for at in _ENTRIES]
        return NamedPayload(
            mass=Quantity(self.mass, *self.mass_interval, "kg", uses["mass"]),
            com=CentreOfMass(*com),
            inertia=Inertia(*entries),
            frame=self.problem.robot.payload_frame,
            body=self.possible.body if self.possible is not None else None,
        )

    @property
    def _uses(self) -> dict[str, bool]:
        """Whether each quantity may be used: by the verdict, of a short motion each by itself too."""
        level = self.verdict.level
        usable = level != "do_not_use"
        if isinstance(self.problem, LongMotion):
            return {"mass": usable, "centre of mass": usable, "inertia": level == "use"}
        return {name: usable and judged.use in ("use", "weighed") for name, judged in self.judged.items()}

    def export(self, to: str, despite_verdict: bool = False) -> str:
        """The payload in the format of a controller or a simulator, at the flange; see ``dynident export --to``.

        Args:
            to: name of the format, such as "ur".
            despite_verdict: give it whatever the verdict is.

        Raises:
            InputError: for another name, or a payload that must not be used.
        """
        return str(Speaks.shown_by().export(self, to, despite_verdict))

    @property
    def recommendation(self) -> Recommendation:
        """Which method to use, of those that found a payload that can exist, and why."""
        return recommended_method(self.problem, [payload.method for payload in self.constrained or self.estimates])

    @property
    def recommended(self) -> ConstrainedPayload:
        """The one to use: of method 3 where a pair ran one path, else of the first of 4, 1, 2 that is there."""
        return next(payload for payload in self.constrained if payload.method == self.recommendation.method)

    @property
    def possible(self) -> ConstrainedPayload | None:
        """``recommended``; None where not all ten are determined."""
        return self.recommended if self.constrained else None

    @property
    def free(self) -> PayloadEstimate:
        """The free estimate of the method to use."""
        return next(estimate for estimate in self.estimates if estimate.method == self.recommendation.method)

    @property
    def short(self) -> ShortMotion:
        """The short motion, of a weighing."""
        assert isinstance(self.problem, ShortMotion)
        return self.problem

    @property
    def robot_fit(self) -> Fit | None:
        """Fit of the robot's own parameters without payload."""
        return self.problem.alone.fit if self.problem.alone is not None else None

    @cached_property
    def model(self) -> Estimate:
        """The free estimate with the covariance that its errors really have, gains included."""
        return error_model(self.free.estimate, self.gains)

    @cached_property
    def _with_scale(self) -> tuple[Array, Array]:
        """The free values and their covariance, the scale counted once."""
        values, C = self.model.values, self.model.covariance
        if self.scale is None or self.free.from_scale:
            return values, C
        k = self.free.places.index(9)
        gain = C[:, k] / (C[k, k] + self.scale.sigma**2)
        return values + gain * (self.scale.mass - values[k]), C - np.outer(gain, C[k])

    @cached_property
    def ten(self) -> Array:
        """The ten as told, nan where not determined, shape (10,)."""
        if self.possible is not None:
            return self.possible.body.vector
        values = np.array(_UNKNOWN)
        values[list(self.free.places)] = self._with_scale[0]
        return values

    @cached_property
    def spread(self) -> PayloadSpread:
        """Standard deviations of the reported payload, that of the scale counted."""
        return payload_spread(self.ten, self._with_scale[1], self.free.places)

    @cached_property
    def reported_spread(self) -> PayloadSpread:
        """Half the reported 95 % intervals over 1.96; constraints may make the mass's shorter."""
        spread = allowing(self.spread, self.model.degrees_of_freedom)
        low, high = self.mass_interval
        half = 0.5 * (high - low) / NORMAL95
        return replace(spread, mass=min(spread.mass, half)) if np.isfinite(half) else spread

    @cached_property
    def measured(self) -> dict[str, Judged]:
        """Whether "mass", "centre of mass", "inertia" were measured well enough."""
        wide = self.reported_spread
        best = self.possible
        moments = np.diag(best.body.inertia_com) if best is not None else _UNKNOWN[:3]
        return {
            "mass": judge_mass(self.ten[9], wide, self.free.from_scale),
            "centre of mass": judge_com(self.ten, wide),
            "inertia": judge_inertia(moments, wide),
        }

    @property
    def judged(self) -> dict[str, Judged]:
        """What to do with "mass", "centre of mass", "inertia"."""
        if self.stand_in is None:
            return self.measured
        return self.measured | {"inertia": Judged("assumed", self.stand_in.description)}

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return float(self.ten[9])

    @property
    def com(self) -> Array:
        """Centre of mass [m], nan where not determined, shape (3,)."""
        return np.asarray(self.ten[6:9] / self.ten[9])

    @property
    def mass_interval(self) -> tuple[float, float]:
        """95 % interval of the mass [kg]; nan where a constraint contradicts the data."""
        if self.possible is not None:
            low, high = self.possible.intervals.parameters[9]
            return float(low), float(high)
        return self._around(self.mass, self.spread.mass)

    @property
    def com_interval(self) -> Array:
        """95 % intervals of the centre of mass [m], 3 x 2."""
        if self.possible is not None:
            return self.possible.intervals.com
        return np.array([self._around(x, s) for x, s in zip(self.com, self.spread.com, strict=True)])

    def _around(self, value: float, sigma: float) -> tuple[float, float]:
        half = student95(self.model.degrees_of_freedom) * sigma
        return (value - half, value + half) if np.isfinite(half) else (float("nan"), float("nan"))

    @property
    def assumed(self) -> InertialParameters | None:
        """The payload with the assumed inertia, where there is one."""
        return None if self.stand_in is None else self.stand_in.body(self.mass, self.com)

    def assuming(self, stand_in: StandIn) -> "PayloadAnswer":
        """The answer with an assumed inertia, unless one was measured well enough.

        Raises:
            InputError: if there is no place to put it.
        """
        if self.judged["inertia"].use == "use":
            return self
        if not np.isfinite(self.com).all():
            raise InputError(
                f"an inertia cannot be assumed about a centre of mass that is not known: "
                f"{self.judged['centre of mass'].why}"
            )
        return replace(self, stand_in=stand_in)

    @property
    def weighing(self) -> Weighing | None:
        """The scale beside the identified mass; None where the scale gave the mass, or nothing was weighed."""
        if self.scale is None or self.free.from_scale:
            return None
        if self.possible is not None:
            return self.possible.weighings[0]
        k, model = self.model.names.index("M_L"), self.model
        sigma = float(model.sigma[k])
        return Weighing(self.scale.mass, self.scale.sigma, float(model.values[k]), sigma, model.degrees_of_freedom)

    @cached_property
    def excitation(self) -> Excitation | None:
        """How well robot and payload are excited together (30); None without the robot's own equations."""
        if not isinstance(self.problem, LongMotion) or self.problem.unloaded is None:
            return None
        return excitation(self.problem.both, combined(self.problem))

    @cached_property
    def predictions(self) -> tuple[TorquePrediction, ...]:
        """Torques of a few held-out recordings without payload, then of loaded ones, which were used.

        None where the robot's own parameters are not known.
        """
        problem = self.problem
        if problem.alone is None:
            return ()
        settings, values = problem.source.processing, problem.alone.values
        bare = [
            robot_prediction(problem.robot, problem.base, values, recording, settings, True)
            for recording in self.held_out[:DRAWN]
        ]
        return (*bare, *(self.prediction(recording, False) for recording in problem.source.loaded[:DRAWN]))

    def prediction(self, recording: Recording, held_out: bool) -> TorquePrediction:
        """A recording with payload and what the recommended payload predicts, beside the bare robot."""
        settings = self.problem.source.processing
        return payload_prediction(self.problem, self.recommended.body, recording, settings, held_out)


def _quantity(value: float, interval: Array, unit: str, use: bool) -> Quantity:
    low, high = interval.tolist()
    return Quantity(float(value), low, high, unit, use and bool(np.isfinite(value)))
