"""Rules for variances, by name: what is known of the errors decides which of them holds.

``formula``: (17)-(19), for white errors. ``jackknife``: whatever their memory, if shorter than a block of time, of
which each is left out in turn. ``sandwich``: by how much each joint's errors remember, for too few blocks.
``birge`` comes on top, where results scatter by more than their own standard deviations say.
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from scipy.special import stdtrit

from ...common import Array, Brief, InputError, freeze_fields

Rule = Literal["formula", "jackknife", "sandwich"]
FEW = 10  # number of blocks below which the intervals are wide and uncertain themselves


def student95(degrees_of_freedom: float) -> float:
    """Half width of a 95 % interval in standard deviations, by Student's t."""
    return float(stdtrit(max(degrees_of_freedom, 1.0), 0.975))


NORMAL95 = student95(1e9)
"""Half width of a 95 % interval in standard deviations, of a normal number whose deviation is known."""


def few_blocks(degrees_of_freedom: float) -> float:
    """Ratio of a 95 % interval from few blocks to one from many, standard deviations being equal."""
    return student95(degrees_of_freedom) / NORMAL95


@dataclass(frozen=True, eq=False, repr=False)
class RobustCovariance(Brief):
    """Covariance of the estimation error whatever the memory of the noise, if shorter than a block."""

    covariance: Array  # c x c
    blocks: int  # number of blocks that were left out in turn
    degrees_of_freedom: int  # of Student's t for intervals
    block_length: float  # shortest length of a block [s], unless a whole recording is shorter; 0 for poses at rest
    by_memory: bool = False  # whether it is the sandwich, blocks being too few for a jackknife

    def __post_init__(self) -> None:
        freeze_fields(self, covariance=(None, None))

    @cached_property
    def sigma(self) -> Array:
        """Standard deviations, shape (c,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def warning(self) -> str:
        """Reason against trusting it; empty where there is none."""
        length = f"{self.block_length:.2g} s"
        if self.by_memory:
            blocks = f"{self.blocks} blocks of at least {length}" if self.blocks else "blocks"
            return (
                f"{blocks} are too few for a jackknife; the errors' autocorrelation is used instead: record longer"
            )
        if self.degrees_of_freedom + 1 >= FEW or not self.block_length:
            return ""
        blocks = f"{self.degrees_of_freedom + 1} blocks of at least {length}"
        return f"the robust standard deviations rest on only {blocks}: record longer"


def formula(root: Array, squares: float, degrees_of_freedom: float) -> Array:
    """Covariance s^2 (W'W)^-1 of (17)-(19), s^2 the squares of the weighted errors over their degrees of freedom.

    ``root``: R^-1 of the weighted equations, c x c.
    """
    return np.asarray(squares / degrees_of_freedom * root @ root.T)


def jackknife(groups: Sequence[Iterable[Array]], values: Array, block_length: float) -> RobustCovariance:
    """Covariance (B - 1)/B sum (x_-b - x)(x_-b - x)', by solving again without each block b.

    Of whole blocks, so that errors may remember (Künsch, The jackknife and the bootstrap for general stationary
    observations, 1989). Independent groups of blocks (recordings without and with payload that have no motion in
    common) add up; the degrees of freedom are then those of the smaller group, which is on the safe side (Welch).

    ``groups``: solutions without block 1, 2, ... B of each, weights fixed at those of x = ``values`` by all data.
    """
    covariance, counts = np.zeros((len(values), len(values))), []
    for group in groups:
        changes = np.array(list(group)) - values
        covariance += (1.0 - 1.0 / len(changes)) * changes.T @ changes
        counts.append(len(changes))
    return RobustCovariance(covariance, sum(counts), min(counts) - 1, block_length)


def sandwich(inverse: Array, scores: Array) -> Array:
    """Covariance (W'W)^-1 S'S (W'W)^-1, S the weighted rows of W times the size of their errors (White 1980)."""
    moved = inverse @ scores.T
    return np.asarray(moved @ moved.T)


def birge(values: Array, sigmas: Array) -> float:
    """Birge ratio: by how much values of one quantity scatter more than their sigmas say, at least 1.

    The square root of chi2 per degree of freedom about the weighted mean (Birge, The calculation of errors by the
    method of least squares, 1932).
    """
    if len(values) < 2:
        return 1.0
    weights = 1.0 / sigmas**2
    mean = float(weights @ values / weights.sum())
    return max(1.0, float(np.sqrt(weights @ (values - mean) ** 2 / (len(values) - 1))))


@contextmanager
def naming_blocks(block_length: float) -> Iterator[None]:
    """Name the length of the left-out block [s] in an InputError."""
    try:
        yield
    except InputError as error:
        raise InputError(
            f"no robust standard deviations: without one block of {block_length:.2g} s, {error}"
        ) from None
