"""Recordings with and without payload cut into blocks of time, one motion's blocks side by side."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from typing import NamedTuple

import numpy as np

from ...model import BaseParameters, Measurement, Processing, Robot
from ...model.arrays import Array
from ..blocks import block_edges, block_length, cut, leave_one_out, span
from ..names import PAYLOAD
from ..observation import Observation, Observer
from ..problem import ReducedProblem
from .equations import difference_observer, loaded_observer, torque_change

_STRETCHES = 4  # of all loaded recordings together

_Blocks = tuple[ReducedProblem, ...]


class PairedMeasurement(NamedTuple):
    """One trajectory without and with payload, on the loaded recording's time.

    ``lag`` [s]: what the loaded recording's clock shows more than the unloaded one's own.
    """

    unloaded: Measurement
    loaded: Measurement
    lag: float = 0.0


@dataclass(frozen=True)
class PayloadBlocks:
    """The equations of a ``PayloadProblem`` by blocks of time.

    Attributes:
        length: shortest length of a block [s], unless a whole recording is shorter.
        loaded: blocks of the recordings with payload.
        unloaded: of those without; with ``difference`` the k-th is the same stretch of the motion as the k-th of
            ``loaded``.
        difference: of the torque differences; empty where the recordings form no pairs.
        stretches: the loaded recordings once more, in a few long pieces.
    """

    length: float
    loaded: _Blocks
    unloaded: _Blocks = ()
    difference: _Blocks = ()
    stretches: _Blocks = ()

    def __post_init__(self) -> None:
        """Blocks that are left out together must be as many."""
        if self.difference and not len(self.loaded) == len(self.unloaded) == len(self.difference):
            raise ValueError("paired blocks must be as many without and with payload")

    @cached_property
    def loaded_without(self) -> _Blocks:
        """For each block of ``loaded`` all the others merged, once for all methods."""
        return tuple(leave_one_out(self.loaded))

    @cached_property
    def unloaded_without(self) -> _Blocks:
        """The same of ``unloaded``."""
        return tuple(leave_one_out(self.unloaded))

    @cached_property
    def difference_without(self) -> _Blocks:
        """The same of ``difference``."""
        return tuple(leave_one_out(self.difference))


def payload_blocks(
    robot: Robot,
    base: BaseParameters,
    loaded: Sequence[Measurement],
    unloaded: Sequence[Measurement],
    pairs: Sequence[PairedMeasurement],
    processing: Processing,
) -> PayloadBlocks:
    """Cut measurements into blocks; their equations are held whole meanwhile.

    Args:
        robot: the robot.
        base: its base parameters.
        loaded: with payload, each on its own time.
        unloaded: without; where there are pairs, the k-th is that of the k-th pair.
        pairs: for method 3; may be empty.
        processing: settings.
    """
    with_payload = _observed(loaded_observer(robot, base), loaded, processing)
    without = _observed(Observer(robot, base.columns), unloaded, processing)
    watcher = difference_observer(robot)
    changes = [
        watcher.observe(torque_change(robot, pair.unloaded, pair.loaded), processing, pair.unloaded.motion)
        for pair in pairs
    ]
    explained = [[_without_payload(recording) for recording in with_payload], without, changes]
    length = block_length([group for group in explained if group])
    edges = [block_edges(recording, length) for recording in with_payload]
    if pairs:
        lags = [pair.lag for pair in pairs]
        other = [own - lag for own, lag in zip(edges, lags, strict=True)]
    else:
        other = [block_edges(recording, length) for recording in without]
    pieces = max(1, _STRETCHES // max(len(with_payload), 1))
    return PayloadBlocks(
        length=length,
        loaded=_cut(with_payload, edges),
        unloaded=_cut(without, other),
        difference=_cut(changes, edges) if pairs else (),
        stretches=_cut(with_payload, [block_edges(one, np.ptp(span(one)) / pieces) for one in with_payload]),
    )


def _observed(observer: Observer, measurements: Sequence[Measurement], processing: Processing) -> list[Observation]:
    return [observer.observe(data, processing) for data in measurements]


def _without_payload(recording: Observation) -> Observation:
    """The robot's columns alone, of which the payload's are combinations."""
    W = tuple(columns[:, : -len(PAYLOAD)] for columns in recording.W)
    return Observation(recording.columns[: -len(PAYLOAD)], W, recording.Y, recording.t, recording.bandwidth)


def _cut(recordings: Sequence[Observation], edges: Sequence[Array]) -> _Blocks:
    return tuple(chain.from_iterable(cut(*both) for both in zip(recordings, edges, strict=True)))
