"""Pairs of recordings of which only one has gaps: both are cut at the gaps of either, so that pieces form pairs."""

from collections.abc import Sequence
from itertools import groupby, pairwise, product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...common.errors import InputError
from ...model import Processing, Recording
from ..signals.alignment import aligned
from ..signals.filtering import grid_rate
from ..signals.rows import Pieces, cut, origin, shortest_piece

_TRIED = 12
"""Combinations of pieces that are aligned in search of the lag."""
_Recordings = tuple[Recording, ...]


class Alike(NamedTuple):
    """Recordings with and without payload, and the lag of each pair [s] where it is known."""

    loaded: _Recordings
    unloaded: _Recordings
    lags: tuple[float | None, ...]


def cut_alike(loaded: Sequence[Recording], unloaded: Sequence[Recording], processing: Processing) -> Alike:
    """Recordings with and without payload, cut alike where gaps split those of one file into more pieces.

    They stay as they are where they form pairs already, or where no pairs can be made of them.

    Args:
        loaded: with payload, pieces of one file one after the other.
        unloaded: without; the k-th file is of the same trajectory as the k-th of ``loaded``.
    """
    whole = Alike(tuple(loaded), tuple(unloaded), (None,) * len(loaded))
    heavy, bare = _by_file(loaded), _by_file(unloaded)
    if len(loaded) == len(unloaded) or len(heavy) != len(bare):
        return whole
    try:
        pairs = [pair for a, b in zip(bare, heavy, strict=True) for pair in _pairs(a, b, processing)]
    except InputError:  # no pair of one trajectory: method 3 refuses it where it is asked for
        return whole
    bare_pieces, heavy_pieces, lags = zip(*pairs, strict=True) if pairs else ((), (), ())
    return Alike(heavy_pieces, bare_pieces, lags) if pairs else whole


def _by_file(recordings: Sequence[Recording]) -> list[_Recordings]:
    return [tuple(pieces) for _, pieces in groupby(recordings, origin)]


def _pairs(
    bare: _Recordings, heavy: _Recordings, processing: Processing
) -> list[tuple[Recording, Recording, float | None]]:
    """Pieces of two files between the gaps of either, on the same stretches of the motion, and their lag."""
    if len(bare) == len(heavy) == 1:
        return [(bare[0], heavy[0], None)]
    lag = _lag(bare, heavy, processing)
    gaps = sorted([*_gaps(heavy), *(gap + lag for gap in _gaps(bare))])
    least = shortest_piece(processing.cutoff)
    pairs: list[tuple[Recording, Recording, float | None]] = []
    for low, high in pairwise([-np.inf, *gaps, np.inf]):
        a = _within(bare, low - lag, high - lag, least, heavy[0])
        b = _within(heavy, low, high, least, bare[0])
        if a is not None and b is not None:
            pairs.append((a, b, lag))
    return pairs


def _lag(bare: _Recordings, heavy: _Recordings, processing: Processing) -> float:
    """What the loaded file's clock shows more [s], by pieces of both that are alike, the longest first.

    Raises:
        InputError: if no two are of the same stretch of the motion.
    """
    choices = sorted(product(bare, heavy), key=lambda pair: -min(map(_lasts, pair)))
    for first, second in choices[:_TRIED]:
        try:
            return aligned(first, second, grid_rate(second, processing), processing.max_mismatch).lag
        except InputError:
            continue
    raise InputError(f"{origin(bare[0])} and {origin(heavy[0])} are not the same trajectory")


def _gaps(pieces: _Recordings) -> list[float]:
    """Middles of the gaps between pieces [s]."""
    return [0.5 * float(before.t[-1] + after.t[0]) for before, after in pairwise(pieces)]


def _within(pieces: _Recordings, low: float, high: float, least: float, partner: Recording) -> Recording | None:
    """What of a file lies between two times [s] and is long enough; ``partner``: of the other file, for a note."""
    for piece in pieces:
        rows = slice(*(int(row) for row in np.searchsorted(piece.t, [low, high])))
        if rows.stop - rows.start > 1 and piece.t[rows.stop - 1] - piece.t[rows.start] >= least:
            note = f"cut where {Path(origin(partner)).name} lacks rows, so that method 3 compares what both have"
            shorter = rows != slice(0, len(piece.t))
            return next(cut(piece, Pieces((rows,), (note,) if shorter else ())))
    return None


def _lasts(recording: Recording) -> float:
    return float(recording.t[-1] - recording.t[0])
