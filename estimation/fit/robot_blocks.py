"""Robust standard deviations of a robot's parameters: solved again without each block of time."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ...common.arrays import Array
from ..equations.problem import ReducedProblem
from .blocks import Pieces, block_edges, cut_pieces, leave_one_out, length_by_residuals, residuals_of
from .estimate import Estimate
from .least_squares import weighted
from .robust import jackknife


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
    left = [residuals_of(pieces(), values) for pieces in recordings]
    length = length_by_residuals([left])
    blocks = [
        block
        for pieces, residuals in zip(recordings, left, strict=True)
        for block in cut_pieces(pieces(), block_edges(residuals, length))
    ]
    return RobotBlocks(length, tuple(leave_one_out(blocks)))
