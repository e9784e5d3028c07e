"""Answers on a payload: every method that can be used, judged."""

from collections.abc import Sequence
from dataclasses import replace

from ...common.errors import InputError
from ...model import Recording, Robot
from ..diagnosis.evidence import Agreement, Diagnosis, Evidence, Weighed
from ..diagnosis.finding import Verdict
from ..diagnosis.verdict import allowing as allowing_for
from ..diagnosis.verdict import by_all_recordings, diagnose, judge
from ..equations.equations import PAYLOAD, merged
from ..fit.drive_gains import Gains, usual_gains
from ..fit.estimate import Estimate, fit
from ..fit.least_squares import weighted
from ..fit.own_equations import base_problem
from ..fit.settings import DEFAULTS, Settings
from ..payload.long_motion import LongMotion
from ..payload.methods import METHODS, PayloadProblem, payload_estimate, usable_methods
from ..payload.problem import payload_problem
from ..payload.repeats import repeats_of
from ..payload.result import ConstrainedPayload, PayloadEstimate, constrain_payload, in_payload_frame, widened
from ..payload.short_motion import ShortMotion
from ..payload.weighing import difference_weighing, known_robot_weighing
from ..possible.cone import SolverError
from ..possible.constraints import Constraint, KnownMass
from ..possible.payload import POSSIBLE
from ..results.payload import PayloadResult
from ..results.robot import RobotResult
from .payload_answer import PayloadAnswer


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
    """
    check_lists(loaded, unloaded)
    robot, stored = _described(robot, known)
    problem = payload_problem(robot, loaded, unloaded, stored, settings)
    return answer_payload(problem, constraints=constraints).result


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
    """
    check_lists(loaded, unloaded)
    problems, (robot, stored) = [], _described(robot, known)
    if unloaded:
        problems.append(difference_weighing(robot, loaded, unloaded, settings))
    if stored is not None:
        problems.append(known_robot_weighing(robot, loaded, stored, settings))
    if not problems:
        raise InputError(
            "give recordings without payload or the robot's parameters: without either nothing can be compared"
        )
    settings.progress("estimating")
    first, *others = problems
    return answer_payload(first, constraints=constraints, gains=settings.gains, others=others).result


def answer_payload(
    problem: PayloadProblem,
    methods: Sequence[int] | None = None,
    held_out: Sequence[Recording] = (),
    constraints: Sequence[Constraint] = POSSIBLE,
    gains: Gains | None = None,
    others: Sequence[ShortMotion] = (),
) -> PayloadAnswer:
    """Estimate by several methods and judge the result.

    Args:
        methods: which ones; those of the problem's settings by default, else all that can be used, and why the
            others cannot.
        held_out: recordings without payload to validate the robot's parameters on.
        constraints: what is known of the payload, a weighed mass among it; that it can exist is always demanded.
        gains: uncertainty of the drive gains; that of the problem's settings by default, else what the recordings
            say of it, else the usual one.
        others: the same payload by a short motion reduced in another way, for comparison.

    Raises:
        InputError: if a method that was asked for cannot be used, or none can; "mass not visible" where neither
            torques nor a scale show the mass.
        SolverError: if by no method a payload was found that holds the constraints; what speaks against the
            recordings is named with it.
    """
    if isinstance(problem, LongMotion):
        methods = problem.settings.methods if methods is None else methods
        gains = problem.settings.gains if gains is None else gains
    scale = next((known for known in constraints if isinstance(known, KnownMass)), None)
    free, left_out = _identified(problem, methods, scale)
    repeats = repeats_of(problem, scale)
    if repeats is not None:  # the scatter of repeated recordings beyond their own
        free = [widened(estimate, repeats.excess) for estimate in free]
    if gains is None:
        gains = usual_gains(problem.robot, (*problem.source.unloaded, *problem.source.loaded))
    # Errors that are assumed, not known, excuse no joint that disagrees: they never shorten an interval.
    diagnosis = diagnose(problem, by_all_recordings(free), None if gains is not None and gains.assumed else gains)
    free = [allowing_for(estimate, diagnosis) for estimate in free]
    validation = None
    if held_out and problem.robot_estimate is not None:
        settings = Settings(problem.source.processing, robust=False)
        unseen = base_problem(problem.robot, problem.base, held_out, settings, False, problem.robot_estimate.values)
        validation = fit(unseen, problem.robot_estimate.values)
    constrained: list[ConstrainedPayload] = []
    failures: dict[int, SolverError] = {}
    for estimate in free:
        hard = [known for known in constraints if not (isinstance(known, KnownMass) and estimate.from_scale)]
        try:
            if estimate.complete:
                constrained.append(constrain_payload(estimate, hard, gains))
        except SolverError as error:
            failures[estimate.method] = error
    agreement = _without_friction(problem)
    for other in others:
        ten = payload_estimate(other, other.method, scale=scale).ten
        name = "robot's parameters (method 1)" if other.method == 1 else "torque difference (method 3)"
        agreement.append(Agreement(name, float(ten[9]), ten[6:9] / ten[9]))
    answer = PayloadAnswer(
        problem=problem,
        # Where no method found a possible payload, all are shown.
        estimates=tuple(estimate for estimate in free if estimate.method not in failures) or tuple(free),
        constrained=tuple(constrained),
        left_out=left_out | {method: str(error) for method, error in failures.items()},
        by_joints=diagnosis.by_joints,
        verdict=Verdict("use"),  # until what speaks against it is known
        scale=scale,
        gains=gains,
        validation=validation,
        held_out=tuple(held_out),
        agreement=tuple(agreement),
        repeats=repeats,
    )
    verdict = judge(_evidence(answer, free, diagnosis))
    if failures and not constrained:
        failure = next(failures[estimate.method] for estimate in free if estimate.method in failures)
        raise failure.naming(*failure.demands, *(verdict.reasons if verdict.level == "do_not_use" else ()))
    return replace(answer, verdict=verdict)


def _identified(
    problem: PayloadProblem, methods: Sequence[int] | None, scale: KnownMass | None
) -> tuple[list[PayloadEstimate], dict[int, str]]:
    """Estimate by each method, and say why there is none of a method."""
    estimates: list[PayloadEstimate] = []
    left_out: dict[int, str] = {}
    usable = usable_methods(problem)
    for method in methods or METHODS:
        if methods is None and method not in usable:
            if method == 3 and isinstance(problem, LongMotion):
                left_out[method] = problem.why_no_pair
            continue
        try:
            estimates.append(payload_estimate(problem, method, scale))
        except InputError as error:
            if methods is not None:
                raise
            left_out[method] = str(error)
    if not estimates:
        raise InputError(next(iter(left_out.values()), "no recordings without payload and no robot parameters"))
    return estimates, left_out


def _evidence(answer: PayloadAnswer, free: Sequence[PayloadEstimate], diagnosis: Diagnosis) -> Evidence:
    """Collect evidence for the verdict; ``free``: by all methods, those without a possible payload among them."""
    problem = answer.problem
    evidence = Evidence(
        problem.robot,
        source=problem.source,
        diagnosis=diagnosis,
        compared=problem.source.compared,
        constrained=answer.constrained,
        spread=answer.reported_spread,
        judged=answer.measured,
    )
    if isinstance(problem, ShortMotion):
        weighed = Weighed(
            mass=answer.model["M_L"],
            sigma=float(answer.model.sigma[answer.model.names.index("M_L")]),
            from_scale=answer.free.from_scale,
            unexplained=answer.free.unexplained(problem.torque_rms),
            repeats=answer.repeats,
            agreement=answer.agreement,
        )
        return replace(evidence, parameters=problem.known, weighed=weighed)
    return replace(
        evidence,
        pairs=problem.pairs,
        condition=problem.unloaded.condition_numbers()[1] if problem.unloaded else None,
        parameters=problem.robot_estimate,
        validation=answer.validation,
        estimates=tuple(free),
        recommended=answer.possible,
    )


def _without_friction(problem: PayloadProblem) -> list[Agreement]:
    """Extend a short motion by its friction without payload; left out where that is not determined."""
    if not isinstance(problem, ShortMotion) or problem.method != 3:
        return []
    if not problem.visibility.mass_visible or problem.visibility.rank < 10:
        return []
    frictional = merged(in_payload_frame(problem.robot, run.frictional) for run in problem.runs).select(PAYLOAD)
    try:
        values = weighted(frictional).values
    except InputError:
        return []
    return [Agreement("friction not freed", float(values[9]), values[6:9] / values[9], counts=False)]


def check_lists(*groups: Sequence[Recording]) -> None:
    """Refuse a recording where a list of them is meant."""
    if any(isinstance(group, Recording) for group in groups):
        raise InputError("a single recording: give a list of recordings, [recording]")


def _described(robot: Robot, known: RobotResult | Estimate | None) -> tuple[Robot, Estimate | None]:
    """Describe the robot as an earlier identification did, which must be of this one, and take its parameters."""
    if isinstance(known, RobotResult):
        return known.applied_to(robot), known.estimate
    if known is not None and not isinstance(known, Estimate):
        raise InputError(f"known: give the result or the estimate of an identification, not {type(known).__name__}")
    return robot, known
