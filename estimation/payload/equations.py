"""The equations of recordings with payload, [W W_L] of (22) and W_L of (29), whole and in blocks of time."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model import BaseParameters, Processing, Robot, base_parameters
from ...model.drives import FRICTION, parameter_kind
from ...model.motion import Measurement
from ...model.regressors import payload_columns
from ..equations.equations import PAYLOAD, Equations
from ..equations.observer import PATH, Observer, Used, known_spring, used
from ..equations.reduction import Recorded, recorded
from ..fit.blocks import (
    FEWEST,
    SHORTEST,
    Remembered,
    block_edges,
    block_length,
    in_blocks,
    remembered,
    weighted_solution,
)
from ..fit.estimate import Estimate
from ..fit.settings import Settings
from .path import robot_of

_STRETCHES = 4  # of all loaded recordings together


class PairedMeasurement(NamedTuple):
    """One trajectory without and with payload, on the loaded recording's time.

    ``lag`` [s]: what the loaded recording's clock shows more than the unloaded one's own.
    """

    unloaded: Measurement
    loaded: Measurement
    lag: float = 0.0


@dataclass(frozen=True, eq=False)
class _Load:
    """The equations of one load, the recordings that they come from, and those that their memory is judged by."""

    equations: Equations
    recordings: list[Recorded]
    judged: Equations

    @cached_property
    def memory(self) -> Remembered:
        """How long the errors remember."""
        return remembered(self.recordings, self.judged)

    def in_blocks(self, edges: Sequence[Array], length: float) -> Equations:
        """The equations cut between the edges of each recording, blocks of ``length`` [s]."""
        return in_blocks(self.equations, self.recordings, edges, length)


class Memory(NamedTuple):
    """How long the errors under load remember.

    ``inflation``: by how much that raises the variances of each joint; none where nothing was cut in blocks.
    ``few``: whether blocks as long as it asks for would be too few, so that shorter ones were cut.
    """

    inflation: tuple[float, ...] = ()
    few: bool = False


class PayloadEquations(NamedTuple):
    """``loaded``: [W W_L]; ``unloaded``: W; ``difference``: W_L, where there are pairs; ``stretches`` of loaded."""

    loaded: Equations
    unloaded: Equations | None
    difference: Equations | None
    stretches: tuple[Equations, ...] = ()
    memory: Memory = Memory()


def loaded_observer(robot: Robot, base: BaseParameters) -> Observer:
    """Observer of [W W_L], columns base, then ``PAYLOAD``."""
    names = (*base.columns, *PAYLOAD)
    return Observer(robot, (*base.columns, *payload_columns(robot)), names)


def torque_change(robot: Robot, unloaded: Measurement, loaded: Measurement) -> Measurement:
    """Y_T - Y_wL on the loaded motion.

    The observer moves the spring's torque into Y; in a difference it is there twice, and the first goes along.
    """
    torque = loaded.torque - unloaded.torque
    spring = known_spring(robot)
    if spring is None:
        return Measurement(loaded.motion, torque)
    return Measurement(loaded.motion, torque, spring.torque(unloaded.motion.q[:, spring.joint - 1]))


def payload_equations(
    robot: Robot,
    loaded: Sequence[Measurement],
    unloaded: Sequence[Measurement],
    pairs: Sequence[PairedMeasurement],
    settings: Settings,
    known: Estimate | None = None,
) -> PayloadEquations:
    """Reduce measurements, in blocks of time where robust; those of a pair at the same points of the motion.

    Args:
        loaded: with payload, each on its own time.
        unloaded: without; where there are pairs, the k-th is that of the k-th pair.
        pairs: for method 3; may be empty.
        known: the robot's parameters; without unloaded measurements the errors are those that they leave.
    """
    base, processing = base_parameters(robot), settings.processing_of(robot)
    observer = Observer(robot, (*base.columns, *payload_columns(robot), PATH))
    # Equations [W W_L] of (22); their memory is judged by what W alone leaves.
    equations, recordings = recorded(
        observer.only((*base.columns, *payload_columns(robot)), (*base.columns, *PAYLOAD)),
        (used(data, processing) for data in loaded),
    )
    heavy, bare, change = _Load(equations, recordings, equations.select(base.columns)), None, None
    if unloaded:
        bare = _load(observer.only(base.columns), (used(data, processing) for data in unloaded))
        change = _changes(observer, base, pairs, bare.equations, processing) if pairs else None
    if not settings.robust:
        without, difference = (load.equations if load is not None else None for load in (bare, change))
        return PayloadEquations(heavy.equations, without, difference)
    length = block_length([load.memory for load in (heavy, bare, change) if load is not None])
    # Where blocks that are as long as memory asks for are too few under load, shorter ones are cut.
    few = sum(len(block_edges(ends, length)) - 1 for ends in heavy.memory.spans) < FEWEST
    length = SHORTEST if few else length
    edges = [block_edges(ends, length) for ends in heavy.memory.spans]
    without = None
    if bare is not None:
        # Without partners by their own times, else where their partners are, on the clock without payload.
        own = [ends - pair.lag for ends, pair in zip(edges, pairs, strict=True)] if pairs else []
        without = bare.in_blocks(own or [block_edges(ends, length) for ends in bare.memory.spans], length)
    difference = change.in_blocks(edges, length) if change is not None else None
    longest = max(1, _STRETCHES // len(edges))
    stretches = tuple(
        stretch
        for recording, ends in zip(recordings, heavy.memory.spans, strict=True)
        for stretch in recording.cut(block_edges(ends, float(np.ptp(ends)) / longest))
    )
    inflation = heavy.memory.inflation if known is None or unloaded else _inflation_beside(known, heavy)
    return PayloadEquations(heavy.in_blocks(edges, length), without, difference, stretches, Memory(inflation, few))


def _load(observer: Observer, loads: Iterable[Used]) -> _Load:
    """Equations whose memory is judged by what they leave themselves."""
    equations, recordings = recorded(observer, loads)
    return _Load(equations, recordings, equations)


def _inflation_beside(known: Estimate, heavy: _Load) -> tuple[float, ...]:
    """By how much memory raises the variance of each joint's errors beside a robot that is known.

    By what it leaves of the loaded recordings, payload and friction found beside it: all of its parameters, found
    anew in a few seconds, would take up the slow errors for themselves. A few seconds of load show less memory than
    the robot's own recordings did.
    """
    rigid = [k for k, name in enumerate(known.names) if parameter_kind(name) not in FRICTION]
    beside = heavy.equations.minus([known.names[k] for k in rigid], known.values[rigid])
    values = dict(zip(known.names, known.values, strict=True))
    values |= zip(beside.columns, weighted_solution(beside), strict=True)
    chi = np.array([values[name] for name in heavy.equations.columns])
    own = Remembered.of([recording.residuals(chi) for recording in heavy.recordings]).inflation
    if known.robust is None:
        return own
    before = float(np.median((known.robust.sigma / np.maximum(known.sigma, 1e-300)) ** 2))
    return tuple(max(factor, before) for factor in own)


def _changes(
    observer: Observer,
    base: BaseParameters,
    pairs: Sequence[PairedMeasurement],
    unloaded: Equations,
    processing: Processing,
) -> _Load:
    """Equations (29) of pairs, Y_T - Y_wL, the torque that the robot needs more on the loaded path taken off.

    Friction's columns, of the loaded path, stand behind the payload's; memory is judged by what is left without.
    """
    chi, bare = robot_of(unloaded), observer.only(base.columns)
    friction = [name for name in base.columns if parameter_kind(name) in FRICTION]

    def change(pair: PairedMeasurement) -> Used:
        loaded = used(pair.loaded, processing, pair.unloaded.motion)
        path = bare.torques(pair.loaded.motion, chi) - bare.torques(pair.unloaded.motion, chi)
        return loaded._replace(data=replace(torque_change(observer.robot, pair.unloaded, pair.loaded), path=path))

    columns = (*payload_columns(observer.robot), PATH, *friction)
    equations, recordings = recorded(observer.only(columns, (*PAYLOAD, PATH, *friction)), map(change, pairs))
    return _Load(equations, recordings, equations.select((*PAYLOAD, PATH)))
