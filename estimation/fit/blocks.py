"""Memory of residuals, and blocks of time that are long against it."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...common import Array, decomposed
from ..equations.equations import Equations
from ..equations.observer import Observation, reduced

_WINDOW = 5.0  # lags summed, in autocorrelation times
_TIMES = 5.0  # autocorrelation times a block holds
SHORTEST = 1.0  # shortest block [s]
FEWEST = 6  # number of blocks below which the jackknife of a payload's recordings alone is not trusted
_MOST = 100  # blocks: more hardly narrow an interval, but each costs a solution


def autocorrelation_time(series: Sequence[tuple[Array, Array]], step: float) -> float:
    """Integrated autocorrelation time tau = step (1/2 + rho_1 + ... + rho_M) [s], at least step / 2.

    The window is Sokal's, consistent with itself: the smallest M with M step >= 5 tau (Sokal, Monte Carlo methods
    in statistical mechanics, 1997, section 3). White noise has step / 2; noise that forgets as exp(-t / T), T.
    Rows that were left out form no pairs; each rho_k divides by the number of pairs that are there.

    ``series``: times on a grid of ``step`` [s] and residuals, (r,) each; recordings of one process.
    """
    grids = [_on_grid(t, values, step) for t, values in series if len(t)]
    power = _mean_product(grids, 0)
    if power == 0.0:
        return 0.5 * step
    tau, lag = 0.5, 0
    while lag < _WINDOW * tau and lag + 1 < max(values.size for values, _ in grids) // 2:
        lag += 1
        tau += _mean_product(grids, lag) / power
    return step * max(tau, 0.5)


def inflation(series: Sequence[tuple[Array, Array]]) -> float:
    """Factor by which the memory of errors raises the variance of their mean, 1 + 2 (rho_1 + ...), at least 1."""
    there = [(t, values) for t, values in series if len(t) > 1]
    if not there:
        return 1.0
    step = min(float(np.diff(t).min()) for t, _ in there)
    return max(1.0, 2.0 * autocorrelation_time(there, step) / step)


def autocorrelation(t: Array, values: Array, step: float, lags: int) -> Array:
    """Autocorrelation rho_0 = 1, rho_1 ... rho_lags of one series, shape (lags + 1,); 0 without power."""
    grids = [_on_grid(t, values, step)] if len(t) else []
    power = _mean_product(grids, 0)
    products = [_mean_product(grids, lag) for lag in range(lags + 1)]
    return np.array(products) / power if power else np.eye(1, lags + 1)[0]


def _on_grid(t: Array, values: Array, step: float) -> tuple[Array, Array]:
    """Put values on an even grid: zeros where rows are missing, and ones where they are not."""
    index = np.rint((t - t[0]) / step).astype(int)
    dense, there = np.zeros((2, index[-1] + 1))
    dense[index], there[index] = values, 1.0
    return dense, there


def _mean_product(grids: Sequence[tuple[Array, Array]], lag: int) -> float:
    """Mean of e(t) e(t + lag) over all pairs that are there; 0 without any."""
    total, pairs = 0.0, 0.0
    for values, there in grids:
        size = max(values.size - lag, 0)
        total += float(values[:size] @ values[lag:])
        pairs += float(there[:size] @ there[lag:])
    return total / pairs if pairs else 0.0


class Remembered(NamedTuple):
    """Memory of the recordings of one load."""

    memory: float  # longest autocorrelation time among the joints' residuals [s]
    spans: tuple[Array, ...]  # times of the first and the last row of each recording [s], shape (2,)
    inflation: tuple[float, ...]  # of each joint's errors, by their memory

    @staticmethod
    def of(recordings: Sequence[Observation], values: Array) -> "Remembered":
        """Measure the memory of what values of the first columns leave of the recordings."""
        each = [zip(recording.t, recording.errors(values), strict=True) for recording in recordings]
        by_joint = list(zip(*each, strict=True))
        times = [t for series in by_joint for t, _ in series if len(t) > 1]
        step = min((float(np.diff(t).min()) for t in times), default=SHORTEST)
        memory = max(autocorrelation_time(series, step) for series in by_joint)
        return Remembered(memory, tuple(map(span, recordings)), tuple(map(inflation, by_joint)))


def remembered(recordings: Sequence[Observation], equations: Equations) -> Remembered:
    """Measure the memory of what the weighted fit to all recordings of one load leaves."""
    return Remembered.of(recordings, weighted_solution(equations))


def block_length(loads: Sequence[Remembered]) -> float:
    """Length of a block [s]: the longest of 5 autocorrelation times of a joint, 1 s, and a hundredth of a load."""
    duration = max(sum(float(np.ptp(ends)) for ends in load.spans) for load in loads)
    return max(_TIMES * max(load.memory for load in loads), SHORTEST, duration / _MOST)


def span(recording: Observation) -> Array:
    """Times of the first and the last row [s], shape (2,)."""
    t = np.concatenate(recording.t)
    return np.array([t.min(), t.max()]) if t.size else np.zeros(2)


def block_edges(recording: Observation | Array, length: float) -> Array:
    """Times between as many equal blocks of at least ``length`` [s] as fit; infinite at the ends.

    ``recording``: what is cut, or the times of its first and last row.
    """
    start, stop = recording if isinstance(recording, np.ndarray) else span(recording)
    count = max(1, int((stop - start) / length * (1.0 + 1e-9)))
    edges = np.linspace(start, stop, count + 1)
    edges[[0, -1]] = -np.inf, np.inf
    return edges


def in_blocks(
    equations: Equations, recordings: Sequence[Observation], edges: Sequence[Array], length: float
) -> Equations:
    """Add blocks of time to equations, between their recordings' edges."""
    pairs = zip(recordings, edges, strict=True)
    blocks = (reduced(recording.between(*between)) for recording, ends in pairs for between in pairwise(ends))
    return replace(equations, blocks=tuple(replace(block, shared={}) for block in blocks), block_length=length)


def weighted_solution(equations: Equations) -> Array:
    """Solve the weighted fit; of dependent columns the shortest solution."""
    factor = equations.stacked()
    factor = equations.stacked(equations.joint_weights(decomposed(factor[:, :-1]).solution(factor[:, -1])))
    return decomposed(factor[:, :-1]).solution(factor[:, -1])
