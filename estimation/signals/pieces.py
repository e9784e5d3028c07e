"""Gaps of a recording: short ones are interpolated later, at long ones it is split before anything is filtered."""

import hashlib
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Recording

_PIECE = re.compile(r"( \(\S+ to \S+ s\))+$")
"""How ``cut`` names a piece of a file."""
_GAP = 5.0  # median steps
_LOST = 1.5  # median steps: a longer one lacks rows
_SHORTEST = 2.0  # s
_SETTLES = 5.0  # time constants of the filter


class Pieces(NamedTuple):
    """The stretches of a recording that have no gap, as rows, and what to tell of the gaps."""

    rows: tuple[slice, ...]
    notes: tuple[str, ...]


def longest_step(t: Array, cutoff: float | None) -> float:
    """Longest time between rows [s] that is no gap: five median steps, or half a period of the cut-off [Hz]."""
    return max(_GAP * typical_step(t), 0.5 / cutoff if cutoff else 0.0)


def shortest_piece(cutoff: float | None) -> float:
    """Shortest piece that is kept [s]: 2 s, or five time constants of the filter of a cut-off [Hz]."""
    return max(_SHORTEST, _SETTLES / (2.0 * math.pi * cutoff) if cutoff else 0.0)


def origin(recording: Recording) -> str:
    """The file that a recording, or the whole of which it is a piece, was read from."""
    return _PIECE.sub("", recording.source)


def pieces(t: Array, cutoff: float | None, source: str) -> Pieces:
    """Where a recording is split, by its times.

    Args:
        t: times [s], rising, shape (N,).
        cutoff: of the filter that it will pass [Hz]; None without one.
        source: for messages.

    Raises:
        InputError: if gaps leave no stretch that is long enough to be filtered.
    """
    longest, typical = longest_step(t, cutoff), typical_step(t)
    ends, missing, steps = _long_steps(t, longest, _LOST * typical)
    notes = []
    if steps:
        rows = sum(max(1, round(step / typical) - 1) for step in steps)
        notes.append(
            f"{rows} row{'s are' if rows > 1 else ' is'} missing ({len(steps)} step{'s' * (len(steps) > 1)} of up "
            f"to {max(steps):.3g} s): interpolated"
        )
    if not ends:
        return Pieces((slice(0, len(t)),), tuple(notes))
    least = shortest_piece(cutoff)
    edges = [0, *(end + 1 for end in ends), len(t)]
    every = [slice(start, stop) for start, stop in pairwise(edges)]
    long_enough = tuple(piece for piece in every if t[piece.stop - 1] - t[piece.start] >= least)
    begins = [float(t[end]) for end in ends]
    if not long_enough:
        raise InputError(
            f"{source}: gaps after {listed_seconds(begins)} ({max(missing):.3g} s at most) leave no {least:.2g} s "
            "without one: record without losing rows"
        )
    note = f"split at {len(ends)} gap{'s' * (len(ends) > 1)} (after {listed_seconds(begins)}; "
    note += f"{max(missing):.3g} s at most)"
    note += f" into {len(long_enough)} piece{'s' * (len(long_enough) > 1)}"
    short = len(every) - len(long_enough)
    if short:
        lost = sum(_lasts(t, every)) - sum(_lasts(t, long_enough))
        note += f"; {short} shorter than {least:.2g} s left out ({lost:.3g} s)"
    return Pieces(long_enough, (*notes, note))


def cut(recording: Recording, stretches: Pieces) -> Iterator[Recording]:
    """The pieces of a recording; a whole one as it is."""
    notes = (f"{Path(recording.source).name}: {note}" for note in stretches.notes)
    recording = replace(recording, notes=(*recording.notes, *notes))
    for piece in stretches.rows:
        if piece == slice(0, len(recording.t)):
            yield recording
            continue
        t = recording.t[piece]
        mark = f"{recording.fingerprint} {piece.start} {piece.stop}".encode()
        yield replace(
            recording,
            t=t,
            q=recording.q[piece],
            torque=recording.torque[piece],
            qd=None if recording.qd is None else recording.qd[piece],
            source=f"{recording.source} ({t[0]:.4g} to {t[-1]:.4g} s)",
            fingerprint=hashlib.blake2b(mark, digest_size=16).hexdigest() if recording.fingerprint else "",
        )


def _long_steps(t: Array, longest: float, lost: float) -> tuple[list[int], list[float], list[float]]:
    """Rows before gaps, how long these are [s], and the shorter steps in which rows are missing [s]."""
    steps = np.diff(t)
    gaps = np.flatnonzero(steps > longest)
    return gaps.tolist(), steps[gaps].tolist(), steps[(steps > lost) & (steps <= longest)].tolist()


def _lasts(t: Array, rows: tuple[slice, ...] | list[slice]) -> list[float]:
    return [float(t[piece.stop - 1] - t[piece.start]) for piece in rows]


def typical_step(t: Array) -> float:
    """Median time between rows [s]; of a long log that of a million rows all over it."""
    thin = max(1, len(t) // 1_000_000)
    return float(np.median(t[1::thin] - t[:-1:thin])) if len(t) > 1 else 0.0


def listed_seconds(values: Sequence[float]) -> str:
    """Some of many times, for a message."""
    first = ", ".join(f"{value:.4g}" for value in values[:3])
    return f"{first} s" if len(values) <= 3 else f"{first} s and {len(values) - 3} more"
