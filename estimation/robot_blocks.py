"""Robust standard deviations of a robot's parameters: solved again without each block of time."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..model.arrays import Array
from .blocks import Residuals, block_edges, leave_one_out, length_by_residuals, span
from .estimate import Estimate
from .least_squares import weighted
from .observation import Observation
from .problem import ReducedProblem, merged
from .reduction import reduced
from .robust import jackknife

Pieces = Callable[[], Iterable[Observation]]
"""Opens the equations of one recording, in consecutive pieces of time."""
_MERGED = 8  # problems kept apart until they are merged


@dataclass(frozen=True)
class RobotBlocks:
    """The robot's equations without each block of time in turn.

    Attributes:
        length: shortest length of a block [s], unless a whole recording is shorter.
        without: for each block all the others, merged.
    """

    length: float
    without: tuple[ReducedProblem, ...]

    def applied_to(self, estimate: Estimate) -> Estimate:
        """A weighted least-squares estimate of some or all parameters with its robust covariance, weights fixed.

        Raises:
            InputError: if the data without one block do not determine the parameters.
        """

        def solve(part: ReducedProblem) -> Array:
            return weighted(part.select(estimate.names), estimate.weights).values

        return replace(estimate, robust=jackknife(solve, [self.without], estimate.values, self.length))


def robot_blocks(recordings: Sequence[Pieces], values: Array) -> RobotBlocks:
    """Cut recordings of one load into blocks, none across recordings; their equations are never held whole.

    Args:
        recordings: each opens a recording's equations anew, in consecutive pieces of time; called twice.
        values: of all parameters by weighted least squares, whose residuals tell how long a block must be.

    Raises:
        InputError: if there is only one block.
    """
    left = [_residuals(pieces(), values) for pieces in recordings]
    length = length_by_residuals([left])
    blocks = [
        block
        for pieces, residuals in zip(recordings, left, strict=True)
        for block in _cut(pieces(), block_edges(residuals, length))
    ]
    return RobotBlocks(length, tuple(leave_one_out(blocks)))


def _residuals(pieces: Iterable[Observation], values: Array) -> Residuals:
    parts = [(piece.t, piece.errors(values)) for piece in pieces]
    t, errors = (tuple(map(np.concatenate, zip(*arrays, strict=True))) for arrays in zip(*parts, strict=True))
    return Residuals(t, errors)


def _cut(pieces: Iterable[Observation], edges: Array) -> list[ReducedProblem]:
    """As ``blocks.cut``, a piece at a time: most blocks lie in one of them."""
    found: list[list[ReducedProblem]] = [[] for _ in edges[1:]]
    nothing: list[ReducedProblem] = []  # of a block in which the robot pauses
    for piece in pieces:
        nothing = nothing or [reduced(piece.between(np.inf, np.inf))]
        first, last = np.searchsorted(edges, span(piece), side="right") - 1
        for k in range(int(first), int(last) + 1):
            found[k].append(reduced(piece.between(edges[k], edges[k + 1])))
            if len(found[k]) > _MERGED:
                found[k] = [merged(found[k])]
    return [merged(parts or nothing) for parts in found]
