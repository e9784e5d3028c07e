"""The answer to "what is this robot": its base parameters, from recordings without payload."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from ...common.errors import InputError
from ...common.progress import Progress, silent
from ...common.speech import Speaks
from ...model import BaseParameters, Processing, Recording, Robot, base_parameters
from ..diagnosis.finding import Verdict
from ..diagnosis.verdict import robot_verdict
from ..equations.equations import Equations
from ..fit.drive_gains import Gains
from ..fit.essential import Elimination, StopRule, eliminate
from ..fit.estimate import Estimate, Fit, fit
from ..fit.least_squares import Excitation, excitation, weighted
from ..fit.linear_problem import LinearProblem, gain_sensitivity
from ..fit.own_equations import base_problem
from ..fit.robust import RobustCovariance, jackknifed, naming_blocks
from ..payload.problem import Source
from .elimination import impossible_robot
from .prediction import DRAWN, TorquePrediction, robot_prediction


@dataclass(frozen=True, repr=False)
class Identification(Speaks):
    """The robot's base parameters as estimated.

    Attributes:
        base: which parameters, and how the standard ones are grouped in them.
        estimate: values in the order of ``base.columns``, with covariance.
        elimination: essential parameters, and how they were found.
        validation: fit on recordings that were not used, if there were any.
        without_robust: why there are no robust standard deviations although they were asked for.
        gains: uncertainty of the drive gains; None where they are taken as exact.
        recordings: what was fitted.
        unseen: equations of recordings that were not used.
    """

    robot: Robot
    base: BaseParameters
    problem: Equations
    estimate: Estimate
    elimination: Elimination
    validation: Fit | None
    without_robust: str = ""
    gains: Gains | None = None
    recordings: tuple[Recording, ...] = ()
    held_out: tuple[Recording, ...] = ()
    processing: Processing | None = None
    unseen: Equations | None = None

    @property
    def headline(self) -> str:
        """The robot, its parameters and what they leave unexplained, in a line."""
        count, relative = len(self.base.columns), 100.0 * self.estimate.fit.relative
        return f"{self.robot.name}, {count} base parameters, {relative:.2f} % of the torque unexplained"

    @property
    def essential(self) -> tuple[str, ...]:
        """Columns that remain after elimination."""
        return self.elimination.essential

    @cached_property
    def verdict(self) -> Verdict:
        """Whether the parameters may be used, and why not."""
        source = Source((), self.recordings, self.processing or self.robot.processing)
        return robot_verdict(self.robot, source, self.problem, self.estimate)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """What speaks against a robot whose eliminated parameters are zero."""
        return impossible_robot(self.robot, self.base, self.estimate, self.elimination)

    @cached_property
    def excitation(self) -> Excitation:
        """How well the recordings excite each parameter."""
        return excitation(self.problem, self.estimate)

    @cached_property
    def predictions(self) -> tuple[TorquePrediction, ...]:
        """Torques as the parameters predict them: of what was held out, else of what was fitted; a few."""
        chosen = (self.held_out or self.recordings)[:DRAWN]
        settings, held_out = self.processing or self.robot.processing, bool(self.held_out)
        values = self.estimate.values
        return tuple(
            robot_prediction(self.robot, self.base, values, recording, settings, held_out) for recording in chosen
        )


def identify(
    robot: Robot,
    recordings: Sequence[Recording],
    processing: Processing | None = None,
    validation: Sequence[Recording] = (),
    progress: Progress = silent,
    robust: bool = True,
    essential: StopRule | None = None,
    gains: Gains | None = None,
) -> Identification:
    """Identify a robot's base parameters by weighted least squares.

    Args:
        recordings: without payload.
        processing: settings; the robot's own by default.
        validation: recordings on which the result is tried.
        robust: add standard deviations that hold for autocorrelated residuals, of all and of the essential
            parameters; where the recordings do not allow them, the result tells why.
        essential: when elimination ends; the paper's ratio of 1.02 by default.
        gains: uncertainty of the drive gains, which no residual shows; taken as exact by default.

    Raises:
        InputError: if the recordings cannot determine the parameters.
    """
    processing = processing or robot.processing
    progress("base parameters")
    base = base_parameters(robot)
    problem = base_problem(robot, base, recordings, processing, progress=progress, blocks=robust)
    result = identified(robot, base, problem, essential, gains, robust, progress)
    unseen = None
    if validation:
        unseen = base_problem(robot, base, validation, processing, check=False, progress=progress)
    return replace(
        result,
        validation=fit(unseen, result.estimate.values) if unseen is not None else None,
        recordings=tuple(recordings),
        held_out=tuple(validation),
        processing=processing,
        unseen=unseen,
    )


def identified(
    robot: Robot,
    base: BaseParameters,
    problem: Equations,
    essential: StopRule | None = None,
    gains: Gains | None = None,
    robust: bool = True,
    progress: Progress = silent,
) -> Identification:
    """Identify from equations that are reduced already, in blocks of time where ``robust``; else as there."""
    estimate = _with_gains(problem, weighted(problem), gains)
    elimination, reason = eliminate(problem, estimate, essential), ""
    part = _with_gains(problem.select(elimination.essential), elimination.estimate, gains)
    if robust:
        progress("leaving out blocks")
        try:
            estimate, part = _with_robust(problem, [estimate, part])
        except InputError as error:
            reason = str(error)
    return Identification(robot, base, problem, estimate, replace(elimination, estimate=part), None, reason, gains)


def _with_gains(problem: Equations, estimate: Estimate, gains: Gains | None) -> Estimate:
    """An estimate with its derivatives by each motor's torque, and how sure these torques are."""
    return replace(
        estimate,
        gain_sensitivity=gain_sensitivity(problem, estimate.weights),
        gain_covariance=gains.covariance(len(problem.factors)) if gains is not None else None,
    )


def _with_robust(problem: Equations, estimates: Sequence[Estimate]) -> list[Estimate]:
    """Weighted estimates of all or some of the parameters with their robust covariance, weights fixed.

    Raises:
        InputError: if the data without one block do not determine the parameters.
    """
    pairs = [(b, -1) for b in range(len(problem.without_blocks()))]

    def robust(estimate: Estimate) -> RobustCovariance:
        part = LinearProblem(problem.select(estimate.names), estimate.names)
        with naming_blocks(problem.block_length):
            values = part.without_blocks(estimate.weights, pairs)
        return jackknifed([values], estimate.values, problem.block_length)

    return [replace(estimate, robust=robust(estimate)) for estimate in estimates]
