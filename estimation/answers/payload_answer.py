"""Answers of ``payload`` and ``weigh``: estimates, quantities with intervals, and whether to use them."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from msgspec import UNSET

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.speech import Speaks
from ...model import InertialParameters, Recording
from ...model.inertia import PayloadSpread, payload_spread
from ..diagnosis.checks import allowing, judge_com, judge_inertia, judge_mass
from ..diagnosis.evidence import Agreement, Judged
from ..diagnosis.finding import Verdict
from ..diagnosis.joints import worst_joint
from ..equations.equations import PAYLOAD, Equations
from ..fit.covariance import NORMAL95, student95
from ..fit.drive_gains import Gains
from ..fit.essential import Elimination
from ..fit.estimate import Estimate, Fit, error_model
from ..fit.least_squares import Excitation, excitation
from ..payload.by_joints import ByJoints
from ..payload.long_motion import LongMotion
from ..payload.methods import PayloadProblem, combined, essential_combined, recommended_method
from ..payload.repeats import Repeats
from ..payload.result import ConstrainedPayload, PayloadEstimate, StandIn
from ..payload.short_motion import ShortMotion
from ..possible.constraints import KnownMass
from ..possible.payload import Weighing
from ..results.parts import (
    EliminationDocument,
    GainErrorsDocument,
    ProcessingDocument,
    ResidualDocument,
    RobustDocument,
    VerdictDocument,
)
from ..results.payload import (
    AgreementDocument,
    Assumed,
    ConstantTorques,
    FlangeDocument,
    FreeEstimate,
    PayloadData,
    PayloadResult,
    PossibleEstimate,
    Quantity,
    Recommended,
    VisibilityDocument,
    WeighedDocument,
    mass_by_joints,
    named,
)
from .identification import elimination_warnings
from .system import DRAWN, TorquePrediction, payload_prediction, robot_prediction

_UNKNOWN = np.full(10, np.nan)
_VAGUE = "not measured well enough"
_BY_LEVEL = {
    "use": ("use", "use", "use"),
    "mass_and_com_only": ("use", "use", _VAGUE),
    "do_not_use": ("do not use",) * 3,
}
"""Most that may be done with mass, centre of mass and inertia, by the verdict."""


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
    held_out: tuple[Recording, ...] = ()
    agreement: tuple[Agreement, ...] = ()
    repeats: Repeats | None = None
    stand_in: StandIn | None = None

    @property
    def headline(self) -> str:
        """State mass, interval and verdict in a line."""
        return self.result.headline

    @cached_property
    def result(self) -> PayloadResult:
        """Result that ``--json`` writes: ``answer.result.mass.low``."""
        return payload_result(self).made_by(self)

    @cached_property
    def recommendation(self) -> tuple[int, str]:
        """Method to use, of those that found a payload that can exist, and the reason."""
        return recommended_method(self.problem, [payload.method for payload in self.constrained or self.estimates])

    @property
    def recommended(self) -> ConstrainedPayload:
        """Possible estimate to use: of method 3 where a pair ran one path, else of the first of 4, 1, 2."""
        return next(payload for payload in self.constrained if payload.method == self.recommendation[0])

    @property
    def possible(self) -> ConstrainedPayload | None:
        """Possible estimate of the ``recommended`` method; None where not all ten are determined."""
        return self.recommended if self.constrained else None

    @property
    def free(self) -> PayloadEstimate:
        """Free estimate of the method to use."""
        return next(estimate for estimate in self.estimates if estimate.method == self.recommendation[0])

    @property
    def short(self) -> ShortMotion:
        """Short motion of a weighing."""
        assert isinstance(self.problem, ShortMotion)
        return self.problem

    @property
    def robot_fit(self) -> Fit | None:
        """Fit of the robot's own parameters without payload."""
        return self.problem.robot_estimate.fit if self.problem.robot_estimate is not None else None

    @cached_property
    def model(self) -> Estimate:
        """Free estimate with the covariance that its errors really have, gains included."""
        return error_model(self.free.estimate, self.gains)

    @cached_property
    def _with_scale(self) -> tuple[Array, Array]:
        """Free values and their covariance, the scale counted once."""
        values, C = self.model.values, self.model.covariance
        if self.scale is None or self.free.from_scale:
            return values, C
        k = self.free.indices.index(9)
        # The scale is one more measurement, of x[k] alone: Kalman's update.
        gain = C[:, k] / (C[k, k] + self.scale.sigma**2)
        return values + gain * (self.scale.mass - values[k]), C - np.outer(gain, C[k])

    @cached_property
    def ten(self) -> Array:
        """Reported ten parameters, nan where not determined, shape (10,)."""
        if self.possible is not None:
            return self.possible.body.vector
        values = np.array(_UNKNOWN)
        values[list(self.free.indices)] = self._with_scale[0]
        return values

    @cached_property
    def spread(self) -> PayloadSpread:
        """Standard deviations of the reported payload, that of the scale counted."""
        return payload_spread(self.ten, self._with_scale[1], self.free.indices)

    @cached_property
    def reported_spread(self) -> PayloadSpread:
        """Half the reported 95 % intervals over 1.96; constraints may make the mass's shorter."""
        spread = allowing(self.spread, self.model.degrees_of_freedom)
        low, high = self.mass_interval
        half = 0.5 * (high - low) / NORMAL95
        return replace(spread, mass=min(spread.mass, half)) if np.isfinite(half) else spread

    @cached_property
    def measured(self) -> dict[str, Judged]:
        """Quantities ("mass", "centre of mass", "inertia") mapped to whether they were measured well enough."""
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
        """Quantities ("mass", "centre of mass", "inertia") mapped to what to do with them."""
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
        """Payload with the assumed inertia, where there is one."""
        return None if self.stand_in is None else self.stand_in.body(self.mass, self.com)

    def assuming(self, stand_in: StandIn) -> "PayloadAnswer":
        """Assume an inertia, unless one was measured well enough.

        Raises:
            InputError: if there is no place to put it.
        """
        if self.judged["inertia"].use == "use" and self.verdict.level != "mass_and_com_only":
            return self
        if not np.isfinite(self.com).all():
            raise InputError(
                f"an inertia cannot be assumed about a centre of mass that is not known: "
                f"{self.judged['centre of mass'].why}"
            )
        return replace(self, stand_in=stand_in)

    @property
    def weighing(self) -> Weighing | None:
        """Weighed mass beside the identified one; None where the scale gave the mass, or nothing was weighed."""
        if self.scale is None or self.free.from_scale:
            return None
        if self.possible is not None:
            return self.possible.weighings[0]
        k, model = self.model.names.index("M_L"), self.model
        sigma = float(model.sigma[k])
        return Weighing(self.scale.mass, self.scale.sigma, float(model.values[k]), sigma, model.degrees_of_freedom)

    @cached_property
    def elimination(self) -> Elimination | None:
        """Essential parameters of robot and payload together, where method 4 was used."""
        if not isinstance(self.problem, LongMotion) or all(payload.method != 4 for payload in self.constrained):
            return None
        return essential_combined(self.problem, self.problem.settings.essential)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Reasons against a robot or payload with the eliminated parameters zero."""
        if not isinstance(self.problem, LongMotion) or self.elimination is None:
            return ()
        return elimination_warnings(self.problem, self.elimination)

    @cached_property
    def excitation(self) -> Excitation | None:
        """Excitation of robot and payload together (30); None without the robot's own equations."""
        if not isinstance(self.problem, LongMotion) or self.problem.unloaded is None:
            return None
        return excitation(self.problem.both, combined(self.problem))

    @cached_property
    def predictions(self) -> tuple[TorquePrediction, ...]:
        """Torques of a few held-out recordings without payload, then of loaded ones, which were used.

        Empty where the robot's own parameters are not known.
        """
        problem = self.problem
        if problem.robot_estimate is None:
            return ()
        settings, values = problem.source.processing, problem.robot_estimate.values
        unloaded = [
            robot_prediction(problem.robot, problem.base, values, recording, settings, True)
            for recording in self.held_out[:DRAWN]
        ]
        return (*unloaded, *(self.prediction(recording, False) for recording in problem.source.loaded[:DRAWN]))

    def prediction(self, recording: Recording, held_out: bool) -> TorquePrediction:
        """Predict a recording with payload by the recommended payload, and by the unloaded robot."""
        settings = self.problem.source.processing
        return payload_prediction(self.problem, self.recommended.body, recording, settings, held_out)


def payload_result(answer: PayloadAnswer) -> PayloadResult:
    """Collect what ``payload`` and ``weigh`` answer; a number that was not determined is nan or None."""
    problem, flange, source = answer.problem, answer.problem.robot.flange_pose, answer.problem.source
    robot, gains, worst = problem.robot, answer.gains, worst_joint(answer.by_joints, answer.mass)
    flange_source = robot.sources.get("flange", "")
    return PayloadResult(
        robot=robot.name,
        robot_title=robot.title or UNSET,
        frame=robot.payload_frame,
        flange_in_payload_frame=FlangeDocument(flange.p, np.degrees(flange.rpy) + 0.0, flange_source)
        if flange
        else UNSET,
        rated_payload_kg=robot.rated_payload,
        processing=ProcessingDocument.made(robot, source.processing, source.loaded[0].gains),
        estimates=_estimates(answer),
        recommended=Recommended(
            answer.free.method, "constrained" if answer.constrained else "wls", answer.recommendation[1]
        ),
        gain_sigma=GainErrorsDocument.made(gains) if gains is not None else UNSET,
        mass_by_joints=mass_by_joints(answer.by_joints),
        joint_that_agrees_least=worst.text if worst else None,
        quantities=_quantities(answer),
        verdict=VerdictDocument.made(answer.verdict),
        scale=(answer.scale.mass, answer.scale.sigma) if answer.scale is not None else UNSET,
        **(_of_long(answer, problem) if isinstance(problem, LongMotion) else _of_short(answer, problem)),
    )


def _of_long(answer: PayloadAnswer, long: LongMotion) -> dict[str, Any]:
    """Keys of a long motion's result: the residual is that of the robot's own parameters."""
    fit, check, steps, unloaded = answer.robot_fit, answer.validation, answer.elimination, long.unloaded
    differing = {3, 4} | ({1} if long.corrected and not long.settings.free_friction else set())
    differs = bool(long.friction) and any(estimate.method in differing for estimate in answer.estimates)
    # Of robot and payload together, as in Table 2, where method 4 was used.
    names = dict(zip(long.base.columns, long.base.names, strict=True))
    return {
        "relative_residual": ResidualDocument(
            fit.relative if fit else None,
            fit.relative_per_joint if fit else None,
            ResidualDocument.of(check) if check else None,
        ),
        "data": _data(
            long,
            unloaded,
            equations=(unloaded or long.loaded).equations,
            equations_loaded=long.loaded.equations,
            base_parameters=len(long.base.columns),
            friction="may differ" if differs else "own",
        ),
        "friction": long.source.choices or UNSET,
        "essential": EliminationDocument.made(steps, answer.warnings, names) if steps else None,
        "left_out": {str(method): reason for method, reason in answer.left_out.items()},
    }


def _of_short(answer: PayloadAnswer, short: ShortMotion) -> dict[str, Any]:
    """Keys of a short motion's result: the residual is the payload's."""
    body, stand_in, loaded = answer.assumed, answer.stand_in, short.loaded
    friction = "free" if short.known is None else "may differ" if short.held.held else "own"
    unexplained = answer.free.unexplained(short.torque_rms)
    return {
        "relative_residual": ResidualDocument(answer.free.estimate.fit.relative, unexplained, None),
        "data": _data(short, loaded.select(PAYLOAD), equations=loaded.equations, friction=friction),
        "joints": tuple(short.joints),
        "visibility": VisibilityDocument.of(short.visibility),
        "constant_torques": ConstantTorques(tuple(j + 1 for j in short.held.joints), short.held.sigma),
        "ripple": tuple(wave for run in short.runs for wave in run.ripple),
        "mass_from_scale": answer.free.from_scale,
        "agreement": tuple(map(AgreementDocument.of, answer.agreement)),
        "repeats": answer.repeats,
        "assumed": Assumed(stand_in.description, body.named()) if stand_in and body else None,
    }


def _data(problem: PayloadProblem, solved: Equations | None, **more: Any) -> PayloadData:
    """Summarise the equations of the robot; of a short motion, of the payload."""
    pairs = problem.pairs
    worst = max(pairs, key=lambda pair: pair.max_mismatch, default=None)
    raw, scaled = solved.condition_numbers() if solved else (None, None)
    return PayloadData(
        rate=problem.source.rate,
        cutoff=problem.source.processing.cutoff,
        lag_s=pairs[0].lag if pairs else None,
        lags_s=tuple(pair.lag for pair in pairs),
        max_position_mismatch_rad=worst.max_mismatch if worst else None,
        rms_position_mismatch_rad=worst.rms_mismatch if worst else None,
        condition_number=raw,
        condition_number_scaled=scaled,
        **more,
    )


def _estimates(answer: PayloadAnswer) -> tuple[FreeEstimate | PossibleEstimate, ...]:
    """List free estimates, then possible ones; of a payload that is visible in part what was determined."""
    if answer.constrained:
        return (*map(FreeEstimate.made, answer.estimates), *map(PossibleEstimate.made, answer.constrained))
    free, estimate, weighing = answer.free, answer.free.estimate, answer.weighing
    robust = estimate.sigma_robust
    return (
        FreeEstimate(
            method=free.method,
            parameters=named(answer.ten),
            sigma=named(estimate.sigma, free.indices),
            sigma_robust=named(robust, free.indices) if robust is not None else None,
            interval95=None,
            robust=RobustDocument.made(estimate.robust, free.without_robust),
            com=answer.com,
            com_sigma=answer.spread.com,
            inertia_com=None,
            physically_consistent=None,
            sigma_with_gains=named(answer.model.sigma, free.indices) if answer.gains else UNSET,
            from_scale=free.from_scale or UNSET,
            weighed=(WeighedDocument.of(weighing),) if weighing is not None else UNSET,
        ),
    )


def _quantities(answer: PayloadAnswer) -> dict[str, Quantity]:
    """Make mass, centre of mass and inertia with intervals, and their use; of a long motion by the verdict."""
    possible, spread = answer.possible, answer.spread
    body = answer.assumed or (possible.body if possible is not None else None)
    measured = answer.stand_in is None and possible is not None
    values: dict[str, tuple[Any, Any, Any]] = {
        "mass": (answer.mass, answer.mass_interval, spread.mass),
        "centre of mass": (answer.com, answer.com_interval, spread.com),
        "inertia": (
            body.inertia_com if body is not None else None,
            possible.intervals.inertia_com if measured and possible is not None else None,
            spread.inertia_com if measured else None,
        ),
    }
    allowed = _BY_LEVEL[answer.verdict.level]
    if isinstance(answer.problem, LongMotion):
        uses = [(use, "") for use in allowed]
    else:  # quantity by quantity, as far as the verdict on all allows
        own = [(judged.use, judged.why) for judged in map(answer.judged.__getitem__, values)]
        uses = [(most, "") if use == "use" else (use, why) for (use, why), most in zip(own, allowed, strict=True)]
    return {
        name.replace(" ", "_"): Quantity(use, why or None, *entry)
        for (name, entry), (use, why) in zip(values.items(), uses, strict=True)
    }
