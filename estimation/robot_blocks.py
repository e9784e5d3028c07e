"""Robust standard deviations of a robot's parameters: solved again without each block of time."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ..model.arrays import Array
from .blocks import block_edges, block_length, cut, leave_one_out
from .estimate import Estimate
from .least_squares import weighted
from .observation import Observation
from .problem import ReducedProblem
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


def robot_blocks(recordings: Sequence[Observation]) -> RobotBlocks:
    """Cut recordings of one load into blocks, none across recordings.

    Raises:
        InputError: if there is only one block.
    """
    length = block_length([recordings])
    blocks = [block for recording in recordings for block in cut(recording, block_edges(recording, length))]
    return RobotBlocks(length, tuple(leave_one_out(blocks)))
