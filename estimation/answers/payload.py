"""Answers on a payload: estimates by every method that can be used, quantities with intervals, and a verdict."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import UNSET, structs

from ...common import Array, Brief, InputError, Speaks, one_thread
from ...model import Recording, Robot
from ...model.files.robot_file import PoseTable
from ...model.inertia import PayloadSpread, payload_spread
from ..diagnosis.checks import STILL, judged
from ..diagnosis.evidence import UNFREED, Agreement, Evidence, Verdict, Weighed
from ..diagnosis.scales import worst_joint
from ..diagnosis.verdict import allowing, diagnose, judge
from ..equations.equations import PAYLOAD, merged
from ..equations.observer import Observer
from ..fit.covariance import NORMAL95, few_blocks, student95
from ..fit.estimate import Estimate, Gains, error_model, usual_gains
from ..fit.linear_problem import Elimination, Excitation, eliminate, excitation, weighted
from ..fit.settings import DEFAULTS, Settings
from ..payload import methods
from ..payload.by_joints import repeats_of
from ..payload.long_motion import LongMotion, in_payload_frame, payload_problem
from ..payload.methods import ConstrainedPayload, PayloadEstimate, constrain_payload, moved
from ..payload.short_motion import ShortMotion, StaticMotion, difference_weighing, known_robot_weighing
from ..possible.constraints import Constraint, KnownMass, SolverError
from ..possible.payload import POSSIBLE, Weighing
from ..results import payload as documents
from ..results.parts import EliminationDocument, ProcessingDocument, ResidualDocument
from ..results.payload import FreeEstimate, PayloadResult, PossibleEstimate, TorquePrediction, named
from ..signals.recordings import check_given
from . import identification

if TYPE_CHECKING:  # loaded where an earlier identification is given
    from ..results.robot import RobotResult

_VAGUE = "not measured well enough"
# Most that may be done with mass, centre of mass and inertia, by the verdict.
_BY_LEVEL = {"use": ("use",) * 3, "mass_and_com_only": ("use", "use", _VAGUE), "do_not_use": ("do not use",) * 3}


@dataclass(frozen=True, eq=False, repr=False)
class PayloadAnswer(Speaks, Brief):
    """Payload estimates with what is needed to judge them; of a short motion as far as it shows the payload."""

    problem: methods.PayloadProblem
    estimates: tuple[PayloadEstimate, ...]  # by method, those left out for which no possible payload was found
    constrained: tuple[ConstrainedPayload, ...]  # nearest to each complete one of them
    left_out: dict[int, str]  # method -> why it gave no estimate
    recommendation: tuple[int, str]  # method to use, and the reason
    free: PayloadEstimate  # of that method
    possible: ConstrainedPayload | None  # its possible one; None where not all ten are determined
    model: Estimate  # the free one with the covariance that its errors really have, gains included
    ten: Array  # reported parameters, nan where not determined, shape (10,)
    spread: PayloadSpread  # their standard deviations, that of the scale counted
    intervals: Array  # 95 % of mass [kg] and centre of mass [m], 4 x 2; nan where there is none
    scale: KnownMass | None
    gains: Gains | None
    held_out: tuple[Recording, ...]
    evidence: Evidence
    verdict: Verdict

    @cached_property
    @one_thread()
    def result(self) -> PayloadResult:
        """Result that ``--json`` writes, ``answer.result.mass.low``; what was not determined is nan or None."""
        problem, source, robot, scale = self.problem, self.problem.source, self.problem.robot, self.scale
        evidence, spread, free, loaded = self.evidence, self.spread, self.free, self.problem.loaded
        said, flange = robot.sources.get("flange", ""), robot.flange_pose and PoseTable.of(robot.flange_pose)
        (method, reason), possible, ends = self.recommendation, self.possible, self.intervals
        # Free estimates, then possible ones; of a payload that is visible in part what was determined.
        estimates: list[FreeEstimate | PossibleEstimate] = list(map(FreeEstimate.made, self.estimates))
        estimates += map(PossibleEstimate.made, self.constrained)
        if not self.constrained:
            shown: dict[str, Any] = {"com": self.com, "com_sigma": spread.com, "parameters": named(self.ten)}
            shown |= {"sigma_with_gains": named(self.model.sigma, free.indices)} if self.gains else {}
            if scale is not None and not free.from_scale:
                shown["weighed"] = (Weighing.by(scale, self.model),)
            estimates = [structs.replace(FreeEstimate.made(free), **shown)]
        inertia: Any = possible and (possible.body.inertia_com, possible.intervals.inertia_com, spread.inertia_com)
        uses = [(use, "") for use in _BY_LEVEL[self.verdict.level]]
        if isinstance(problem, LongMotion):  # the residual is that of the robot's own parameters
            own, check, steps = problem.robot_estimate, evidence.validation, self.elimination
            differing = {3, 4} | ({1} if problem.corrected and not problem.settings.free_friction else set())
            differs = bool(problem.friction) and any(estimate.method in differing for estimate in self.estimates)
            against = ResidualDocument.of(check) if check else None
            solved, residual = problem.unloaded, ResidualDocument(None, None, against)
            residual = ResidualDocument.of(own.fit, validation=against) if own else residual
            counted: dict[str, Any] = {
                "equations": (solved or loaded).equations,
                "equations_loaded": loaded.equations,
                "base_parameters": len(problem.base.columns),
                "friction": "may differ" if differs else "own",
            }
            if problem.bare is not None and solved is not None and problem.inflation and source.unloaded:
                # Errors of each joint without payload, their memory counted, and independent ones a second.
                rate = source.processing.equations_a_second(source.unloaded[0].rate)
                counted["torque_noise"] = np.sqrt(np.median(problem.inflation)) * problem.bare.noise
                counted["independent"] = rate * solved.independent
            keys: dict[str, Any] = {
                "friction": source.choices or UNSET,
                # Of robot and payload together, as in Table 2, where method 4 was used.
                "essential": EliminationDocument.made(steps, self.warnings, problem.base) if steps else None,
                "left_out": {str(method): reason for method, reason in self.left_out.items()},
                "repeats": evidence.repeats or UNSET,
            }
        else:  # quantity by quantity, as far as the verdict on all allows; the residual is the payload's
            every = zip(evidence.judged.values(), uses, strict=True)
            uses = [most if own[0] == "use" else own for own, most in every]
            unexplained, held = free.unexplained(problem.torque_rms), problem.held
            standing = problem.standing if isinstance(problem, StaticMotion) else None
            # At rest inertia's columns are zero.
            solved = loaded.select([PAYLOAD[k] for k in problem.visibility.base.chosen] if standing else PAYLOAD)
            residual = ResidualDocument(free.estimate.fit.relative, unexplained, None)
            friction = "free" if problem.known is None else "may differ" if held.held else "own"
            counted = {"equations": loaded.equations, "friction": friction}
            keys = {
                "joints": tuple(problem.joints),
                "visibility": documents.VisibilityDocument.of(problem.visibility),
                "constant_torques": documents.ConstantTorques(
                    tuple((np.flatnonzero(held.sigma) + 1).tolist()), held.sigma
                ),
                "ripple": problem.ripple,
                "mass_from_scale": free.from_scale,
                "agreement": evidence.agreement,
                "repeats": evidence.repeats,
                "standing": standing or UNSET,
                "assumed": None,
            }
        pairs, (raw, scaled) = source.pairs, solved.condition_numbers() if solved else (None, None)
        apart = max(pairs, key=lambda pair: pair.max_mismatch, default=None)
        entries = (self.mass, ends[0], spread.mass), (self.com, ends[1:], spread.com), inertia or (None,) * 3
        rows = zip(("mass", "centre_of_mass", "inertia"), uses, entries, strict=True)
        return PayloadResult(
            robot=robot.name,
            robot_title=robot.title or UNSET,
            frame=robot.payload_frame,
            flange_in_payload_frame=documents.FlangeDocument.of(flange, source=said) if flange else UNSET,
            rated_payload_kg=robot.rated_payload,
            processing=ProcessingDocument.made(robot, source.processing, source.loaded[0].gains),
            estimates=tuple(estimates),
            recommended=documents.Recommended(method, "constrained" if self.constrained else "wls", reason),
            gain_sigma=UNSET if self.gains is None else self.gains,
            mass_by_joints=evidence.by_joints.masses,
            joint_that_agrees_least=worst_joint(evidence.by_joints, self.mass),
            quantities={name: documents.Quantity(use, why or None, *entry) for name, (use, why), entry in rows},
            verdict=self.verdict,
            scale=(scale.mass, scale.sigma) if scale is not None else UNSET,
            relative_residual=residual,
            data=documents.PayloadData.of(
                source,
                source.processing,
                lag_s=pairs[0].lag if pairs else None,
                lags_s=tuple(pair.lag for pair in pairs),
                max_position_mismatch_rad=apart.max_mismatch if apart else None,
                rms_position_mismatch_rad=apart.rms_mismatch if apart else None,
                condition_number=raw,
                condition_number_scaled=scaled,
                **counted,
            ),
            **keys,
        ).made_by(self)

    @property
    def recommended(self) -> ConstrainedPayload:
        """Possible estimate of the method to use, where all ten are determined."""
        assert self.possible is not None
        return self.possible

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return float(self.ten[9])

    @property
    def com(self) -> Array:
        """Centre of mass [m], nan where not determined, shape (3,)."""
        return np.asarray(self.ten[6:9] / self.ten[9])

    @cached_property
    def elimination(self) -> Elimination | None:
        """Essential parameters of robot and payload together, where method 4 was used."""
        problem = self.problem
        if not isinstance(problem, LongMotion) or all(payload.method != 4 for payload in self.constrained):
            return None
        return eliminate(problem.both, weighted(problem.both), problem.settings.essential)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Reasons against a robot or payload with the eliminated parameters zero."""
        problem, elimination = self.problem, self.elimination
        if not isinstance(problem, LongMotion) or elimination is None:
            return ()
        full, _ = methods.with_robust(problem, methods.selected(problem, problem.loaded.columns))
        part, names = elimination.estimate, elimination.essential
        part, _ = methods.with_robust(problem, methods.selected(problem, names), part)
        elimination = replace(elimination, estimate=part)
        of_robot = identification.impossible_robot(problem.robot, problem.base, full, elimination)
        return identification.impossible_payload(elimination) + of_robot

    @cached_property
    def excitation(self) -> Excitation | None:
        """Excitation of robot and payload together (30); None without the robot's own equations."""
        if not isinstance(self.problem, LongMotion) or self.problem.unloaded is None:
            return None
        return excitation(self.problem.both, weighted(self.problem.both))

    @cached_property
    def predictions(self) -> tuple[TorquePrediction, ...]:
        """Torques of a few held-out recordings without payload, then of loaded ones; none of an unknown robot."""
        problem, own = self.problem, self.problem.robot_estimate
        if own is None:
            return ()
        observer, curves = Observer(problem.robot, problem.base.columns), {"predicted": own.values}
        held_out = identification.predictions(observer, curves, self.held_out, problem.source.processing, True)
        return held_out + identification.payload_predictions(problem, self.recommended.body)


@one_thread()
def identify_payload(
    robot: Robot,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording] = (),
    known: RobotResult | Estimate | None = None,
    constraints: Sequence[Constraint] = POSSIBLE,
    settings: Settings = DEFAULTS,
) -> PayloadResult:
    """Identify a payload from motions of every joint, by the paper's four methods (22) to (30), and judge it.

    Args:
        loaded: recordings with the payload.
        unloaded: recordings without; the k-th of the same trajectory as the k-th of ``loaded`` for method 3.
        known: the robot's parameters from an earlier identification, instead of ``unloaded`` or beside them: its
            result, or the estimate of the same robot's base parameters.
        constraints: what is known of the payload; that it can exist is always demanded.

    Raises:
        InputError: if the recordings cannot be used, or show no payload.
        SolverError: if no body that holds the constraints comes near the data.

    >>> result = identify_payload(robot, loaded, unloaded)
    >>> f"{result.mass.value:.1f} kg"
    '7.0 kg'
    """
    robot, stored = _described(robot, known, loaded, unloaded)
    problem = payload_problem(robot, loaded, unloaded, stored, settings)
    return answer_payload(problem, constraints=constraints).result


@one_thread()
def weigh(
    robot: Robot,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording] = (),
    known: RobotResult | Estimate | None = None,
    constraints: Sequence[Constraint] = POSSIBLE,
    settings: Settings = DEFAULTS,
) -> PayloadResult:
    """Identify what a short motion near one pose shows of a payload, and judge each quantity.

    Torque differences answer where there are recordings without payload; the robot's parameters, where they are
    known too, are compared with them. Other arguments as of ``identify_payload``.

    Args:
        unloaded: recordings without payload; one for all, or one for each of ``loaded`` in the same order.

    Raises:
        InputError: if the recordings cannot be used, or nothing shows the mass.
        SolverError: if no body that holds the constraints comes near the data.

    >>> f"{weigh(robot, loaded, unloaded).mass.value:.0f} kg"
    '7 kg'
    """
    problems, (robot, stored) = [], _described(robot, known, loaded, unloaded)
    if unloaded:
        problems.append(difference_weighing(robot, loaded, unloaded, settings))
    if stored is not None:
        problems.append(known_robot_weighing(robot, loaded, stored, settings))
    if not problems:
        raise InputError(
            "give recordings without payload or the robot's parameters: without either nothing can be compared"
        )
    first, *others = problems
    return answer_payload(first, constraints=constraints, others=others).result


@one_thread()
def weigh_at_rest(
    robot: Robot,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording],
    constraints: Sequence[Constraint] = POSSIBLE,
    settings: Settings = DEFAULTS,
) -> PayloadResult:
    """Identify mass and centre of mass from poses held still, each reached from both sides; else as ``weigh``.

    >>> f"{weigh_at_rest(robot, loaded_at_rest, unloaded_at_rest).mass.value:.0f} kg"
    '6 kg'
    """
    from ..payload.static import static_weighing

    check_given(robot, loaded, unloaded)
    problem = static_weighing(robot, loaded, unloaded, settings)
    return answer_payload(problem, constraints=constraints).result


def _described(robot: Robot, known: RobotResult | Estimate | None, *logs: object) -> tuple[Robot, Estimate | None]:
    """Describe the robot as an earlier identification of it did, and take its parameters; refuse what is no log."""
    check_given(robot, *logs)
    if known is None or isinstance(known, Estimate):
        return robot, known
    from ..results.robot import RobotResult

    if not isinstance(known, RobotResult):
        raise InputError(f"known: give the result or the estimate of an identification, not {type(known).__name__}")
    return known.applied_to(robot), known.estimate


@one_thread()
def answer_payload(
    problem: methods.PayloadProblem,
    held_out: Sequence[Recording] = (),
    constraints: Sequence[Constraint] = POSSIBLE,
    others: Sequence[ShortMotion] = (),
) -> PayloadAnswer:
    """Estimate by the methods of the problem's settings, and judge the result.

    Args:
        held_out: recordings without payload to validate the robot's parameters on.
        constraints: what is known of the payload; that it can exist is always demanded.
        others: the same payload by a short motion reduced in another way, for comparison.

    Raises:
        InputError: if a method that was asked for cannot be used, or none can; "mass not visible" where neither
            torques nor a scale show the mass.
        SolverError: if by no method a payload was found that holds the constraints; what speaks against the
            recordings is named with it.

    >>> answer_payload(payload_problem(robot, loaded, unloaded)).recommended.method
    3
    """
    source = problem.source
    problem.settings.progress("estimating")
    gains = problem.settings.gains or usual_gains(problem.robot, (*source.unloaded, *source.loaded))
    scale = next((known for known in constraints if isinstance(known, KnownMass)), None)
    if isinstance(problem, ShortMotion):
        problem, others = replace(problem, scale=scale), [replace(other, scale=scale) for other in others]
    free, left_out = _identified(problem)
    if (repeats := repeats_of(problem)) is not None:  # the scatter of repeated recordings beyond their own
        free = [moved(estimate, factor=repeats.excess) for estimate in free]
    # Errors that are assumed, not known, excuse no joint that disagrees.
    stated = None if gains is not None and gains.assumed else gains
    # Weights are those of all recordings, not of differences; method 2 has no own ones.
    by_all = min(free, key=lambda estimate: (4, 3, 1, 2).index(estimate.method))
    evidence = diagnose(problem, by_all, stated)
    free = [allowing(estimate, evidence, stated) for estimate in free]
    own, validation = problem.robot_estimate, None
    if own is not None and held_out:
        validation = identification.held_out_fit(problem.robot, own, held_out, problem.settings)
    constrained, failures = list[ConstrainedPayload](), dict[int, SolverError]()
    for estimate in free:
        hard = [known for known in constraints if not (isinstance(known, KnownMass) and estimate.from_scale)]
        try:
            if len(estimate.indices) == len(PAYLOAD):
                constrained.append(constrain_payload(estimate, hard, gains))
        except SolverError as error:
            failures[estimate.method] = error
    # Where no method found a possible payload, all are shown.
    shown = [estimate for estimate in free if estimate.method not in failures] or free
    found = [payload.method for payload in constrained or shown]
    recommendation = method, _ = methods.recommended_method(problem, found)
    best = next(estimate for estimate in shown if estimate.method == method)
    possible = next((payload for payload in constrained if payload.method == method), None)
    model = error_model(best.estimate, gains)
    values, C = model.values, model.covariance
    if scale is not None and not best.from_scale:
        # The scale is one more measurement, of x[k] alone: Kalman's update. It counts once.
        k = best.indices.index(9)
        gain = C[:, k] / (C[k, k] + scale.sigma**2)
        values, C = values + gain * (scale.mass - values[k]), C - np.outer(gain, C[k])
    ten = np.full(10, np.nan)
    ten[list(best.indices)] = values if possible is None else possible.body.vector
    spread = payload_spread(ten, C, best.indices)
    if possible is not None:
        intervals = np.vstack([possible.intervals.parameters[9], possible.intervals.com])
    else:
        half_widths = student95(model.degrees_of_freedom) * np.append(spread.mass, spread.com)
        half_widths[~np.isfinite(half_widths)] = np.nan
        intervals = np.append(ten[9], ten[6:9] / ten[9])[:, None] + np.outer(half_widths, [-1.0, 1.0])
    # Other ways: with friction as it is without payload, where that is determined, and by ``others``.
    labels = {1: "robot's parameters (method 1)", 3: "torque difference (method 3)"}
    ways = [(labels[other.method], methods.payload_estimate(other, other.method).ten) for other in others]
    if isinstance(problem, ShortMotion) and problem.method == 3 and problem.visibility.rank == len(PAYLOAD):
        with suppress(InputError):
            runs = (in_payload_frame(problem.robot, run).select(PAYLOAD) for run in problem.runs)
            ways.insert(0, (UNFREED, weighted(merged(runs)).values))
    # Half the reported 95 % intervals over 1.96; constraints may make the mass's shorter.
    wider, half = few_blocks(model.degrees_of_freedom), 0.5 * np.ptp(intervals[0]) / NORMAL95
    mass = float(np.fmin(wider * spread.mass, half))
    reported = PayloadSpread(mass, wider * spread.com, wider * spread.inertia_com)
    moments = np.diag(possible.body.inertia_com) if possible is not None else np.full(3, np.nan)
    at_rest, still = (problem, {"inertia": STILL}) if isinstance(problem, StaticMotion) else (None, {})
    more: dict[str, Any]
    if isinstance(problem, ShortMotion):
        sigma = float(model.sigma[model.names.index("M_L")])
        more = {"weighed": Weighed(model["M_L"], sigma, best.from_scale)}
        more["unexplained"] = best.unexplained(problem.torque_rms)
    else:  # judged by all methods, those without a possible payload among them
        condition = problem.unloaded.condition_numbers()[1] if problem.unloaded else None
        more = {"pairs": source.pairs, "condition": condition, "estimates": tuple(free), "recommended": possible}
    evidence = replace(
        evidence,
        source=None if at_rest else source,
        at_rest=at_rest,
        parameters=own,
        validation=validation,
        constrained=tuple(constrained),
        spread=reported,
        judged=judged(ten, moments, reported, best.from_scale) | still,
        agreement=tuple(Agreement(name, float(ten[9]), ten[6:9] / ten[9]) for name, ten in ways),
        repeats=repeats,
        **more,
    )
    verdict = judge(evidence)
    if failures and not constrained:
        failure = next(failures[estimate.method] for estimate in free if estimate.method in failures)
        against = verdict.reasons if verdict.level == "do_not_use" else ()
        raise SolverError(failure.status, [*failure.demands, *against])
    return PayloadAnswer(
        problem=problem,
        estimates=tuple(shown),
        constrained=tuple(constrained),
        left_out=left_out | {failed: str(error) for failed, error in failures.items()},
        recommendation=recommendation,
        free=best,
        possible=possible,
        model=model,
        ten=ten,
        spread=spread,
        intervals=intervals,
        scale=scale,
        gains=gains,
        held_out=tuple(held_out),
        evidence=evidence,
        verdict=verdict,
    )


def _identified(problem: methods.PayloadProblem) -> tuple[list[PayloadEstimate], dict[int, str]]:
    """Estimate by each method, those asked for or all that can be used, and say why there is none of a method."""
    if asked := problem.settings.methods:
        return [methods.payload_estimate(problem, int(method)) for method in asked], {}
    estimates, left_out = list[PayloadEstimate](), dict[int, str]()
    for method in (usable := methods.usable_methods(problem)):
        try:
            estimates.append(methods.payload_estimate(problem, method))
        except InputError as error:
            left_out[method] = str(error)
    if isinstance(problem, LongMotion) and 3 not in usable:
        left_out[3] = problem.why_no_pair
    if not estimates:
        raise InputError(next(iter(left_out.values()), "no recordings without payload and no robot parameters"))
    return estimates, left_out
