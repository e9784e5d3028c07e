"""Blocks of time that are long against the memory of the residuals."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.linear import least_squares
from ..equations.correlation import autocorrelation_time, inflation
from ..equations.equations import Blocks, Equations
from ..equations.observation import Observation
from ..equations.reduction import Recorded, Residuals, reduced
from .least_squares import joint_weights

_TIMES = 5.0  # autocorrelation times a block holds
SHORTEST = 1.0
"""s: no block is shorter."""
FEWEST = 6
"""Blocks as long as memory asks for: with fewer of a payload's recordings the jackknife alone is not trusted."""
_MOST = 100  # blocks: more hardly narrow an interval, but each costs a solution


class Remembered(NamedTuple):
    """How long the recordings of one load remember.

    ``memory``: longest autocorrelation time among the joints' residuals [s]; ``spans``: times of the first and the
    last row of each recording [s], shape (2,); ``inflation``: of each joint's errors, by their memory.
    """

    memory: float
    spans: tuple[Array, ...]
    inflation: tuple[float, ...]


def remembered(recordings: Sequence[Recorded | Observation], equations: Equations) -> Remembered:
    """By what the weighted fit to all recordings of one load leaves; the first columns are the equations'."""
    group = left_over(recordings, equations)
    return Remembered(_memory(group), tuple(map(span, group)), memory_factors(group))


def memory_factors(group: Sequence[Residuals]) -> tuple[float, ...]:
    """By how much the memory of each joint's errors raises variances, from what is left of the recordings."""
    joints = range(len(group[0].t))
    return tuple(inflation([(left.t[j], left.errors[j]) for left in group]) for j in joints)


def length_by_residuals(groups: Sequence[Sequence[Residuals]]) -> float:
    """Length of blocks [s] by what the weighted fit to the recordings of one load leaves of each."""
    return block_length([Remembered(_memory(group), tuple(map(span, group)), ()) for group in groups])


def block_length(loads: Sequence[Remembered]) -> float:
    """Length of a block [s]: 5 autocorrelation times of the joint that remembers longest, at least 1 s.

    Longer where all recordings of one load together would give more than 100 blocks.
    """
    duration = max(sum(float(np.ptp(ends)) for ends in load.spans) for load in loads)
    return max(_TIMES * max(load.memory for load in loads), SHORTEST, duration / _MOST)


def span(recording: Observation | Residuals) -> Array:
    """Times of the first and the last row [s], shape (2,)."""
    t = np.concatenate(recording.t)
    return np.array([t.min(), t.max()]) if t.size else np.zeros(2)


def block_edges(recording: Observation | Residuals | Array, length: float) -> Array:
    """Times between blocks [s] for as many equal blocks of at least ``length`` as fit; infinite at the ends.

    Args:
        recording: what is cut, or the times of its first and last row.
        length: [s].
    """
    start, stop = recording if isinstance(recording, np.ndarray) else span(recording)
    count = max(1, int((stop - start) / length * (1.0 + 1e-9)))
    edges = np.linspace(start, stop, count + 1)
    edges[[0, -1]] = -np.inf, np.inf
    return edges


def left_over(recordings: Sequence[Recorded | Observation], equations: Equations) -> list[Residuals]:
    """What the weighted fit to all recordings of one load leaves of each; the first columns are the equations'."""
    values = weighted_solution(equations)
    return [
        held.residuals(values) if isinstance(held, Recorded) else Residuals(held.t, held.errors(values))
        for held in recordings
    ]


def in_blocks(
    equations: Equations, recordings: Sequence[Recorded | Observation], edges: Sequence[Array], length: float
) -> Equations:
    """Equations with blocks of time between their recordings' edges."""
    blocks: list[Equations] = []
    for held, ends in zip(recordings, edges, strict=True):
        if isinstance(held, Recorded):
            blocks += held.cut(ends)
        else:
            blocks += [reduced(held.between(*between)) for between in pairwise(ends)]
    return replace(equations, blocks=Blocks.of(blocks, length))


def weighted_solution(equations: Equations) -> Array:
    """Values of the weighted fit; of dependent columns the shortest ones."""
    factor = equations.stacked()
    factor = equations.stacked(joint_weights(equations, least_squares(factor[:, :-1], factor[:, -1])))
    return least_squares(factor[:, :-1], factor[:, -1])


def _memory(group: Sequence[Residuals]) -> float:
    """Longest autocorrelation time among the joints' residuals [s]."""
    times = [t for recording in group for t in recording.t if len(t) > 1]
    step = min((float(np.diff(t).min()) for t in times), default=SHORTEST)
    joints = range(len(group[0].t))
    return max(
        autocorrelation_time([(recording.t[j], recording.errors[j]) for recording in group], step) for j in joints
    )
