"""The whole answer to "what hangs on the flange": every method that can be used, and what to think of it."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from ...common.errors import InputError
from ...model import Processing, Recording
from ..diagnosis.evidence import Evidence
from ..diagnosis.finding import Verdict
from ..diagnosis.verdict import judge
from ..equations.equations import Equations
from ..fit.drive_gains import Gains
from ..fit.essential import Elimination, StopRule
from ..fit.estimate import Fit, fit
from ..fit.least_squares import Excitation, excitation
from ..payload.by_joints import ByJoints, payload_by_joints, payload_over_time
from ..payload.constrained import ConstrainedPayload, constrain_payload
from ..payload.methods import METHODS, combined, essential_combined, identify_payload, usable_methods
from ..payload.problem import PayloadProblem
from ..payload.result import PayloadEstimate
from ..possible.cone import SolverError
from ..possible.constraints import Constraint
from ..possible.payload import POSSIBLE
from ..robot.equations import base_problem
from .elimination import elimination_warnings
from .prediction import DRAWN, TorquePrediction, payload_prediction, robot_prediction, robot_values


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
        warnings: what speaks against a robot or payload with the eliminated parameters zero.
        held_out: recordings without payload of ``validation``.
        processing: settings of those; the robot's own by default.
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
    warnings: tuple[str, ...] = ()
    held_out: tuple[Recording, ...] = ()
    processing: Processing | None = None

    @cached_property
    def excitation(self) -> Excitation | None:
        """How well robot and payload are excited together (30); None without the robot's own equations."""
        return excitation(self.problem.both, combined(self.problem)) if self.problem.unloaded is not None else None

    @cached_property
    def predictions(self) -> tuple[TorquePrediction, ...]:
        """Torques of a few held-out recordings without payload, then of loaded ones, which were used."""
        problem, source = self.problem, self.problem.source
        settings, values = self.processing or problem.robot.processing, robot_values(problem)
        bare = [
            robot_prediction(problem.robot, problem.base, values, recording, settings, True)
            for recording in self.held_out[:DRAWN]
        ]
        return (*bare, *(self.prediction(one, False) for one in (source.loaded if source else ())[:DRAWN]))

    def prediction(self, recording: Recording, held_out: bool) -> TorquePrediction:
        """A recording with payload and what the recommended payload predicts, beside the bare robot."""
        settings = self.processing or self.problem.robot.processing
        return payload_prediction(self.problem, self.recommended.body, recording, settings, held_out)

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
    gains: Gains | None = None,
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
            constrained.append(constrain_payload(estimate, constraints, gains))
        except SolverError as error:
            failures.append(error)
            left_out[estimate.method] = str(error)
    evidence = _evidence(problem, free, constrained, _validation(problem, held_out, processing))
    verdict = judge(evidence)
    if not constrained:
        against = verdict.reasons if verdict.level == "do_not_use" else ()
        raise failures[0].naming(*failures[0].demands, *against)
    elimination = essential_combined(problem, essential) if any(one.method == 4 for one in constrained) else None
    return PayloadAnswer(
        problem=problem,
        estimates=tuple(payload.free for payload in constrained),
        constrained=tuple(constrained),
        left_out=left_out,
        robot_fit=evidence.robot_fit,
        validation=evidence.validation,
        by_joints=evidence.by_joints,
        verdict=verdict,
        elimination=elimination,
        warnings=elimination_warnings(problem, elimination) if elimination is not None else (),
        held_out=tuple(held_out),
        processing=processing,
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
) -> Equations | None:
    if not held_out:
        return None
    settings = processing or problem.robot.processing
    return base_problem(problem.robot, problem.base, held_out, settings, check=False)


def _evidence(
    problem: PayloadProblem,
    free: Sequence[PayloadEstimate],
    constrained: Sequence[ConstrainedPayload],
    validation: Equations | None,
) -> Evidence:
    """What the verdict looks at."""
    alone = problem.bare or problem.known
    best = recommended(constrained) if constrained else None
    weights = (best.free if best else free[-1]).estimate.weights
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
