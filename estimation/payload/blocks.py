"""Recordings with and without payload cut into blocks of time, one motion's blocks side by side."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model import BaseParameters, Processing, Robot
from ...model.motion import Measurement
from ..equations.names import PAYLOAD
from ..equations.observation import Observation, Observer
from ..equations.problem import ReducedProblem, merged
from ..equations.reduction import reduced
from ..fit.blocks import (
    Pieces,
    Residuals,
    block_edges,
    cut_pieces,
    leave_one_out,
    length_by_residuals,
    residuals_of,
    span,
    weighted_solution,
)
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
    """Cut measurements into blocks; of long ones the equations are never held whole.

    Args:
        robot: the robot.
        base: its base parameters.
        loaded: with payload, each on its own time.
        unloaded: without; where there are pairs, the k-th is that of the k-th pair.
        pairs: for method 3; may be empty.
        processing: settings.
    """
    with_payload = _opened(loaded_observer(robot, base), loaded, processing)
    without = _opened(Observer(robot, base.columns), unloaded, processing)
    watcher = difference_observer(robot)
    changes = [
        watcher.opener(torque_change(robot, pair.unloaded, pair.loaded), processing, pair.unloaded.motion)
        for pair in pairs
    ]
    left = [_left(group) for group in ([_without_payload(one) for one in with_payload], without, changes)]
    length = length_by_residuals([group for group in left if group])
    edges = [block_edges(recording, length) for recording in left[0]]
    if pairs:
        other = [own - pair.lag for own, pair in zip(edges, pairs, strict=True)]
    else:
        other = [block_edges(recording, length) for recording in left[1]]
    pieces = max(1, _STRETCHES // max(len(with_payload), 1))
    return PayloadBlocks(
        length=length,
        loaded=_cut(with_payload, edges),
        unloaded=_cut(without, other),
        difference=_cut(changes, edges) if pairs else (),
        stretches=_cut(with_payload, [block_edges(one, np.ptp(span(one)) / pieces) for one in left[0]]),
    )


def _opened(observer: Observer, measurements: Sequence[Measurement], processing: Processing) -> list[Pieces]:
    return [observer.opener(data, processing) for data in measurements]


def _left(group: Sequence[Pieces]) -> list[Residuals]:
    """What the weighted fit to all recordings of one load leaves of each."""
    if not group:
        return []
    problem: ReducedProblem | None = None
    for piece in chain.from_iterable(pieces() for pieces in group):
        problem = merged([problem, reduced(piece)] if problem else [reduced(piece)])
    assert problem is not None
    values = weighted_solution(problem)
    return [residuals_of(pieces(), values) for pieces in group]


def _without_payload(pieces: Pieces) -> Pieces:
    """The robot's columns alone, of which the payload's are combinations."""

    def bare(piece: Observation) -> Observation:
        W = tuple(columns[:, : -len(PAYLOAD)] for columns in piece.W)
        return replace(piece, columns=piece.columns[: -len(PAYLOAD)], W=W)

    return lambda: map(bare, pieces())


def _cut(recordings: Sequence[Pieces], edges: Sequence[Array]) -> _Blocks:
    found = (cut_pieces(pieces(), ends) for pieces, ends in zip(recordings, edges, strict=True))
    return tuple(chain.from_iterable(found))
