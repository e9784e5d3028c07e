"""Rows of a recording that are used, and samples that a logger wrote again: held ones, and where it froze.

Short gaps are interpolated later; at long ones it is split before anything is filtered. Of the pieces, rows are
used where the robot moves, the speed's sign is known and the filter has settled.
"""

import hashlib
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from ...common import Array, Indices, InputError, Mask
from ...model import Motion, Processing, Recording
from .filtering import monotone_cubic, taken

_BRIDGE = 0.3  # s: a pause shorter than this does not end a moving stretch
_STRETCH = 1.0  # s: a moving stretch shorter than this is left out
_SETTLES = 3.0  # periods of the cut-off after which the filter has forgotten that the motion was cut: to 1e-3
_FULL_MOTION = 0.1  # of a joint's largest speed
_MOST_LOST = 0.05  # of a recording, at either end
_PIECE = re.compile(r"( \(\S+ to \S+ s\))+$")  # pattern of the name that ``cut`` gives to a piece of a file
_GAP = 5.0  # median steps
_LOST = 1.5  # median steps: a longer one lacks rows
_SHORTEST = 2.0  # s
_FORGETS = 5.0  # time constants of the filter
_FEWEST = 20  # changes of a column that tell how often it changes
_REGULAR = 0.8  # of the spaces between changes that lie near the usual one
_QUANTUM = 0.5  # of the changes as large as the one before: more are steps of coarse numbers
_FROZEN = 3  # rows, and usual steps of a position after them


def used_rows(motion: Motion, processing: Processing) -> Mask:
    """Mark the rows of a motion that are used, N x n; decimated ones go by the sample in their middle.

    The robot is on its way there, the joint not slow and the filter settled. Where it is in full motion at an end,
    three periods of the cut-off (5 % of the recording at most) are left out: how it goes on the filter cannot know.
    """
    t, speed, inner = motion.t, np.abs(motion.qd), moving_parts(motion, processing.still_speed)
    if processing.cutoff:
        full = np.maximum(_FULL_MOTION * speed.max(axis=0), processing.still_speed)
        seconds = min(_SETTLES / processing.cutoff, _MOST_LOST * float(t[-1] - t[0]))
        first, last = (speed[[0, -1]] > full).any(axis=1)
        inner &= ~(first & (t < t[0] + seconds)) & ~(last & (t > t[-1] - seconds))
    least = least_speed(speed[inner].max(axis=0, initial=0.0), processing)
    return np.asarray((speed >= least) & (speed > 0.0) & inner[:, None])


def least_speed(fastest: Array, processing: Processing) -> Array:
    """Smallest speed of a row that is used, by each joint's largest [rad/s or m/s], shape (n,).

    None is fast enough of a joint that only creeps: friction holds it, and its torque is any within that.
    """
    least = np.maximum(processing.slow_fraction * fastest, processing.slow_speed)
    return np.where(fastest > processing.still_speed, least, np.inf)


def moving_parts(motion: Motion, still_speed: float) -> Mask:
    """Mark the samples at which some joint is faster than ``still_speed`` [rad/s or m/s], shape (N,).

    Pauses under 0.3 s belong to the motion; stretches under 1 s (a jog to the start) do not, if one is longer.
    """
    t, mask = motion.t, np.zeros(len(motion.t), dtype=bool)
    edges = np.flatnonzero(np.diff((np.abs(motion.qd) > still_speed).any(axis=1), prepend=False, append=False))
    starts, stops = edges[::2], edges[1::2]
    if starts.size == 0:
        return mask
    new = t[starts[1:]] - t[stops[:-1] - 1] > _BRIDGE
    starts, stops = starts[np.append(True, new)], stops[np.append(new, True)]
    lasts = t[stops - 1] - t[starts]
    for start, stop, last in zip(starts, stops, lasts, strict=True):
        mask[start:stop] = last >= min(_STRETCH, lasts.max())
    return mask


def shortest_piece(cutoff: float | None) -> float:
    """Shortest piece that is kept [s]: 2 s, or five time constants of the filter of a cut-off [Hz]."""
    return max(_SHORTEST, _FORGETS / (2.0 * math.pi * cutoff) if cutoff else 0.0)


def origin(recording: Recording) -> str:
    """Name the file that a recording, or the whole of which it is a piece, was read from."""
    return _PIECE.sub("", recording.source)


def pieces(t: Array, cutoff: float | None, source: str) -> tuple[list[slice], list[str]]:
    """Split a recording at its gaps, by its times [s]: stretches without one, and what to report of the gaps.

    A gap is longer than five median steps, and than half a period of the cut-off.

    ``cutoff``: of the filter that it will pass [Hz]; None without one.

    Raises:
        InputError: if gaps leave no stretch that is long enough to be filtered.
    """
    steps, typical = np.diff(t), typical_step(t)
    longest = max(_GAP * typical, 0.5 / cutoff if cutoff else 0.0)
    gaps, notes = np.flatnonzero(steps > longest), []
    lacking = steps[(steps > _LOST * typical) & (steps <= longest)].tolist()
    if lacking:
        rows = sum(max(1, round(step / typical) - 1) for step in lacking)
        most = f"{len(lacking)} step{'s' * (len(lacking) > 1)} of up to {max(lacking):.3g} s"
        notes.append(f"{rows} row{'s are' if rows > 1 else ' is'} missing ({most}): interpolated")
    if not len(gaps):
        return [slice(0, len(t))], notes
    least = shortest_piece(cutoff)
    every = [slice(start, stop) for start, stop in pairwise([0, *(gaps + 1).tolist(), len(t)])]
    lasts = [float(t[piece.stop - 1] - t[piece.start]) for piece in every]
    long_enough = [piece for piece, last in zip(every, lasts, strict=True) if last >= least]
    begins, worst = ", ".join(f"{begin:.4g}" for begin in t[gaps[:3]]) + " s", float(steps[gaps].max())
    begins += f" and {len(gaps) - 3} more" * (len(gaps) > 3)
    if not long_enough:
        left = f"gaps after {begins} ({worst:.3g} s at most) leave no {least:.2g} s without one"
        raise InputError(f"{source}: {left}: record without losing rows")
    note = f"split at {len(gaps)} gap{'s' * (len(gaps) > 1)} (after {begins}; {worst:.3g} s at most) into "
    note += f"{len(long_enough)} piece{'s' * (len(long_enough) > 1)}"
    if short := [last for last in lasts if last < least]:
        note += f"; {len(short)} shorter than {least:.2g} s left out ({sum(short):.3g} s)"
    return long_enough, [*notes, note]


def cut(recording: Recording, rows: Sequence[slice], notes: Sequence[str]) -> Iterator[Recording]:
    """Cut a recording into its pieces; a whole one stays as it is."""
    told = (f"{Path(recording.source).name}: {note}" for note in notes)
    recording = replace(recording, notes=(*recording.notes, *told))
    for piece in rows:
        if piece == slice(0, len(recording.t)):
            yield recording
            continue
        part, mark = taken(recording, piece), f"{recording.fingerprint} {piece.start} {piece.stop}".encode()
        yield replace(
            part,
            source=f"{recording.source} ({part.t[0]:.4g} to {part.t[-1]:.4g} s)",
            fingerprint=hashlib.blake2b(mark, digest_size=16).hexdigest() if recording.fingerprint else "",
        )


def typical_step(t: Array) -> float:
    """Median time between rows [s]."""
    return float(np.median(np.diff(t))) if len(t) > 1 else 0.0


def frozen_rows(values: Array, positions: Array) -> Mask:
    """Mark rows that repeat the one before in all columns until a position jumps, shape (N,).

    A robot at rest goes off by small steps; after a freeze the first step is several times those around it.
    """
    frozen = np.zeros(len(values), dtype=bool)
    steps = np.abs(np.diff(positions, axis=0))
    edges = np.flatnonzero(np.diff((values[1:] == values[:-1]).all(axis=1), prepend=False, append=False))
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
    any other held column is interpolated between its own samples.

    ``t``: times [s], shape (N,); ``values``: numbers as they stand in the log, N x k; ``slowest``: marks torques,
    which would count as measured where they are interpolated, shape (k,).

    Returns:
        Rows of the log to a sample of each column, 0 where it is not held; rows that are left; all values there.
    """
    changes = values[1:] != values[:-1]
    periods = np.zeros(values.shape[1])
    for k, column in enumerate(values.T):
        changed = np.flatnonzero(changes[:, k]) + 1
        # Coarse numbers repeat too, but change by one quantum at a time, and a joint at rest changes seldom.
        spaces, jumps = np.diff(changed), np.abs(column[changed] - column[changed - 1])
        usual = float(np.median(spaces)) if len(spaces) >= _FEWEST else 0.0
        near = (spaces >= 0.5 * usual) & (spaces <= 2.0 * usual)
        alike = np.abs(np.diff(jumps)) <= 1e-6 * jumps[1:]
        if usual >= 2.0 and near.mean() >= _REGULAR and alike.mean() <= _QUANTUM:
            periods[k] = spaces[near & (spaces < 1.5 * usual)].mean()
    rows, alive = np.arange(len(t)), periods[slowest][changes[:, slowest].any(axis=0)]
    if alive.all() and len(alive):
        rows = _sampled(changes[:, slowest].any(axis=1), alive.min())
    left = values[rows]
    for held in np.flatnonzero(periods):
        own = _sampled(changes[:, held], periods[held])
        times = np.clip(t[rows], t[own[0]], t[own[-1]])
        left[:, held] = monotone_cubic(t[own], values[own, held])(times)
    return periods, rows, left


def _sampled(changes: Mask, period: float) -> Indices:
    """Rows of the samples: where values change, and between these where a sample equals the one before."""
    changed = np.append(0, np.flatnonzero(changes) + 1)
    number = np.append(0, np.cumsum(np.maximum(1, np.rint(np.diff(changed) / period))))
    return np.asarray(np.rint(np.interp(np.arange(number[-1] + 1), number, changed)), dtype=np.intp)
