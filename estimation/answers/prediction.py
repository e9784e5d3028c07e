"""Measured torques of one recording beside those that identified parameters predict."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ...common.arrays import Array
from ...model import BaseParameters, InertialParameters, Processing, Recording, Robot
from ..equations.correlation import autocorrelation
from ..equations.observation import Observation
from ..equations.observer import Observer
from ..payload.equations import loaded_observer
from ..payload.problem import PayloadProblem
from ..signals.filtering import measurement

DRAWN = 3
"""Recordings of one kind that are predicted for drawings."""
POINTS = 2000
"""Rows of a joint that a drawing shows at most."""


@dataclass(frozen=True)
class Curve:
    """One prediction: what it is, and for each joint its torques [N·m or N], shapes (r_j,)."""

    label: str
    torque: tuple[Array, ...]


@dataclass(frozen=True)
class TorquePrediction:
    """Measured and predicted torques of one recording.

    Attributes:
        source: name of the recording.
        t: for each joint the time of its rows [s], shapes (r_j,); slow rows are left out.
        measured: for each joint its torques [N·m or N], shapes (r_j,).
        curves: predictions; residuals are those of the first.
    """

    source: str
    loaded: bool
    held_out: bool
    t: tuple[Array, ...]
    measured: tuple[Array, ...]
    curves: tuple[Curve, ...]

    def residual(self, joint: int) -> Array:
        """Measured less predicted torque of one joint, counted from 0."""
        return np.asarray(self.measured[joint] - self.curves[0].torque[joint])

    @property
    def relative_per_joint(self) -> Array:
        """Norm of the residual over norm of the torque, shape (n,); nan without torque."""
        errors = np.array([np.linalg.norm(self.residual(j)) for j in range(len(self.t))])
        torques = np.array([np.linalg.norm(torque) for torque in self.measured])
        return np.asarray(errors / np.where(torques > 0.0, torques, np.nan))

    def thinning(self, joint: int) -> int:
        """Every how many-th row of a joint (counted from 0) a drawing shows."""
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
    """A recording without payload and what the robot's parameters predict.

    Args:
        values: of ``base.columns``.
        recording: without payload.
    """
    pieces = Observer(robot, base.columns).pieces(measurement(recording, processing), processing)
    return _prediction(recording.source, pieces, [("predicted", values)], False, held_out)


def payload_prediction(
    problem: PayloadProblem, body: InertialParameters, recording: Recording, processing: Processing, held_out: bool
) -> TorquePrediction:
    """A recording with payload and what a payload predicts, beside the bare robot.

    Args:
        problem: the reduced recordings, with the robot's parameters.
        body: the payload, in the payload's frame.
        recording: with payload.
    """
    bare, flange = robot_values(problem), problem.robot.flange
    moved = body.moved(flange.R, flange.p).vector
    observer = loaded_observer(problem.robot, problem.base)
    pieces = observer.pieces(measurement(recording, processing), processing)
    curves = [
        ("predicted with payload", np.concatenate([bare, moved])),
        ("predicted without payload", np.concatenate([bare, np.zeros(len(moved))])),
    ]
    return _prediction(recording.source, pieces, curves, True, held_out)


def robot_values(problem: PayloadProblem) -> Array:
    """The robot's base parameters on which a payload's torques come on top."""
    robot = problem.alone
    assert robot is not None
    return robot.values


def _prediction(
    source: str,
    pieces: Iterable[Observation],
    curves: Sequence[tuple[str, Array]],
    loaded: bool,
    held_out: bool,
) -> TorquePrediction:
    """Prediction by equations in consecutive pieces: their torques are kept, W is not."""
    columns = [(p.t, p.Y, *(tuple(W @ chi for W in p.W) for _, chi in curves)) for p in pieces]
    t, measured, *predictions = (
        tuple(np.concatenate(joint) for joint in zip(*arrays, strict=True)) for arrays in zip(*columns, strict=True)
    )
    predicted = tuple(Curve(label, torques) for (label, _), torques in zip(curves, predictions, strict=True))
    return TorquePrediction(source, loaded, held_out, t, measured, predicted)
