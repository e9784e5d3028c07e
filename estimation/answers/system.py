"""Systems of recordings: measured and predicted torques, and W and Y held whole, with names."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...common.brief import Brief
from ...model import BaseParameters, InertialParameters, Processing, Recording, Robot
from ..equations.equations import PAYLOAD, Equations
from ..equations.observer import Observation, Observer
from ..fit.blocks import autocorrelation
from ..fit.own_equations import filtered
from ..payload.long_motion import LongMotion
from ..payload.methods import PayloadProblem, combined, from_robot
from ..payload.problem import loaded_observer
from ..signals.filtering import measurement

DRAWN = 3
"""Number of recordings of one kind that are predicted for drawings."""
POINTS = 2000
"""Largest number of a joint's rows in a drawing."""


@dataclass(frozen=True, repr=False)
class TorquePrediction(Brief):
    """Measured and predicted torques of one recording.

    Attributes:
        source: name of the recording.
        t: for each joint the time of its rows [s], shapes (r_j,); slow rows are left out.
        measured: for each joint its torques [N·m or N], shapes (r_j,).
        curves: predictions by what they are, joint by joint as ``measured``; residuals are those of the first.
    """

    source: str
    loaded: bool
    held_out: bool
    t: tuple[Array, ...]
    measured: tuple[Array, ...]
    curves: dict[str, tuple[Array, ...]]

    def residual(self, joint: int) -> Array:
        """Measured less predicted torque of one joint, counted from 0."""
        return np.asarray(self.measured[joint] - next(iter(self.curves.values()))[joint])

    @property
    def relative_per_joint(self) -> Array:
        """Norm of the residual over norm of the torque, shape (n,); nan without torque."""
        errors = np.array([np.linalg.norm(self.residual(j)) for j in range(len(self.t))])
        torques = np.array([np.linalg.norm(torque) for torque in self.measured])
        return np.asarray(errors / np.where(torques > 0.0, torques, np.nan))

    def thinning(self, joint: int) -> int:
        """Distance of a joint's rows (counted from 0) that a drawing shows."""
        return -(-len(self.t[joint]) // POINTS) or 1

    @property
    def worst(self) -> int:
        """The joint with the largest relative residual, counted from 0."""
        return int(np.argmax(np.nan_to_num(self.relative_per_joint, nan=-1.0)))

    @property
    def step(self) -> float:
        """Time between neighbouring rows [s]; nan if no joint has two."""
        gaps = [float(np.median(np.diff(t))) for t in self.t if len(t) > 1]
        return min(gaps, default=float("nan"))

    def autocorrelation(self, joint: int, span: float = 2.0) -> tuple[Array, Array]:
        """Lags [s] up to ``span`` and the residual's autocorrelation there; a joint counted from 0."""
        t = self.t[joint]
        if len(t) < 3:
            return np.zeros(1), np.ones(1)
        step = self.step
        lags = max(1, min(round(span / step), int((t[-1] - t[0]) / step) // 2))
        return np.asarray(step * np.arange(lags + 1), dtype=float), autocorrelation(
            t, self.residual(joint), step, lags
        )


def robot_prediction(
    robot: Robot,
    base: BaseParameters,
    values: Array,
    recording: Recording,
    processing: Processing,
    held_out: bool,
) -> TorquePrediction:
    """Predict a recording without payload by the robot's parameters.

    Args:
        values: of ``base.columns``.
        recording: without payload.
    """
    pieces = Observer(robot, base.columns).at(values).pieces(measurement(recording, processing), processing)
    return _prediction(recording.source, pieces, {"predicted": values}, False, held_out)


def payload_prediction(
    problem: PayloadProblem, body: InertialParameters, recording: Recording, processing: Processing, held_out: bool
) -> TorquePrediction:
    """Predict a recording with payload by a payload, and by the unloaded robot.

    Args:
        problem: the reduced recordings, with the robot's parameters.
        body: the payload, in the payload's frame.
        recording: with payload.
    """
    assert problem.robot_estimate is not None
    robot_values, flange = problem.robot_estimate.values, problem.robot.flange
    moved = body.moved(flange.R, flange.p).vector
    observer, data = loaded_observer(problem.robot, problem.base), measurement(recording, processing)
    with_payload, without = (np.concatenate([robot_values, ten]) for ten in (moved, np.zeros(len(moved))))
    own = observer.at(with_payload).pieces(data, processing)
    prediction = _prediction(recording.source, own, {"predicted with payload": with_payload}, True, held_out)
    empty = observer.at(without).pieces(data, processing)
    other = _prediction(recording.source, empty, {"predicted without payload": without}, True, held_out)
    return replace(prediction, curves=prediction.curves | other.curves)


def _prediction(
    source: str,
    pieces: Iterable[Observation],
    curves: Mapping[str, Array],
    loaded: bool,
    held_out: bool,
) -> TorquePrediction:
    """Predict by equations in consecutive pieces: their torques are kept, W is not."""
    columns = [(p.t, p.Y, *(tuple(W @ chi for W in p.W) for chi in curves.values())) for p in pieces]
    t, measured, *predictions = (
        tuple(np.concatenate(joint) for joint in zip(*arrays, strict=True)) for arrays in zip(*columns, strict=True)
    )
    predicted = dict(zip(curves, predictions, strict=True))
    return TorquePrediction(source, loaded, held_out, t, measured, predicted)


Integers = NDArray[np.int64]


@dataclass(frozen=True, repr=False)
class ObservationSystem(Brief):
    """System Y = W chi + rho as an estimator sees it: filtered, decimated, without the rows that are not used.

    Rows stand recording by recording, in each joint by joint, in each by time.

    Attributes:
        columns: names of the columns of W, c.
        W: observation matrix, SI units, r x c.
        Y: torques [N·m or N], known ones (a spring) moved there, shape (r,).
        joint: number of each row's joint, from 1, shape (r,).
        recording: number of each row's recording in ``sources``, from 0, shape (r,).
        t: time of each row in its recording [s], shape (r,).
        loaded: whether each row's recording is with payload, shape (r,).
        sources: names of the recordings.
        weights: per joint, the weights of the weighted least squares [1/(N·m) or 1/N], shape (n,).
        reduced: the same equations as triangular factors.
        known: values of the first columns that are known from an earlier identification, where they are.
    """

    columns: tuple[str, ...]
    W: Array
    Y: Array
    joint: Integers
    recording: Integers
    t: Array
    loaded: NDArray[np.bool_]
    sources: tuple[str, ...]
    weights: Array
    reduced: Equations
    known: Array | None = None

    def __post_init__(self) -> None:
        """Refuse rows that lack a part."""
        rows = len(self.Y)
        if self.W.shape != (rows, len(self.columns)) or rows != self.reduced.equations:
            raise ValueError(f"W is {self.W.shape}, for {rows} rows and {len(self.columns)} columns")
        if any(len(part) != rows for part in (self.joint, self.recording, self.t, self.loaded)):
            raise ValueError("joint, recording, t and loaded need one entry for each row")


def payload_system(
    problem: LongMotion, loaded: Sequence[Recording], unloaded: Sequence[Recording], processing: Processing
) -> ObservationSystem:
    """Build the system of method 4, (30): base parameters, then the payload's ten in ``robot.last_frame``.

    Without unloaded recordings that of method 1, (22), with the robot's stored values as ``known``.

    Args:
        problem: of ``payload_problem`` with these recordings and settings.
        unloaded: recordings without; their rows have zeros in the payload's columns.
    """
    reduced, known = problem.loaded, problem.known
    if problem.unloaded is not None:
        weights, known = combined(problem).weights, None
        reduced = problem.both
    else:
        weights = from_robot(problem).weights()
    observer = loaded_observer(problem.robot, problem.base)
    recordings, flags = [*unloaded, *loaded], [False] * len(unloaded) + [True] * len(loaded)
    own = (
        problem.robot_estimate.values if problem.robot_estimate is not None else np.zeros(len(problem.base.columns))
    )
    observers = [observer.at(np.append(own, problem.carried * flag)) for flag in flags]
    system = joined(observers, recordings, flags, weights, reduced, processing)
    return replace(system, known=known.values if known is not None else None)


def joined(
    observers: Sequence[Observer],
    recordings: Sequence[Recording],
    loaded: Sequence[bool],
    weights: Array,
    reduced: Equations,
    processing: Processing,
) -> ObservationSystem:
    """Join recordings to one system, each held whole; ``loaded``: whether each is with payload."""
    every = zip(observers, filtered(recordings, processing), strict=True)
    observations = [observer.observe(data, processing) for observer, data in every]
    robot_only = np.array([name not in PAYLOAD for name in reduced.columns], dtype=float)
    W = [
        part if under_load else part * robot_only
        for observation, under_load in zip(observations, loaded, strict=True)
        for part in observation.W
    ]
    counts = [[len(Y) for Y in observation.Y] for observation in observations]
    totals = [sum(rows) for rows in counts]
    return ObservationSystem(
        columns=reduced.columns,
        W=np.concatenate(W),
        Y=np.concatenate([Y for observation in observations for Y in observation.Y]),
        joint=np.concatenate([np.repeat(np.arange(1, len(rows) + 1), rows) for rows in counts]),
        recording=np.repeat(np.arange(len(totals)), totals),
        t=np.concatenate([t for observation in observations for t in observation.t]),
        loaded=np.repeat(np.array(loaded, dtype=bool), totals),
        sources=tuple(recording.source for recording in recordings),
        weights=weights,
        reduced=reduced,
    )
