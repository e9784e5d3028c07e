"""Systems of recordings: measured and predicted torques, and W and Y held whole, with names."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...common import Array, Brief, Indices, Mask
from ...model import InertialParameters, Processing, Recording
from ...model.regressors import payload_columns
from ..equations.equations import PAYLOAD, Equations
from ..equations.observer import Observer, used
from ..fit.covariance import autocorrelation
from ..fit.linear_problem import weighted
from ..payload.long_motion import LongMotion
from ..payload.methods import PayloadProblem, from_robot
from ..signals.filtering import measurement

DRAWN = 3  # number of recordings of one kind that are predicted for drawings
POINTS = 2000  # largest number of a joint's rows in a drawing


@dataclass(frozen=True, eq=False, repr=False)
class TorquePrediction(Brief):
    """Measured and predicted torques of one recording, joint by joint, without slow rows."""

    source: str
    loaded: bool
    held_out: bool
    t: tuple[Array, ...]  # [s], (r_j,)
    measured: tuple[Array, ...]  # [N·m or N], (r_j,)
    curves: dict[str, tuple[Array, ...]]  # predictions by what they are; residuals are those of the first

    def residual(self, joint: int) -> Array:
        """Measured less predicted torque of a joint, counted from 0."""
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
    def step(self) -> float:
        """Time between neighbouring rows [s]; nan if no joint has two."""
        return min((float(np.median(np.diff(t))) for t in self.t if len(t) > 1), default=float("nan"))

    def autocorrelation(self, joint: int, span: float = 2.0) -> tuple[Array, Array]:
        """Lags [s] up to ``span`` and the residual's autocorrelation there; a joint counted from 0."""
        t, step = self.t[joint], self.step
        if len(t) < 3:
            return np.zeros(1), np.ones(1)
        lags = max(1, min(round(span / step), int((t[-1] - t[0]) / step) // 2))
        return np.arange(lags + 1.0) * step, autocorrelation([(t, self.residual(joint))], step)[: lags + 1]


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
        data, predicted = measurement(recording, processing), dict[str, tuple[Array, ...]]()
        for label, chi in curves.items():
            one = observer.at(chi).observe(*used(data, processing))
            predicted[label] = tuple(y - error for y, error in zip(one.Y, one.errors(chi), strict=True))
        found.append(TorquePrediction(recording.source, loaded, held_out, one.t, one.Y, predicted))
    return tuple(found)


def payload_predictions(problem: PayloadProblem, body: InertialParameters) -> tuple[TorquePrediction, ...]:
    """Predict a few loaded recordings of a problem by a body in the payload's frame and by the unloaded robot."""
    assert problem.robot_estimate is not None
    own, flange, source = problem.robot_estimate.values, problem.robot.flange, problem.source
    moved = body.moved(flange.R, flange.p).vector
    both = {"predicted with payload": moved, "predicted without payload": 0.0 * moved}
    curves = {label: np.append(own, ten) for label, ten in both.items()}
    return predictions(_loaded_observer(problem), curves, source.loaded, source.processing, loaded=True)


def _loaded_observer(problem: PayloadProblem) -> Observer:
    """Make the observer of [W W_L], columns base, then ``PAYLOAD``."""
    columns = problem.base.columns
    return Observer(problem.robot, (*columns, *payload_columns(problem.robot)), (*columns, *PAYLOAD))


@dataclass(frozen=True, eq=False, repr=False)
class ObservationSystem(Brief):
    """System Y = W chi + rho as an estimator sees it: filtered, decimated, without the rows that are not used.

    Rows stand recording by recording, in each joint by joint, in each by time.
    """

    columns: tuple[str, ...]  # c
    W: Array  # SI units, r x c
    Y: Array  # torques [N·m or N], known ones (a spring) moved there, (r,)
    joint: Indices  # each row's joint, from 1, (r,)
    recording: Indices  # each row's recording in ``sources``, from 0, (r,)
    t: Array  # [s], (r,)
    loaded: Mask  # whether each row's recording is with payload, (r,)
    sources: tuple[str, ...]  # the recordings
    weights: Array  # per joint, of the weighted least squares [1/(N·m) or 1/N], (n,)
    reduced: Equations  # the same equations as triangular factors
    known: Array | None = None  # values of the first columns that are known from an earlier identification


def payload_system(problem: LongMotion) -> ObservationSystem:
    """Build the system of method 4, (30): base parameters, then the payload's ten in ``robot.last_frame``.

    Rows of unloaded recordings have zeros in the payload's columns; without any it is the system of method 1, (22),
    with the robot's stored values as ``known``.
    """
    source, robot, observer = problem.source, problem.robot_estimate, _loaded_observer(problem)
    own = robot.values if robot is not None else np.zeros(len(problem.base.columns))
    without, under_load = (observer.at(np.append(own, ten)) for ten in (0.0 * problem.carried, problem.carried))
    recordings = [(without, recording, False) for recording in source.unloaded]
    recordings += [(under_load, recording, True) for recording in source.loaded]
    if problem.unloaded is not None:
        return joined(recordings, weighted(problem.both).weights, problem.both, source.processing)
    system = joined(recordings, from_robot(problem).weights(), problem.loaded, source.processing)
    return replace(system, known=problem.known.values if problem.known is not None else None)


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
