"""Cuts observations into blocks of time that are long against the memory of the residuals."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import least_squares
from ..equations.correlation import autocorrelation_time
from ..equations.observation import Observation
from ..equations.problem import ReducedProblem, merged
from ..equations.reduction import reduced
from .least_squares import joint_weights

_TIMES = 5.0  # autocorrelation times a block holds
_SHORTEST = 1.0  # s
_MERGED = 8  # problems kept apart until they are merged
_MOST = 100  # blocks: more hardly narrow an interval, but each costs a solution


Pieces = Callable[[], Iterable[Observation]]
"""Opens the equations of one recording, in consecutive pieces of time."""


class Residuals(NamedTuple):
    """What a fit leaves of one recording: per joint times [s] and errors [N·m or N], shapes (r_j,)."""

    t: tuple[Array, ...]
    errors: tuple[Array, ...]


def block_length(groups: Sequence[Sequence[Observation]]) -> float:
    """Length of a block [s]: 5 autocorrelation times of the joint that remembers longest, at least 1 s.

    Longer where all recordings together would give more than 100 blocks.

    Args:
        groups: recordings of one load each, which one set of parameters explains.
    """
    return length_by_residuals([_residuals(group) for group in groups])


def length_by_residuals(groups: Sequence[Sequence[Residuals]]) -> float:
    """The same from the residuals of the groups' weighted fits."""
    memory = max(_memory(group) for group in groups)
    duration = max(sum(np.ptp(span(recording)) for recording in group) for group in groups)
    return max(_TIMES * memory, _SHORTEST, duration / _MOST)


def span(recording: Observation | Residuals) -> Array:
    """Times of the first and the last row [s], shape (2,)."""
    t = np.concatenate(recording.t)
    return np.array([t.min(), t.max()]) if t.size else np.zeros(2)


def block_edges(recording: Observation | Residuals, length: float) -> Array:
    """Times between blocks [s] for as many equal blocks of at least ``length`` as fit; infinite at the ends."""
    start, stop = span(recording)
    count = max(1, int((stop - start) / length * (1.0 + 1e-9)))
    edges = np.linspace(start, stop, count + 1)
    edges[[0, -1]] = -np.inf, np.inf
    return edges


def cut(recording: Observation, edges: Array) -> list[ReducedProblem]:
    """The equations between neighbouring edges, reduced."""
    return [reduced(recording.between(*pair)) for pair in pairwise(edges)]


def residuals_of(pieces: Iterable[Observation], values: Array) -> Residuals:
    """What parameters leave of one recording that comes in consecutive pieces of time."""
    parts = [(piece.t, piece.errors(values)) for piece in pieces]
    t, errors = (tuple(map(np.concatenate, zip(*arrays, strict=True))) for arrays in zip(*parts, strict=True))
    return Residuals(t, errors)


def cut_pieces(pieces: Iterable[Observation], edges: Array) -> list[ReducedProblem]:
    """As ``cut``, a piece at a time: most blocks lie in one of them."""
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


def leave_one_out(blocks: Sequence[ReducedProblem]) -> Iterator[ReducedProblem]:
    """For each block all others merged: those before it and those after it are merged once for all.

    Takes 3 B merges instead of B^2.

    Raises:
        InputError: if there is only one block.
    """
    if len(blocks) < 2:
        raise InputError("robust standard deviations need two blocks of time at least: record longer")
    after: list[list[ReducedProblem]] = [[]]
    for block in reversed(blocks[1:]):
        after.append([merged([block, *after[-1]])])
    before: list[ReducedProblem] = []
    for block in blocks:
        yield merged([*before, *after.pop()])
        before = [merged([*before, block])]


def _residuals(group: Sequence[Observation]) -> list[Residuals]:
    """Of the weighted fit to all recordings of one load."""
    values = weighted_solution(merged(reduced(recording) for recording in group))
    return [Residuals(recording.t, recording.errors(values)) for recording in group]


def weighted_solution(problem: ReducedProblem) -> Array:
    """Values of the weighted fit; of dependent columns the shortest ones, which leave the same residuals."""
    factor = problem.stacked()
    weights = joint_weights(problem, least_squares(factor[:, :-1], factor[:, -1]))
    factor = problem.stacked(weights)
    return least_squares(factor[:, :-1], factor[:, -1])


def _memory(group: Sequence[Residuals]) -> float:
    """Longest autocorrelation time among the joints' residuals [s]."""
    times = [t for recording in group for t in recording.t if len(t) > 1]
    step = min((float(np.diff(t).min()) for t in times), default=_SHORTEST)
    joints = range(len(group[0].t))
    return max(autocorrelation_time([(one.t[j], one.errors[j]) for one in group], step) for j in joints)
