"""Reduces a log that no memory holds: filtered piece by piece, so that nothing differs from the log held whole.

A piece is filtered with margins in which the zero-phase filter forgets where it was cut. Which rows are used
depends on the whole log (when the robot moves, each joint's largest speed): it is read three times.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Motion, Processing, Recording
from ...model.motion import Measurement
from ..recordings.recording import Samples
from ..signals.filtering import measurement, on_grid
from ..signals.rows import Mask, UsedRows, cut_ends, fastest, used_samples
from .observation import Observer
from .problem import ReducedProblem
from .reduction import reduced_pieces

_PIECE = 60.0  # s
_FORGETS = 10.0  # periods of the cut-off: the filter's transient falls below 1e-9 of what was cut
_MARGIN = 1.0  # s, at least


class _Piece(NamedTuple):
    """``data``: measurement of a piece, margins cut off; ``start``: its first sample's number on the even grid."""

    data: Measurement
    start: int


def reduced_log(
    observer: Observer, blocks: Callable[[], Iterable[Samples]], processing: Processing, source: str = "log"
) -> ReducedProblem:
    """Reduce one log that arrives in blocks.

    Args:
        observer: whose columns.
        blocks: opens the log anew and gives its blocks, as ``stream_samples`` does; called three times.
        processing: settings. A rate is needed unless the log's time is even.
        source: for messages.

    Raises:
        InputError: if the log's time is uneven and no rate is given, or it is too short.
    """
    rows = _overview(blocks, processing, source)

    def pieces() -> Iterator[tuple[Measurement, Mask]]:
        for piece in _pieces(blocks(), processing, source):
            here = slice(piece.start, piece.start + len(piece.data.motion.t))
            yield piece.data, rows.of(piece.data.motion.qd, here)

    return reduced_pieces(observer, pieces(), processing.decimate)


def _overview(blocks: Callable[[], Iterable[Samples]], processing: Processing, source: str) -> UsedRows:
    times, on_its_way, ends, largest = [], [], [], []
    for piece in _pieces(blocks(), processing, source):
        times.append(piece.data.motion.t)
        on_its_way.append((np.abs(piece.data.motion.qd) > processing.still_speed).any(axis=1))
        ends.append(piece.data.motion.qd[[0, -1]])
        largest.append(np.abs(piece.data.motion.qd).max(axis=0))
    if not times:
        raise InputError(f"{source}: no rows of numbers")
    cut = cut_ends(np.array([ends[0][0], ends[-1][1]]), np.max(largest, axis=0), processing)
    moving = used_samples(np.concatenate(times), np.concatenate(on_its_way), cut, processing)
    speeds = [
        fastest(piece.data.motion.qd, moving[piece.start : piece.start + len(piece.data.motion.t)])
        for piece in _pieces(blocks(), processing, source)
    ]
    return UsedRows(moving, np.max(speeds, axis=0), processing.slow_fraction)


def _pieces(blocks: Iterable[Samples], processing: Processing, source: str) -> Iterator[_Piece]:
    """Filtered pieces on one even grid, one after the other."""
    cutter: _Cutter | None = None
    for block, last in _with_last(blocks):
        if cutter is None:
            cutter = _Cutter(float(block.t[0]), _step(block.t, processing.rate, source), processing, source)
        yield from cutter.pieces(block, last)


class _Cutter:
    """Cuts blocks into pieces with margins, filters them and takes the margins off."""

    def __init__(self, first: float, step: float, processing: Processing, source: str) -> None:
        self._first, self._step, self._source = first, step, source
        self._processing = replace(processing, rate=None)
        seconds = max(_FORGETS / processing.cutoff if processing.cutoff else 0.0, _MARGIN)
        self._margin = int(seconds / step) + 1
        self._done = self._start = 0  # samples that were given; the first one that is held
        self._held: list[Samples] = []

    def pieces(self, block: Samples, last: bool) -> Iterator[_Piece]:
        """Take a block; give the pieces that are complete, at the last block all of the rest."""
        self._held.append(block)
        there = int(np.floor((float(block.t[-1]) - self._first) / self._step * (1.0 + 1e-12))) + 1
        size = int(_PIECE / self._step)
        while there >= self._done + size + self._margin:
            yield self._piece(self._done + size, there)
        if last and there > self._done:
            yield self._piece(there, there)

    def _piece(self, stop: int, there: int) -> _Piece:
        """Samples up to ``stop``, of ``there`` that could be had."""
        recording = _joined(self._held, self._source)
        numbers = np.arange(self._start, min(stop + self._margin, there))
        grid = np.asarray(self._first + self._step * numbers, dtype=np.float64)
        data = measurement(on_grid(recording, grid), self._processing)
        piece = _Piece(_cut(data, self._done - self._start, stop - self._start), self._done)
        self._done, self._start = stop, max(0, stop - self._margin)
        # Interpolation looks at its neighbours.
        self._held = [_after(recording, self._first + (self._start - 4) * self._step)]
        return piece


def _step(t: Array, rate: float | None, source: str) -> float:
    if rate is not None:
        return 1.0 / rate
    steps = np.diff(t)
    if len(steps) == 0 or np.abs(steps - steps.mean()).max() > 0.01 * steps.mean():
        raise InputError(f"{source}: its time steps differ: a long log needs --rate")
    return float(steps.mean())


def _with_last(blocks: Iterable[Samples]) -> Iterator[tuple[Samples, bool]]:
    """Each block, and whether it is the last."""
    waiting: Samples | None = None
    for block in blocks:
        if waiting is not None:
            yield waiting, False
        waiting = block
    if waiting is not None:
        yield waiting, True


def _joined(held: list[Samples], source: str) -> Recording:
    """Blocks in a row."""
    t, q, torque = (np.concatenate([getattr(block, name) for block in held]) for name in ("t", "q", "torque"))
    if (np.diff(t) <= 0.0).any():
        k = int(np.argmax(np.diff(t) <= 0.0))
        raise InputError(f"{source}: time stands still or runs back at {t[k]:g} s: mend or split the file")
    qd = None if held[0].qd is None else np.concatenate([block.qd for block in held if block.qd is not None])
    return Recording(t, q, torque, qd, source)


def _after(recording: Recording, time: float) -> Samples:
    k = max(int(np.searchsorted(recording.t, time)) - 1, 0)
    qd = recording.qd[k:] if recording.qd is not None else None
    return Samples(recording.t[k:], recording.q[k:], recording.torque[k:], qd)


def _cut(data: Measurement, start: int, stop: int) -> Measurement:
    m, part = data.motion, slice(start, stop)
    return Measurement(Motion(m.t[part], m.q[part], m.qd[part], m.qdd[part]), data.torque[part])
