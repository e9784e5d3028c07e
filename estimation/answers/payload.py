"""The whole answer to "what hangs on the flange": every method that can be used, and what to think of it."""

from collections.abc import Sequence
from dataclasses import dataclass

from ...common.errors import InputError
from ...model import Processing, Recording
from ..diagnosis.evidence import Evidence
from ..diagnosis.finding import Verdict
from ..diagnosis.verdict import judge
from ..equations.problem import ReducedProblem
from ..fit.drive_gains import GainErrors
from ..fit.essential import Elimination, StopRule
from ..fit.estimate import Fit, fit
from ..fit.least_squares import weighted
from ..payload.by_joints import ByJoints, payload_by_joints
from ..payload.constrained import ConstrainedPayload, constrain_payload
from ..payload.global_fit import essential_combined
from ..payload.methods import METHODS, identify_payload, usable_methods
from ..payload.over_time import payload_over_time
from ..payload.problem import FixedWeights, PayloadProblem
from ..payload.result import PayloadEstimate
from ..possible.cone import SolverError
from ..possible.constraints import Constraint
from ..possible.scaling import POSSIBLE
from ..robot.identification import base_problem


@dataclass(frozen=True)
class PayloadAnswer:
    """Payload estimates with what is needed to judge them.

    Attributes:
        problem: the reduced recordings.
        estimates: one per method, in the order of the methods; methods for which no possible payload was found are
            left out.
        constrained: for each of ``estimates`` the nearest payload that holds the constraints, with intervals.
        left_out: method -> why it gave no estimate.
        robot_fit: fit of the robot's own parameters without payload.
        validation: fit of the same parameters on recordings that were held out.
        by_joints: the payload as single joints see it.
        verdict: whether the numbers may be used.
        elimination: essential parameters of robot and payload together, where method 4 was used.
    """

    problem: PayloadProblem
    estimates: tuple[PayloadEstimate, ...]
    constrained: tuple[ConstrainedPayload, ...]
    left_out: dict[int, str]
    robot_fit: Fit | None
    validation: Fit | None
    by_joints: ByJoints
    verdict: Verdict
    elimination: Elimination | None = None

    @property
    def recommended(self) -> ConstrainedPayload:
        """The one to use: of method 4, which uses every equation, else of method 3, 1, 2, whichever is there first.

        The order is fixed: to choose the shortest interval would choose too short ones.
        """
        return recommended(self.constrained)


def recommended(constrained: Sequence[ConstrainedPayload]) -> ConstrainedPayload:
    """As ``PayloadAnswer.recommended``."""
    return min(constrained, key=lambda payload: (4, 3, 1, 2).index(payload.method))


def answer_payload(
    problem: PayloadProblem,
    methods: Sequence[int] | None = None,
    free_friction: bool = False,
    held_out: Sequence[Recording] = (),
    processing: Processing | None = None,
    constraints: Sequence[Constraint] = POSSIBLE,
    gains: GainErrors | None = None,
    essential: StopRule | None = None,
) -> PayloadAnswer:
    """Estimate by several methods and judge the result.

    Args:
        problem: the reduced recordings.
        methods: which ones; None takes all that can be used and tells why the others cannot.
        free_friction: method 1: estimate friction anew under load.
        held_out: recordings without payload to validate the robot's parameters on.
        processing: settings for those; the robot's own by default.
        constraints: what is known of the payload; that it can exist is always demanded.
        gains: uncertainty of the drive gains; taken as exact by default.
        essential: method 4: when elimination ends; the paper's ratio of 1.02 by default.

    Raises:
        InputError: if a method that was asked for cannot be used, or none can.
        SolverError: if by no method a payload was found that holds the constraints; what speaks against the
            recordings is told with it.
    """
    free, left_out = _identified(problem, methods, free_friction)
    constrained: list[ConstrainedPayload] = []
    failures: list[SolverError] = []
    for estimate in free:
        try:
            constrained.append(constrain_payload(problem, estimate, constraints, gains, free_friction))
        except SolverError as error:
            failures.append(error)
            left_out[estimate.method] = str(error)
    evidence = _evidence(problem, free, constrained, _validation(problem, held_out, processing))
    verdict = judge(evidence)
    if not constrained:
        against = verdict.reasons if verdict.level == "do_not_use" else ()
        raise failures[0].naming(*failures[0].demands, *against)
    return PayloadAnswer(
        problem=problem,
        estimates=tuple(payload.free for payload in constrained),
        constrained=tuple(constrained),
        left_out=left_out,
        robot_fit=evidence.robot_fit,
        validation=evidence.validation,
        by_joints=evidence.by_joints,
        verdict=verdict,
        elimination=essential_combined(problem, essential) if any(one.method == 4 for one in constrained) else None,
    )


def _identified(
    problem: PayloadProblem, methods: Sequence[int] | None, free_friction: bool
) -> tuple[list[PayloadEstimate], dict[int, str]]:
    """The methods' own estimates, and why there is none of a method."""
    estimates: list[PayloadEstimate] = []
    left_out: dict[int, str] = {}
    usable = usable_methods(problem)
    for method in methods or METHODS:
        if methods is None and method not in usable:
            if method == 3:
                left_out[method] = problem.without_difference
            continue
        try:
            estimates.append(identify_payload(problem, method, free_friction))
        except InputError as error:
            if methods is not None:
                raise
            left_out[method] = str(error)
    if not estimates:
        raise InputError(next(iter(left_out.values()), "no recordings without payload and no robot parameters"))
    return estimates, left_out


def _validation(
    problem: PayloadProblem, held_out: Sequence[Recording], processing: Processing | None
) -> ReducedProblem | None:
    if not held_out:
        return None
    settings = processing or problem.robot.processing
    return base_problem(problem.robot, problem.base, held_out, settings, check=False)


def _evidence(
    problem: PayloadProblem,
    free: Sequence[PayloadEstimate],
    constrained: Sequence[ConstrainedPayload],
    validation: ReducedProblem | None,
) -> Evidence:
    """What the verdict looks at."""
    bare = weighted(problem.unloaded) if problem.unloaded else None
    alone = bare or problem.known
    best = recommended(constrained) if constrained else None
    weights = FixedWeights(bare.weights if bare else None, (best.free if best else free[-1]).estimate.weights)
    return Evidence(
        robot=problem.robot,
        source=problem.source,
        pairs=problem.pairs,
        condition=problem.unloaded.condition_numbers()[1] if problem.unloaded else None,
        parameters=alone,
        validation=fit(validation, alone.values) if validation and alone else None,
        estimates=tuple(free),
        constrained=tuple(constrained),
        recommended=best,
        by_joints=payload_by_joints(problem, weights),
        stretches=payload_over_time(problem, weights),
    )
