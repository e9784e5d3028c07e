"""Standard deviations that hold for autocorrelated residuals: the delete-a-block jackknife."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from scipy.special import stdtrit

from ...common.arrays import Array, frozen_array
from ...common.brief import Brief
from ...common.errors import InputError

T = TypeVar("T")
FEW = 10
"""Blocks; below them the intervals are wide and uncertain themselves."""


def student95(degrees_of_freedom: float) -> float:
    """How many standard deviations a 95 % interval reaches to either side, by Student's t."""
    return float(stdtrit(max(degrees_of_freedom, 1.0), 0.975))


NORMAL95 = student95(1e9)
"""How many a 95 % interval of a normal number reaches, whose standard deviation is known."""


def few_blocks(degrees_of_freedom: float) -> float:
    """By how much an interval from few blocks is wider than one from many, standard deviations being equal."""
    return student95(degrees_of_freedom) / NORMAL95


@dataclass(frozen=True, repr=False)
class RobustCovariance(Brief):
    """Covariance of the estimation error whatever the memory of the noise, if shorter than a block.

    Attributes:
        covariance: c x c.
        blocks: number of blocks that were left out in turn.
        degrees_of_freedom: of Student's t for intervals.
        block_length: shortest length of a block [s], unless a whole recording is shorter.
        by_memory: whether it goes by the memory of each joint's errors, blocks being too few for a jackknife.
    """

    covariance: Array
    blocks: int
    degrees_of_freedom: int
    block_length: float
    by_memory: bool = False

    def __post_init__(self) -> None:
        """Lock the array."""
        object.__setattr__(self, "covariance", frozen_array(self.covariance, (None, None), "covariance"))

    @cached_property
    def sigma(self) -> Array:
        """Standard deviations, shape (c,)."""
        return np.sqrt(np.diag(self.covariance))

    @cached_property
    def quantile95(self) -> float:
        """How many standard deviations a 95 % interval reaches to either side."""
        return student95(self.degrees_of_freedom)

    @property
    def warning(self) -> str:
        """What speaks against trusting it; empty where nothing does."""
        if self.by_memory:
            blocks = (
                f"{self.blocks} blocks of at least {self.block_length:.2g} s are" if self.blocks else "blocks are"
            )
            return f"{blocks} too few for a jackknife: intervals go by the memory of the errors; record longer"
        if self.degrees_of_freedom + 1 >= FEW:
            return ""
        return (
            f"robust standard deviations rest on {self.degrees_of_freedom + 1} blocks of at least "
            f"{self.block_length:.2g} s only: record longer"
        )


def jackknife(
    solve: Callable[[T], Array], groups: Sequence[Iterable[T]], values: Array, block_length: float
) -> RobustCovariance:
    """Covariance by solving again without each block, C = (B - 1)/B sum (x_-b - x)(x_-b - x)'.

    Independent groups of blocks (recordings without and with payload that have no motion in common) add up; the
    degrees of freedom are then those of the smaller group, which is on the safe side (Welch).

    Args:
        solve: from a problem to the parameters, the weights fixed at those of ``values``.
        groups: the problems without block 1, 2, ... B of each group.
        values: the parameters x by all data, shape (c,).
        block_length: shortest length of a block [s].

    Raises:
        InputError: if a problem without one block cannot be solved.
    """

    def solved(part: T) -> Array:
        with naming_blocks(block_length):
            return solve(part)

    return jackknifed([np.array([solved(part) for part in group]) for group in groups], values, block_length)


def jackknifed(groups: Sequence[Array], values: Array, block_length: float) -> RobustCovariance:
    """Jackknife from the solutions without block 1, 2, ... B of each group, B x c."""
    covariance = np.zeros((len(values), len(values)))
    for group in groups:
        changes = group - values
        covariance += (1.0 - 1.0 / len(changes)) * changes.T @ changes
    counts = list(map(len, groups))
    return RobustCovariance(covariance, sum(counts), min(counts) - 1, block_length)


@contextmanager
def naming_blocks(block_length: float) -> Iterator[None]:
    """Says of an InputError that it was met without one block of some length [s]."""
    try:
        yield
    except InputError as error:
        raise InputError(
            f"no robust standard deviations: without one block of {block_length:.2g} s, {error}"
        ) from None
