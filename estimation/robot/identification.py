"""Identification of a robot from recordings without payload: the base parameters."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...common.errors import InputError
from ...common.linear import least_squares
from ...common.progress import Progress, silent
from ...model import BaseParameters, Processing, Recording, Robot, base_parameters
from ...model.base import leftmost_independent, random_states, stacked_regressor
from ..equations.observation import Observation, Observer
from ..equations.problem import ReducedProblem, merged
from ..equations.reduction import reduced_measurement
from ..fit.blocks import Pieces
from ..fit.drive_gains import GainErrors, gain_sensitivity
from ..fit.essential import Elimination, StopRule, eliminate
from ..fit.estimate import Estimate, Fit, fit
from ..fit.least_squares import weighted
from ..fit.robot_blocks import robot_blocks
from ..recordings.plausibility import check_recordings, still_joints
from ..signals.filtering import measurement


@dataclass(frozen=True)
class Identification:
    """The robot's base parameters as estimated.

    Attributes:
        robot: the robot's description.
        base: which parameters, and how the standard ones are grouped in them.
        problem: the reduced equations.
        estimate: values in the order of ``base.columns``, with covariance.
        elimination: essential parameters, and how they were found.
        validation: fit on recordings that were not used, if there were any.
        without_robust: why there are no robust standard deviations although they were asked for.
        gains: uncertainty of the drive gains; None where they are taken as exact.
    """

    robot: Robot
    base: BaseParameters
    problem: ReducedProblem
    estimate: Estimate
    elimination: Elimination
    validation: Fit | None
    without_robust: str = ""
    gains: GainErrors | None = None

    @property
    def essential(self) -> tuple[str, ...]:
        """Columns that remain after elimination."""
        return self.elimination.essential


def identify(
    robot: Robot,
    recordings: Sequence[Recording],
    processing: Processing | None = None,
    validation: Sequence[Recording] = (),
    progress: Progress = silent,
    robust: bool = False,
    essential: StopRule | None = None,
    gains: GainErrors | None = None,
) -> Identification:
    """Identify a robot's base parameters by weighted least squares.

    Args:
        robot: the robot.
        recordings: without payload.
        processing: settings; the robot's own by default.
        validation: recordings on which the result is tried.
        progress: told what is being worked on.
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
    problem = base_problem(robot, base, recordings, processing, progress=progress)
    estimate = weighted(problem)
    estimate = _with_gains(problem, estimate, gains)
    elimination, reason = eliminate(problem, estimate, essential), ""
    part = _with_gains(problem.select(elimination.essential), elimination.estimate, gains)
    elimination = replace(elimination, estimate=part)
    if robust:
        progress("leaving out blocks")
        try:
            blocks = robot_blocks(_pieces(robot, base, recordings, processing), estimate.values)
            estimate, part = blocks.applied_to(estimate), blocks.applied_to(elimination.estimate)
            elimination = replace(elimination, estimate=part)
        except InputError as error:
            reason = str(error)
    check = None
    if validation:
        check = fit(
            base_problem(robot, base, validation, processing, check=False, progress=progress), estimate.values
        )
    return Identification(robot, base, problem, estimate, elimination, check, reason, gains)


def _with_gains(problem: ReducedProblem, estimate: Estimate, gains: GainErrors | None) -> Estimate:
    """An estimate with what it owes to each motor's torque, and how sure that is."""
    return replace(
        estimate,
        gain_sensitivity=gain_sensitivity(problem, estimate.weights),
        gain_covariance=gains.covariance(len(problem.factors)) if gains is not None else None,
    )


def base_problem(
    robot: Robot,
    base: BaseParameters,
    recordings: Sequence[Recording],
    processing: Processing,
    check: bool = True,
    progress: Progress = silent,
) -> ReducedProblem:
    """Process recordings and reduce them to equations in the base parameters.

    Args:
        robot: the robot.
        base: its base parameters.
        recordings: recordings of one and the same load.
        processing: settings.
        check: whether every joint must move.
        progress: told what is being worked on.
    """
    check_recordings(robot, recordings)
    if check:
        check_moving(robot, base, recordings)
    check_lengths(recordings, processing)
    observer = Observer(robot, base.columns)
    problems = []
    for recording in recordings:
        progress(f"filtering {recording.source}")
        problems.append(reduced_measurement(observer, measurement(recording, processing), processing))
    problem = merged(problems)
    if problem.equations == 0:
        raise InputError(f"{recordings[0].source}: no joint moves: nothing can be compared")
    return problem


def check_lengths(recordings: Sequence[Recording], processing: Processing) -> None:
    """Refuse recordings of which decimation leaves nothing.

    Raises:
        InputError: names the recording.
    """
    for recording in recordings:
        if len(recording.t) <= processing.decimate:
            raise InputError(
                f"{recording.source}: decimation by {processing.decimate} leaves nothing of {len(recording.t)} "
                "samples: lower --decimate"
            )


def base_observations(
    robot: Robot, base: BaseParameters, recordings: Sequence[Recording], processing: Processing
) -> list[Observation]:
    """The equations of ``base_problem``, each recording's held whole."""
    observer = Observer(robot, base.columns)
    return [observer.observe(measurement(recording, processing), processing) for recording in recordings]


def _pieces(
    robot: Robot, base: BaseParameters, recordings: Sequence[Recording], processing: Processing
) -> list[Pieces]:
    """The same, to be opened piece by piece."""
    observer = Observer(robot, base.columns)
    return [observer.opener(measurement(recording, processing), processing) for recording in recordings]


def check_moving(robot: Robot, base: BaseParameters, recordings: Sequence[Recording]) -> None:
    """Refuse recordings in which some joint never moves.

    Raises:
        InputError: names the joints and the parameters that cannot be identified for it.
    """
    still = still_joints(recordings)
    if len(still) == robot.n:
        raise InputError(f"{recordings[0].source}: no joint ever moves: record a motion of every joint")
    if still:
        raise InputError(
            f"{recordings[0].source}: joint {', '.join(map(str, still))} never moves: "
            f"{', '.join(hidden_by(robot, base, still))} cannot be identified; record a motion of every joint"
        )


def hidden_by(robot: Robot, base: BaseParameters, still: Sequence[int]) -> tuple[str, ...]:
    """Base parameters that cannot be told apart or seen at all while some joints stand still."""
    q, qd, qdd = random_states(robot, 12 * robot.n, seed=0)
    for joint in still:
        q[:, joint - 1], qd[:, joint - 1], qdd[:, joint - 1] = 0.3, 0.0, 0.0
    W = stacked_regressor(robot, q, qd, qdd)[:, list(base.chosen)]
    # A joint that stands still holds any torque within its friction: its rows say nothing.
    moving = np.concatenate([np.full(len(q), j + 1 not in still) for j in range(robot.n)])
    W = W[moving]
    seen = leftmost_independent(W)
    unseen = [k for k in range(W.shape[1]) if k not in seen]
    solution = least_squares(W[:, seen], W[:, unseen])
    mixed = {seen[k] for k in np.flatnonzero((np.abs(solution) > 1e-6).any(axis=1))}
    return tuple(base.names[k] for k in sorted(mixed | set(unseen)))
