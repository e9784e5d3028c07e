"""Samples that a logger wrote again: those of a slower signal, held, and those of moments in which it froze."""

import numpy as np

from ...common import Array, Indices, Mask
from .filtering import MonotoneCubic

_FEWEST = 20  # changes of a column that tell how often it changes
_REGULAR = 0.8  # of the spaces between changes that lie near the usual one
_QUANTUM = 0.5  # of the changes as large as the one before: more are steps of coarse numbers
_FROZEN = 3  # rows, and usual steps of a position after them


def frozen_rows(values: Array, positions: Array) -> Mask:
    """Mark rows that repeat the one before in all columns until a position jumps, shape (N,).

    A robot at rest goes off by small steps; after a freeze the first step is several times those around it.
    """
    frozen = np.zeros(len(values), dtype=bool)
    steps = np.abs(np.diff(positions, axis=0))
    edges = np.flatnonzero(np.diff(np.concatenate([[False], (values[1:] == values[:-1]).all(axis=1), [False]])))
    lengths = edges[1::2] - edges[::2]
    least = _FROZEN * (1.0 + np.median(lengths) if len(lengths) >= _FEWEST else 1.0)  # held samples repeat too
    for first, last, length in zip(edges[::2], edges[1::2], lengths, strict=True):
        if length < least or last == len(steps):
            continue
        before, after = steps[max(0, first - 2 * length) : first], steps[last + 1 : last + 1 + 2 * length]
        usual = [np.median(own[own > 0.0]) if own.any() else np.inf for own in np.vstack([before, after]).T]
        if (steps[last] > _FROZEN * np.array(usual)).any():
            frozen[first + 1 : last + 1] = True
    return frozen


def without_held(t: Array, values: Array, slowest: Mask) -> tuple[Array, Indices, Array]:
    """Take columns that are held between the samples of a slower signal at these alone.

    Rows are left at which one of the columns ``slowest`` changes, where all of these are held; else all rows. There
    any other held column is interpolated between its own samples. These are the torques': interpolated ones would
    count as measured.

    ``t``: times [s], shape (N,); ``values``: numbers as they stand in the log, N x k; ``slowest``: shape (k,).

    Returns:
        Rows of the log to a sample of each column, 0 where it is not held; rows that are left; all values there.
    """
    changes = values[1:] != values[:-1]
    periods = np.array([_period(values[:, k], np.flatnonzero(changes[:, k]) + 1) for k in range(values.shape[1])])
    rows, alive = np.arange(len(t)), periods[slowest][changes[:, slowest].any(axis=0)]
    if alive.all() and len(alive):
        rows = _sampled(changes[:, slowest].any(axis=1), alive.min())
    left = values[rows]
    for k in np.flatnonzero(periods):
        own = _sampled(changes[:, k], periods[k])
        times = np.clip(t[rows], t[own[0]], t[own[-1]])
        left[:, k] = MonotoneCubic(t[own], values[own, k : k + 1])(times)[:, 0]
    return periods, rows, left


def _period(column: Array, changed: Indices) -> float:
    """Rows from one sample to the next of a column that is held; 0 of another one."""
    # Coarse numbers repeat too, but change by one quantum at a time, and a joint at rest changes seldom.
    spaces, jumps = np.diff(changed), np.abs(column[changed] - column[changed - 1])
    usual = float(np.median(spaces)) if len(spaces) >= _FEWEST else 0.0
    near = (spaces >= 0.5 * usual) & (spaces <= 2.0 * usual)
    alike = np.abs(np.diff(jumps)) <= 1e-6 * jumps[1:]
    if usual < 2.0 or near.mean() < _REGULAR or alike.mean() > _QUANTUM:
        return 0.0
    return float(spaces[near & (spaces < 1.5 * usual)].mean())


def _sampled(changes: Mask, period: float) -> Indices:
    """Rows of the samples: where values change, and between these where a sample equals the one before."""
    changed = np.append(0, np.flatnonzero(changes) + 1)
    number = np.append(0, np.cumsum(np.maximum(1, np.rint(np.diff(changed) / period))))
    return np.asarray(np.rint(np.interp(np.arange(number[-1] + 1), number, changed)), dtype=np.intp)
