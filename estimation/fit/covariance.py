"""Rules for variances, by name, the memory of residuals, and blocks of time that are long against it.

"formula": (17)-(19), for white errors. "jackknife": whatever their memory, if shorter than a block of time, of
which each is left out in turn. "sandwich": by how much each joint's errors remember, for too few blocks. ``birge``
comes on top, where results scatter by more than their own standard deviations say.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import stdtrit

from ...common import Array, Brief, decomposed, freeze_fields
from ..equations.equations import Equations, surely_determined
from ..equations.observer import Observation, reduced

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
        count = self.blocks if self.by_memory else self.degrees_of_freedom + 1
        blocks = f"{count} blocks of at least {self.block_length:.2g} s" if count else "blocks"
        if self.by_memory:
            instead = "the errors' autocorrelation is used instead: record longer"
            return f"{blocks} are too few for a jackknife; {instead}"
        if count >= FEW or not self.block_length:
            return ""
        return f"the robust standard deviations rest on only {blocks}: record longer"


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


_WINDOW = 5.0  # lags summed, in autocorrelation times
_TIMES = 5.0  # autocorrelation times a block holds
SHORTEST = 1.0  # shortest block [s]
FEWEST = 6  # number of blocks below which the jackknife of a payload's recordings alone is not trusted
_MOST = 100  # blocks: more hardly narrow an interval, but each costs a solution


def autocorrelation(series: Sequence[tuple[Array, Array]], step: float) -> Array:
    """Autocorrelation rho_0 = 1, rho_1, ... at all lags of the longest of some series; 0 without power.

    Rows that were left out form no pairs; each rho_k divides by the number of pairs that are there.

    ``series``: times on a grid of ``step`` [s] and values, (r,) each; recordings of one process.
    """
    series = [(t, values) for t, values in series if len(t)]
    indices = [np.rint((t - t[0]) / step).astype(int) for t, _ in series]
    size = max((int(index[-1]) + 1 for index in indices), default=1)
    # Zeros where rows are missing, ones where they are not; as many zeros again, so that the ends do not meet.
    power = np.zeros((2, size + 1))
    for index, (_, values) in zip(indices, series, strict=True):
        grid = np.zeros((2, 2 * size))
        grid[:, index] = values, np.ones(len(values))
        power += np.abs(np.fft.rfft(grid)) ** 2
    products, pairs = np.fft.irfft(power)[:, :size]
    means = products / np.maximum(np.rint(pairs), 1.0)
    return np.asarray(means / means[0] if means[0] > 0.0 else np.eye(1, size)[0])


def autocorrelation_time(series: Sequence[tuple[Array, Array]], step: float) -> float:
    """Integrated autocorrelation time tau = step (1/2 + rho_1 + ... + rho_M) [s], at least step / 2.

    The window is Sokal's, consistent with itself: the smallest M with M step >= 5 tau (Sokal, Monte Carlo methods
    in statistical mechanics, 1997, section 3). White noise has step / 2; noise that forgets as exp(-t / T), T.

    ``series``, ``step``: as of ``autocorrelation``.
    """
    rho = autocorrelation(series, step)
    taus = np.cumsum(np.append(0.5, rho[1 : len(rho) // 2]))
    ends = np.flatnonzero(np.arange(len(taus)) >= _WINDOW * taus)
    return step * max(float(taus[ends[0] if ends.size else -1]), 0.5)


def inflation(series: Sequence[tuple[Array, Array]]) -> float:
    """Factor by which the memory of errors raises the variance of their mean, 1 + 2 (rho_1 + ...), at least 1."""
    there = [(t, values) for t, values in series if len(t) > 1]
    if not there:
        return 1.0
    step = min(float(np.diff(t).min()) for t, _ in there)
    return max(1.0, 2.0 * autocorrelation_time(there, step) / step)


def remembered(recordings: Sequence[Observation], by: Equations | Array) -> tuple[float, tuple[float, ...]]:
    """Measure the memory of what values of the first columns, or the weighted fit, leave of one load's recordings.

    Gives the length of a block [s], the longest of 5 autocorrelation times of a joint, 1 s, and a hundredth of the
    recordings; and the inflation of each joint's errors.
    """
    values = weighted_solution(by) if isinstance(by, Equations) else by
    each = [zip(recording.t, recording.errors(values), strict=True) for recording in recordings]
    by_joint = list(zip(*each, strict=True))
    step = min((float(np.diff(t).min()) for own in by_joint for t, _ in own if len(t) > 1), default=SHORTEST)
    memory = max(autocorrelation_time(series, step) for series in by_joint)
    duration = sum(float(np.ptp(span(recording))) for recording in recordings)
    return max(_TIMES * memory, SHORTEST, duration / _MOST), tuple(map(inflation, by_joint))


def span(recording: Observation) -> Array:
    """Times of the first and the last row [s], shape (2,)."""
    t = np.concatenate(recording.t)
    return np.array([t.min(), t.max()]) if t.size else np.zeros(2)


def block_edges(recording: Observation, length: float) -> Array:
    """Times between as many equal blocks of at least ``length`` [s] as fit; infinite at the ends."""
    start, stop = span(recording)
    count = max(1, int((stop - start) / length * (1.0 + 1e-9)))
    edges = np.linspace(start, stop, count + 1)
    edges[[0, -1]] = -np.inf, np.inf
    return edges


def in_blocks(
    equations: Equations, recordings: Sequence[Observation], length: float, edges: Sequence[Array] | None = None
) -> Equations:
    """Add blocks of time of at least ``length`` [s] to equations, between the recordings' edges if given."""
    pairs = zip(recordings, edges or [block_edges(one, length) for one in recordings], strict=True)
    blocks = (reduced(recording.between(*between)) for recording, ends in pairs for between in pairwise(ends))
    return replace(equations, blocks=tuple(replace(block, shared={}) for block in blocks), block_length=length)


def weighted_solution(equations: Equations) -> Array:
    """Solve the weighted fit; of dependent columns the shortest solution."""

    def solved(factor: Array) -> Array:
        c = factor.shape[1] - 1
        if surely_determined(factor[:, :c]):
            return np.asarray(solve_triangular(factor[:c, :c], factor[:c, c]))
        return decomposed(factor[:, :c]).solution(factor[:, c])

    return solved(equations.stacked(equations.joint_weights(solved(equations.stacked()))))
