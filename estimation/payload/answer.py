"""The whole answer to "what hangs on the flange": every method that can be used, and what to think of it."""

from collections.abc import Sequence
from dataclasses import dataclass

from ...model import InputError, Processing, Recording
from ..constraints import Constraint
from ..drive_gains import GainErrors
from ..essential import Elimination, StopRule
from ..estimate import Fit, fit
from ..identification import base_problem
from ..least_squares import weighted
from ..scaling import POSSIBLE
from ..verdict import Verdict, verdict
from .constrained import ConstrainedPayload, constrain_payload
from .global_fit import essential_combined
from .methods import METHODS, identify_payload, usable_methods
from .problem import PayloadProblem
from .result import PayloadEstimate


@dataclass(frozen=True)
class PayloadAnswer:
    """Payload estimates with what is needed to judge them.

    Attributes:
        problem: the reduced recordings.
        estimates: one per method, in the order of the methods.
        constrained: for each of ``estimates`` the nearest payload that holds the constraints, with intervals.
        left_out: method -> why it gave no estimate.
        robot_fit: fit of the robot's own parameters without payload.
        validation: fit of the same parameters on recordings that were held out.
        verdict: whether the numbers may be used.
        elimination: essential parameters of robot and payload together, where method 4 was used.
    """

    problem: PayloadProblem
    estimates: tuple[PayloadEstimate, ...]
    constrained: tuple[ConstrainedPayload, ...]
    left_out: dict[int, str]
    robot_fit: Fit | None
    validation: Fit | None
    verdict: Verdict
    elimination: Elimination | None = None

    @property
    def recommended(self) -> ConstrainedPayload:
        """The one to use: of method 4, which uses every equation, else of method 3, 1, 2, whichever is there first.

        The order is fixed: to choose the shortest interval would choose too short ones.
        """
        return min(self.constrained, key=lambda payload: (4, 3, 1, 2).index(payload.method))


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
        SolverError: if no payload holds the constraints.
    """
    constrained: list[ConstrainedPayload] = []
    left_out: dict[int, str] = {}
    usable = usable_methods(problem)
    for method in methods or METHODS:
        if methods is None and method not in usable:
            if method == 3:
                left_out[method] = problem.without_difference
            continue
        try:
            free = identify_payload(problem, method, free_friction)
            constrained.append(constrain_payload(problem, free, constraints, gains, free_friction))
        except InputError as error:
            if methods is not None:
                raise
            left_out[method] = str(error)
    if not constrained:
        raise InputError(next(iter(left_out.values()), "no recordings without payload and no robot parameters"))
    alone = weighted(problem.unloaded) if problem.unloaded else problem.known
    validation = None
    if held_out and alone is not None:
        settings = processing or problem.robot.processing
        check = base_problem(problem.robot, problem.base, held_out, settings, check=False)
        validation = fit(check, alone.values)
    robot_fit = alone.fit if alone else None
    estimates = tuple(payload.free for payload in constrained)
    judged = verdict(estimates, robot_fit, constrained)
    together = any(estimate.method == 4 for estimate in estimates)
    elimination = essential_combined(problem, essential) if together else None
    return PayloadAnswer(
        problem, estimates, tuple(constrained), left_out, robot_fit, validation, judged, elimination
    )
