"""The observation system held whole, W and Y with names, for those who bring a solver of their own."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...model import Processing, Recording
from ..equations.equations import Equations
from ..equations.observation import Observation
from ..equations.observer import Observer
from ..fit.own_equations import filtered
from ..payload.equations import loaded_observer
from ..payload.methods import combined, from_robot
from ..payload.problem import PayloadProblem
from .identification import Identification

Integers = NDArray[np.int64]


@dataclass(frozen=True)
class ObservationSystem:
    """Y = W chi + rho as an estimator sees it: filtered, decimated, without the rows that are not used.

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
        """Every row must have all its parts."""
        rows = len(self.Y)
        if self.W.shape != (rows, len(self.columns)) or rows != self.reduced.equations:
            raise ValueError(f"W is {self.W.shape}, for {rows} rows and {len(self.columns)} columns")
        if any(len(part) != rows for part in (self.joint, self.recording, self.t, self.loaded)):
            raise ValueError("joint, recording, t and loaded need one entry for each row")


def identification_system(
    result: Identification, recordings: Sequence[Recording], processing: Processing
) -> ObservationSystem:
    """The system behind an identification, in the robot's base parameters.

    Args:
        result: of ``identify`` with these recordings and settings.
        recordings: without payload.
    """
    observations = _observed(Observer(result.robot, result.base.columns), recordings, processing)
    loaded = [False] * len(recordings)
    return _system(observations, recordings, loaded, result.estimate.weights, result.problem)


def payload_system(
    problem: PayloadProblem, loaded: Sequence[Recording], unloaded: Sequence[Recording], processing: Processing
) -> ObservationSystem:
    """The system of method 4, (30): base parameters, then the payload's ten in frame n (``robot.last_frame``).

    Without unloaded recordings that of method 1, (22), with the robot's stored values as ``known``.

    Args:
        problem: of ``payload_problem`` with these recordings and settings.
        unloaded: recordings without; their rows have zeros in the payload's columns.
    """
    robot, base, columns = problem.robot, problem.base, problem.loaded.columns
    observer = loaded_observer(robot, base)
    observations = [
        *(
            _widened(observation, columns)
            for observation in _observed(observer.only(base.columns), unloaded, processing)
        ),
        *_observed(observer, loaded, processing),
    ]
    flags = [False] * len(unloaded) + [True] * len(loaded)
    reduced, known = problem.loaded, problem.known
    if problem.unloaded is not None:
        weights, known = combined(problem).weights, None
        reduced = problem.both
    else:
        weights = from_robot(problem).weights()
    system = _system(observations, [*unloaded, *loaded], flags, weights, reduced)
    return replace(system, known=known.values if known is not None else None)


def _observed(observer: Observer, recordings: Sequence[Recording], processing: Processing) -> list[Observation]:
    """The equations of recordings, each held whole."""
    return [observer.observe(data, processing) for data in filtered(recordings, processing)]


def _widened(observation: Observation, columns: tuple[str, ...]) -> Observation:
    """Equations with columns of zeros after their own."""
    more = len(columns) - len(observation.columns)
    W = tuple(np.pad(part, ((0, 0), (0, more))) for part in observation.W)
    return Observation(columns, W, observation.Y, observation.t, observation.bandwidth)


def _system(
    observations: Sequence[Observation],
    recordings: Sequence[Recording],
    loaded: Iterable[bool],
    weights: Array,
    reduced: Equations,
) -> ObservationSystem:
    parts = [
        (observation.W[j], observation.Y[j], observation.t[j], j + 1, number, with_load)
        for number, (observation, with_load) in enumerate(zip(observations, loaded, strict=True))
        for j in range(len(observation.Y))
    ]
    counts = [len(part[1]) for part in parts]
    return ObservationSystem(
        columns=reduced.columns,
        W=np.concatenate([part[0] for part in parts]),
        Y=np.concatenate([part[1] for part in parts]),
        joint=np.repeat(np.array([part[3] for part in parts]), counts),
        recording=np.repeat(np.array([part[4] for part in parts]), counts),
        t=np.concatenate([part[2] for part in parts]),
        loaded=np.repeat(np.array([part[5] for part in parts]), counts),
        sources=tuple(recording.source for recording in recordings),
        weights=weights,
        reduced=reduced,
    )
