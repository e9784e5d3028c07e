"""The equations of recordings with payload, [W W_L] of (22) and W_L of (29), whole and in blocks of time."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model import BaseParameters, Processing, Robot
from ...model.drives import FRICTION, parameter_kind
from ...model.motion import Measurement
from ...model.regressors import payload_columns
from ..equations.equations import PAYLOAD, Equations
from ..equations.observer import PATH, Observer, Used, used
from ..equations.reduction import Recorded, Residuals, recorded
from ..equations.shared_torque import known_spring
from ..fit.blocks import (
    FEWEST,
    SHORTEST,
    Remembered,
    block_edges,
    block_length,
    in_blocks,
    memory_factors,
    remembered,
    weighted_solution,
)
from ..fit.estimate import Estimate
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


class PayloadEquations(NamedTuple):
    """``loaded``: [W W_L]; ``unloaded``: W; ``difference``: W_L, where there are pairs; ``stretches`` of loaded.

    ``inflation``: of each joint's errors under load, by their memory; none where nothing was cut in blocks.
    ``few``: whether blocks as long as that memory asks for would be too few, so that shorter ones were cut.
    """

    loaded: Equations
    unloaded: Equations | None
    difference: Equations | None
    stretches: tuple[Equations, ...] = ()
    inflation: tuple[float, ...] = ()
    few: bool = False


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


def _long_edges(spans: Sequence[Array]) -> list[Array]:
    """Ends of a few long stretches of the recordings with payload."""
    stretches = max(1, _STRETCHES // len(spans))
    return [block_edges(ends, float(np.ptp(ends)) / stretches) for ends in spans]


def _partners_edges(edges: Sequence[Array], pairs: Sequence[PairedMeasurement]) -> list[Array]:
    """Ends of the blocks on the clocks of the recordings without payload; empty without pairs."""
    return [ends - pair.lag for ends, pair in zip(edges, pairs, strict=True)] if pairs else []


def payload_equations(
    robot: Robot,
    base: BaseParameters,
    loaded: Sequence[Measurement],
    unloaded: Sequence[Measurement],
    pairs: Sequence[PairedMeasurement],
    processing: Processing,
    blocks: bool = True,
    known: Estimate | None = None,
) -> PayloadEquations:
    """Reduce measurements; of long ones the equations are never held whole.

    Args:
        loaded: with payload, each on its own time.
        unloaded: without; where there are pairs, the k-th is that of the k-th pair.
        pairs: for method 3; may be empty.
        blocks: cut them in blocks of time as well, those of a pair at the same points of the motion.
        known: the robot's parameters; without unloaded measurements the errors are those that they leave.
    """
    heavy, bare, change = _loads(robot, base, loaded, unloaded, pairs, processing)
    if not blocks:
        without, difference = (load.equations if load is not None else None for load in (bare, change))
        return PayloadEquations(heavy.equations, without, difference)
    length, few = _block_length([load.memory for load in (heavy, bare, change) if load is not None])
    edges = [block_edges(ends, length) for ends in heavy.memory.spans]
    without = _in_partners_blocks(bare, _partners_edges(edges, pairs), length) if bare is not None else None
    difference = change.in_blocks(edges, length) if change is not None else None
    stretches = _cut(heavy.recordings, _long_edges(heavy.memory.spans))
    inflation = heavy.memory.inflation if known is None or unloaded else _inflation_beside(known, heavy)
    return PayloadEquations(heavy.in_blocks(edges, length), without, difference, stretches, inflation, few)


def _loads(
    robot: Robot,
    base: BaseParameters,
    loaded: Sequence[Measurement],
    unloaded: Sequence[Measurement],
    pairs: Sequence[PairedMeasurement],
    processing: Processing,
) -> tuple[_Load, _Load | None, _Load | None]:
    """Equations with payload, without, and of the difference, by one generated code."""
    observer = Observer(robot, (*base.columns, *payload_columns(robot), PATH))
    heavy = _with_payload(observer, base, loaded, processing)
    if not unloaded:
        return heavy, None, None
    bare = _load(observer.only(base.columns), (used(data, processing) for data in unloaded))
    return heavy, bare, _changes(observer, base, pairs, bare.equations, processing) if pairs else None


def _with_payload(
    observer: Observer, base: BaseParameters, loaded: Sequence[Measurement], processing: Processing
) -> _Load:
    """Equations [W W_L] of (22); their memory is judged by what W alone leaves."""
    columns = (*base.columns, *payload_columns(observer.robot))
    heavy = (used(data, processing) for data in loaded)
    equations, recordings = recorded(observer.only(columns, (*base.columns, *PAYLOAD)), heavy)
    return _Load(equations, recordings, equations.select(base.columns))


def _load(observer: Observer, loads: Iterable[Used]) -> _Load:
    """Equations whose memory is judged by what they leave themselves."""
    equations, recordings = recorded(observer, loads)
    return _Load(equations, recordings, equations)


def _in_partners_blocks(bare: _Load, edges: Sequence[Array], length: float) -> Equations:
    """Equations without payload, cut where their partners are; without partners by their own times."""
    return bare.in_blocks(edges or [block_edges(ends, length) for ends in bare.memory.spans], length)


def _inflation_beside(known: Estimate, heavy: _Load) -> tuple[float, ...]:
    """By how much memory raises the variance of each joint's errors beside a robot that is known."""
    own = memory_factors(_left_by(known, heavy.recordings, heavy.equations))
    return tuple(max(factor, _memory_of(known)) for factor in own)


def _memory_of(known: Estimate) -> float:
    """By how much memory raised the variances of a robot's parameters; a few seconds of load show less of it."""
    if known.robust is None:
        return 1.0
    return float(np.median((known.robust.sigma / np.maximum(known.sigma, 1e-300)) ** 2))


def _left_by(known: Estimate, recordings: Sequence[Recorded], loaded: Equations) -> list[Residuals]:
    """What a robot that is known leaves of the loaded recordings, payload and friction found beside it.

    All of its parameters, found anew in a few seconds, would take up the slow errors for themselves.
    """
    rigid = [k for k, name in enumerate(known.names) if parameter_kind(name) not in FRICTION]
    beside = loaded.minus([known.names[k] for k in rigid], known.values[rigid])
    values = dict(zip(known.names, known.values, strict=True))
    values |= zip(beside.columns, weighted_solution(beside), strict=True)
    chi = np.array([values[name] for name in loaded.columns])
    return [recording.residuals(chi) for recording in recordings]


def _block_length(loads: Sequence[Remembered]) -> tuple[float, bool]:
    """Length of a block [s], and whether those that memory asks for were too few under load."""
    length = block_length(loads)
    few = sum(len(block_edges(ends, length)) - 1 for ends in loads[0].spans) < FEWEST
    return (SHORTEST, True) if few else (length, False)


def _changes(
    observer: Observer,
    base: BaseParameters,
    pairs: Sequence[PairedMeasurement],
    unloaded: Equations,
    processing: Processing,
) -> _Load:
    """Equations (29) of pairs, the torque of paths that differ taken off; friction beside the payload's columns."""
    chi, bare = robot_of(unloaded), observer.only(base.columns)
    friction = [name for name in base.columns if parameter_kind(name) in FRICTION]
    alone = observer.only((*payload_columns(observer.robot), PATH, *friction), (*PAYLOAD, PATH, *friction))
    equations, recordings = recorded(alone, (_change(bare, chi, pair, processing) for pair in pairs))
    return _Load(equations, recordings, equations.select((*PAYLOAD, PATH)))


def _change(observer: Observer, chi: Array, pair: PairedMeasurement, processing: Processing) -> Used:
    """Y_T - Y_wL of a pair, with what the robot of these parameters needs more on the loaded path."""
    loaded = used(pair.loaded, processing, pair.unloaded.motion)

    path = observer.torques(pair.loaded.motion, chi) - observer.torques(pair.unloaded.motion, chi)
    change = torque_change(observer.robot, pair.unloaded, pair.loaded)
    return loaded._replace(data=replace(change, path=path))


def _cut(recordings: Sequence[Recorded], edges: Sequence[Array]) -> tuple[Equations, ...]:
    return tuple(
        chain.from_iterable(recording.cut(ends) for recording, ends in zip(recordings, edges, strict=True))
    )
