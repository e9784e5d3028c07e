"""Base parameters of a robot from recordings without payload, and whether the essential ones can exist.

Elimination takes a small parameter as zero. That is harmless for torques, but a zero may be one that no body has:
XX = 0 says that all mass lies on the x axis, and ZZ6 = 0 while YZ6 is not that link 6 cannot exist.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import UNSET
from numpy.typing import NDArray

from ...common import Array, Brief, InputError, Speaks, one_thread
from ...common.errors import listed
from ...common.schema import naming
from ...model import BaseParameters, InertialParameters, Processing, Recording, Robot, base_parameters
from ...model.regressors import payload_columns
from ..diagnosis.evidence import Evidence, Verdict
from ..diagnosis.verdict import robot_verdict
from ..equations.equations import PAYLOAD, Equations
from ..equations.observer import Observer, used
from ..fit.covariance import weighted_solution
from ..fit.estimate import Estimate, Fit, Gains, Parameter, error_model, fit, usual_gains
from ..fit.linear_problem import Elimination, Excitation, Known, LinearProblem, eliminate, excitation, weighted
from ..fit.own_equations import TermChoice, base_problem, payload_observer, with_friction
from ..fit.settings import DEFAULTS, Settings
from ..payload.long_motion import LongMotion, Source
from ..payload.methods import PayloadProblem, from_robot, jackknifed
from ..possible.constraints import SolverError
from ..possible.payload import rise_p_value, solve_constrained
from ..possible.robot import PossibleRobot, solve_constrained_base
from ..results import parts
from ..results.payload import ObservationSystem, TorquePrediction
from ..signals.filtering import measurement
from ..signals.recordings import check_given

if TYPE_CHECKING:  # a payload's answer needs none of them
    from ..results.robot import RobotResult, Rollout

DRAWN = 3  # number of recordings of one kind that are predicted for drawings
_UNLIKELY = 0.01  # largest p-value at which the data contradict everything possible with these zeros
_FIXED = 1e-6  # standard deviation of a parameter that is fixed, as a fraction of it
_ZERO = 1e-2  # fraction of its own standard deviation within which an eliminated base parameter is kept at zero


def impossible_payload(elimination: Elimination) -> tuple[str, ...]:
    """Name what speaks against a payload with the eliminated parameters zero, a line each.

    Without XX, YY, ZZ or M no body of any thickness is left, whatever the data say. Else the nearest possible
    payload with these zeros must lie within the accuracy of the data.
    """
    gone = [name for name in elimination.eliminated if name in PAYLOAD]
    left = [name for name in elimination.essential if name in PAYLOAD]
    if not gone:
        return ()
    if not left:
        return ("no payload parameter is essential: the torques do not show the payload",)
    if "M_L" in gone:
        return (f"M_L is eliminated, {', '.join(left)} remain: a body without mass has none of them",)
    on_axis = []
    for axis in (axis for axis in "XYZ" if f"{axis}{axis}_L" in gone):
        # Of a body on that axis all products and the other first moments are zero too.
        off_axis = {"XY_L", "XZ_L", "YZ_L", "MX_L", "MY_L", "MZ_L"} - {f"M{axis}_L"}
        remaining = ", ".join(name for name in left if name in off_axis)
        line = f"{axis}{axis}_L is eliminated, which only a payload on its frame's {axis.lower()} axis has zero"
        on_axis.append(f"{line}: {remaining} must then be zero too, and remain" if remaining else line)
    if on_axis:
        return tuple(on_axis)
    try:
        result = solve_constrained(error_model(elimination.estimate).part(left))
    except SolverError as error:
        return (f"whether a payload without {', '.join(gone)} can exist is not known ({error.explanation})",)
    return _too_far("payload", gone, result.chi2_rise, result.p_value)


def impossible_robot(
    robot: Robot, base: BaseParameters, estimate: Estimate, elimination: Elimination
) -> tuple[str, ...]:
    """Name what speaks against a robot with the eliminated base parameters zero; empty if nothing does.

    The nearest robot that can exist, its eliminated base parameters zero within 1 % of their standard deviations,
    must lie within the accuracy of the data: by robust standard deviations where the estimates have them.
    ``estimate``: of all base parameters, before elimination.
    """
    gone = [name for name in elimination.eliminated if name in base.columns]
    left = [name for name in elimination.essential if name in base.columns]
    if not gone or not left:
        return ()
    # All base parameters: the essential ones as estimated, the others zero and next to certain.
    there = np.array([[name == own for own in left] for name in base.columns], dtype=float)
    zeroed = error_model(elimination.estimate).part(left).mapped(there, base.columns)
    narrow = np.where(there.any(axis=1), 0.0, _ZERO * error_model(estimate).part(base.columns).sigma)
    try:
        result = solve_constrained_base(
            robot, base, replace(zeroed, covariance=zeroed.covariance + np.diag(narrow**2))
        )
    except SolverError as error:
        return (f"whether a robot with these zeros can exist is not known ({error.explanation})",)
    p_value = rise_p_value(result.chi2_rise, len(left), zeroed.degrees_of_freedom)
    at_fault = ", ".join(holding.description for holding in result.active[:3])
    return tuple(
        f"{line}; in conflict: {at_fault}" for line in _too_far(robot.name, gone, result.chi2_rise, p_value)
    )


def _too_far(body: str, gone: Sequence[str], chi2: float, p_value: float) -> tuple[str, ...]:
    p = f"p {p_value:.1g}" if p_value >= 1e-12 else "p below 1e-12"
    zeros = ", ".join(gone) if len(gone) <= 6 else f"the {len(gone)} eliminated parameters"
    away = f"the nearest is {np.sqrt(chi2):.1f} standard deviations away ({p})"
    line = f"no {body} that can exist has {zeros} zero and the others as estimated: {away}"
    return (line,) * (p_value < _UNLIKELY)


def predictions(
    observer: Observer,
    curves: Mapping[str, Array],
    recordings: Sequence[Recording],
    processing: Processing,
    held_out: bool = False,
    loaded: bool = False,
) -> tuple[TorquePrediction, ...]:
    """Predict a few recordings by the observer's parameters of each curve."""
    found = []
    for recording in recordings[:DRAWN]:
        data, predicted = used(measurement(recording, processing), processing), dict[str, tuple[Array, ...]]()
        for label, chi in curves.items():
            one = observer.at(chi).observe(*data)
            predicted[label] = tuple(y - error for y, error in zip(one.Y, one.errors(chi), strict=True))
        found.append(TorquePrediction(recording.source, loaded, held_out, one.t, one.Y, predicted))
    return tuple(found)


def payload_predictions(problem: PayloadProblem, body: InertialParameters) -> tuple[TorquePrediction, ...]:
    """Predict a few loaded recordings of a problem by a body in the payload's frame and by the unloaded robot."""
    assert problem.robot_estimate is not None
    own, flange, source = problem.robot_estimate.values, problem.robot.flange, problem.source
    ten = body.moved(flange.R, flange.p).vector
    curves = {"predicted with payload": np.append(own, ten), "predicted without payload": np.append(own, 0.0 * ten)}
    observer = Observer(problem.robot, (*problem.base.columns, *payload_columns(problem.robot)))
    return predictions(observer, curves, source.loaded, source.processing, loaded=True)


@dataclass(frozen=True, eq=False, repr=False)
class Identification(Speaks, Brief):
    """Base parameters of a robot, estimated, and what they come from."""

    robot: Robot
    base: BaseParameters
    problem: Equations
    estimate: Estimate  # in the order of ``base.columns``
    elimination: Elimination
    processing: Processing
    without_robust: str = ""  # why there are no robust standard deviations although they were asked for
    gains: Gains | None = None  # None where they are taken as exact
    validation: Fit | None = None  # on the recordings held out, if there were any
    recordings: tuple[Recording, ...] = ()
    held_out: tuple[Recording, ...] = ()
    choices: tuple[TermChoice, ...] = ()  # terms of friction that were tried

    @cached_property
    def result(self) -> RobotResult:
        """Result that ``identify --json`` writes where nothing is said of the robot that can exist."""
        return robot_result(self, self.possible)

    @cached_property
    def possible(self) -> PossibleRobot | None:
        """The nearest robot that can exist, by a prior where the robot's file has one; None where none is found."""
        from ..possible.whole_robot import robot_prior, solve_constrained_prior

        robot, prior = (self.robot, self.base, self.estimate), None
        with suppress(InputError):  # there is none, or links of CAD that cannot exist
            prior = robot_prior(self.robot)
        with suppress(SolverError):
            return solve_constrained_prior(*robot, prior) if prior is not None else solve_constrained_base(*robot)
        return None

    def __getitem__(self, name: str) -> Parameter:
        """One base parameter by its name, "MX2R" or "MX2", as its result has it."""
        return self.result[name]

    @property
    def essential(self) -> tuple[str, ...]:
        """Columns that remain after elimination."""
        return self.elimination.essential

    @cached_property
    def verdict(self) -> Verdict:
        """Verdict on the use of the parameters."""
        found = Evidence(self.robot, Source((), self.recordings, self.processing), parameters=self.estimate)
        p_value = self.possible.p_value if self.estimate.robust and self.possible else None
        return robot_verdict(replace(found, validation=self.validation, possible=p_value))

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Reasons against a robot whose eliminated parameters are zero."""
        return impossible_robot(self.robot, self.base, self.estimate, self.elimination)

    @cached_property
    def excitation(self) -> Excitation:
        """Excitation of each parameter by the recordings."""
        return excitation(self.problem, self.estimate)

    @cached_property
    def predictions(self) -> tuple[TorquePrediction, ...]:
        """Torques that the parameters predict, of recordings held out, else of those fitted; a few."""
        observer, curves = Observer(self.robot, self.base.columns), {"predicted": self.estimate.values}
        return predictions(observer, curves, self.held_out or self.recordings, self.processing, bool(self.held_out))


@one_thread()
def identify(
    robot: Robot,
    recordings: Sequence[Recording],
    settings: Settings = DEFAULTS,
    validation: Sequence[Recording] = (),
) -> Identification:
    """Identify a robot's base parameters by weighted least squares.

    Standard deviations that hold for autocorrelated residuals are added where asked for, of all and of the
    essential parameters; where the recordings do not allow them, the result tells why.

    Args:
        recordings: without payload.
        validation: recordings on which the result is tried.

    Raises:
        InputError: if the recordings cannot determine the parameters.

    >>> result = identify(robot, unloaded)
    >>> f"{result['MX2'].value:.0f} kg m"
    '16 kg m'
    """
    check_given(robot, recordings, validation)
    settings.progress("base parameters")
    observer, choices = with_friction(robot, recordings, settings)
    robot = observer.robot
    base, problem = base_parameters(robot), base_problem(observer, recordings, settings)
    gains = settings.gains or usual_gains(robot, recordings)
    covariance = gains.covariance(len(problem.factors)) if gains is not None else None
    prior = None
    if (given := settings.prior) is not None:  # by columns, or their names in tables
        every = zip(base.columns, base.names, strict=True)
        columns = {key: column for column, label in every for key in (column, label)}
        if unknown := [name for name in given.names if name not in columns]:
            raise InputError(
                f"prior: {', '.join(unknown)} is no base parameter: give some of {', '.join(base.columns)}"
            )
        floor = _FIXED * np.maximum(np.abs(given.values), _FIXED)
        C, names = given.covariance + np.diag(floor**2), tuple(columns[name] for name in given.names)
        prior = Known(names, given.values, C, C, given.degrees_of_freedom, np.zeros((len(C), robot.n)))
    posed, reason = LinearProblem(problem, problem.columns, prior=prior), ""
    with naming(listed([one.source for one in recordings], 3)):
        estimate = replace(posed.estimate(), gain_covariance=covariance)
    elimination = eliminate(problem, estimate, settings.essential, posed.prior)
    found = [estimate, replace(elimination.estimate, gain_covariance=covariance)]
    if settings.robust:
        settings.progress("leaving out blocks")
        each = [(b, -1) for b in range(len(problem.blocks))]
        try:
            for k, one in enumerate(found):
                own = posed.part(one.names)
                robust = jackknifed(own, one, [each], problem.block_length)
                # No block shows the errors of a prior.
                C = robust.covariance + own.lasting(one.weights)
                found[k] = replace(one, robust=replace(robust, covariance=C))
        except InputError as error:
            found, reason = [estimate, found[1]], str(error)
    estimate, part = found
    return Identification(
        robot=robot,
        base=base,
        problem=problem,
        estimate=estimate,
        elimination=replace(elimination, estimate=part),
        processing=settings.processing_of(robot),
        without_robust=reason,
        gains=gains,
        validation=held_out_fit(robot, estimate, validation, settings) if validation else None,
        recordings=tuple(recordings),
        held_out=tuple(validation),
        choices=choices,
    )


def held_out_fit(robot: Robot, estimate: Estimate, recordings: Sequence[Recording], settings: Settings) -> Fit:
    """Fit of the robot's parameters to recordings without payload that were held out."""
    unseen = base_problem(
        payload_observer(robot), recordings, replace(settings, robust=False), False, estimate.values
    )
    return fit(unseen, estimate.values)


def payload_system(problem: LongMotion) -> ObservationSystem:
    """Build the system of method 4, (30): base parameters, then the payload's ten in ``robot.last_frame``.

    Rows of unloaded recordings have zeros in the payload's columns; without any it is the system of method 1, (22),
    with the robot's stored values as ``known``.
    """
    source, robot, alone = problem.source, problem.robot_estimate, problem.unloaded is None
    own = robot.values if robot is not None else np.zeros(len(problem.base.columns))
    observer = Observer(problem.robot, (*problem.base.columns, *payload_columns(problem.robot)))
    without, under_load = (observer.at(np.append(own, x * problem.carried)) for x in (0.0, 1.0))
    recordings = [(without, recording, False) for recording in source.unloaded]
    recordings += [(under_load, recording, True) for recording in source.loaded]
    weights = from_robot(problem).weights() if alone else weighted(problem.both).weights
    system = joined(recordings, weights, problem.loaded if alone else problem.both, source.processing)
    return replace(system, known=problem.known.values if alone and problem.known is not None else None)


def joined(
    recordings: Sequence[tuple[Observer, Recording, bool]],
    weights: Array,
    reduced: Equations,
    processing: Processing,
) -> ObservationSystem:
    """Join recordings, each with its observer and whether it is with payload, to one system that is held whole."""
    robot_only, rows = np.array([name not in PAYLOAD for name in reduced.columns], dtype=float), []
    for k, (observer, recording, loaded) in enumerate(recordings):
        one = observer.observe(*used(measurement(recording, processing), processing))
        for j, (W, Y, t) in enumerate(zip(one.W, one.Y, one.t, strict=True), start=1):
            places = np.full(len(Y), j), np.full(len(Y), k), t, np.full(len(Y), loaded)
            rows.append((W if loaded else W * robot_only, Y, *places))
    W, Y, joint, number, t, flags = (np.concatenate(arrays) for arrays in zip(*rows, strict=True))
    sources = tuple(recording.source for _, recording, _ in recordings)
    return ObservationSystem(reduced.columns, W, Y, joint, number, t, flags, sources, weights, reduced)


@one_thread()
def identification_system(result: Identification) -> ObservationSystem:
    """Build the system behind an identification, in the robot's base parameters."""
    observer = Observer(result.robot, result.base.columns).at(result.estimate.values)
    recordings = [(observer, recording, False) for recording in result.recordings]
    return joined(recordings, result.estimate.weights, result.problem, result.processing)


@one_thread()
def equations(
    robot: Robot, recordings: Sequence[Recording], settings: Settings = DEFAULTS
) -> tuple[Array, Array, NDArray[np.int64], Array]:
    """Filter and decimate recordings of one load to equations Y = W chi + rho in the base parameters' columns.

    Friction is the robot's own: ``robot.with_friction`` gives it other terms.

    Returns:
        W, r x c; Y [N·m or N]; each row's joint, from 1; and its time in its recording [s].

    >>> W, Y, joint, t = equations(robot, unloaded)
    >>> W.shape == (len(Y), len(base_parameters(robot).columns))
    True
    """
    check_given(robot, recordings)
    base, processing = base_parameters(robot), settings.processing_of(robot)
    observer = payload_observer(robot)
    reduced = base_problem(observer, recordings, replace(settings, robust=False))
    observer = observer.only(base.columns).at(weighted_solution(reduced))  # friction under their own load
    system = joined([(observer, one, False) for one in recordings], np.ones(robot.n), reduced, processing)
    return system.W, system.Y, system.joint, system.t


@one_thread()
def robot_result(
    result: Identification, constrained: PossibleRobot | None = None, rollouts: Sequence[Rollout] = ()
) -> RobotResult:
    """Collect what ``identify`` answers, with the robot that can exist and what it predicts where asked for."""
    from ..results import robot as documents

    estimate, problem, base, robot = result.estimate, result.problem, result.base, result.robot
    raw, scaled = problem.condition_numbers()
    used = result.recordings[0].gains if result.recordings else ()
    noise: dict[str, Any] = {}  # of each joint [N·m or N], its memory counted, and independent errors a second
    if estimate.robust is not None and result.recordings:
        inflation = np.median(np.diag(estimate.robust.covariance) / np.diag(estimate.covariance))
        rate = result.processing.equations_a_second(result.recordings[0].rate)
        noise = {"torque_noise": np.sqrt(inflation) * estimate.noise, "independent": rate * problem.independent}
    return documents.RobotResult.of(
        result,
        estimate,
        robot,
        robot=robot.name,
        robot_title=robot.title or UNSET,
        joints=tuple(joint.kind for joint in robot.joints),
        processing=parts.ProcessingDocument.made(robot, result.processing, used),
        data=documents.RobotData.of(estimate, estimate.fit, problem, rows_per_joint=problem.rows, **noise),
        columns=estimate.names,
        covariance_robust=estimate.robust.covariance if estimate.robust else None,
        robust=parts.RobustDocument.made(estimate.robust, result.without_robust),
        base_parameters=parts.ParameterDocument.rows(
            estimate,
            name=base.names,
            grouping=base.groupings(),
            interval95=estimate.interval95,
            interval95_robust=estimate.robust_interval95,
            interval95_with_gains=estimate.interval95_with_gains,
            essential=[name in result.essential for name in estimate.names],
        ),
        elimination=parts.EliminationDocument.made(result.elimination, result.warnings, base),
        constrained=documents.PossibleRobotDocument.made(constrained, base) if constrained is not None else None,
        friction=result.choices or UNSET,
        chi2_by="formula" if estimate.robust is None else "jackknife",
        condition_number=raw,
        condition_number_scaled=scaled,
        relative_residual=parts.ResidualDocument.of(estimate.fit),
        validation=parts.ResidualDocument.of(result.validation) if result.validation else None,
        rollouts=tuple(rollouts) or UNSET,
        reasons_against_use=result.verdict.reasons,
    ).made_by(result)
