"""Samples that arrive one after the other, cut in blocks of time that are filtered as a whole recording is."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from ...common.arrays import Array
from ...model import Motion, Processing, Recording
from ...model.motion import Measurement
from .filtering import NEIGHBOURS, lowpass, on_grid, slopes

BLOCK = 1.0
"""s: length of a block."""
_SETTLES = 3.0
"""Periods of the cut-off that a block is filtered with on either side."""
_FEWEST = 60
"""Samples by which the rate is known."""
_GAP = 0.25
"""s: samples that are farther apart are no part of one motion."""


class BlockCutter:
    """Measurements of consecutive blocks of a stream, each filtered with what lies before and behind it.

    What is kept of the stream is a few seconds. A gap begins the cutting anew.
    """

    def __init__(self, processing: Processing) -> None:
        """Begin without a sample."""
        self._processing = processing
        self._rate: float | None = None
        self._clear()

    def _clear(self) -> None:
        self._samples: list[tuple[Array, ...]] = []
        self._next = 0

    def feed(self, recording: Recording) -> Iterator[Measurement]:
        """Take the next samples; gives the blocks that are complete with them.

        Raises:
            InputError: if the samples are too few a second for the cut-off.
        """
        t = recording.t
        last = self._samples[-1][0][-1] if self._samples else -np.inf
        fresh = t > np.maximum.accumulate(np.concatenate([[last], t[:-1]]))
        t = t[fresh]
        if not len(t):
            return
        before = np.concatenate([[last if np.isfinite(last) else t[0]], t[:-1]])
        breaks = np.flatnonzero(t - before > _GAP)
        arrays = [t, recording.q[fresh], recording.torque[fresh]]
        arrays += [recording.qd[fresh]] if recording.qd is not None else []
        ends = [0, *breaks.tolist(), len(t)]
        for k, (start, stop) in enumerate(pairwise(ends)):
            if k:
                self._clear()
            if stop > start:
                self._samples.append(tuple(array[start:stop] for array in arrays))
                yield from self._complete()

    def _complete(self) -> Iterator[Measurement]:
        """Blocks that lie far enough behind the newest sample."""
        arrays = tuple(map(np.concatenate, zip(*self._samples, strict=True)))
        self._samples = [arrays]
        t = arrays[0]
        if self._next == 0:
            if len(t) < _FEWEST:
                return
            self._rate = self._rate or self._processing.grid_rate((len(t) - 1) / float(t[-1] - t[0]))
            self._start = float(t[0])
        assert self._rate is not None
        count, margin = round(BLOCK * self._rate), self._margin
        while self._start + (self._next + count + 2 * margin) / self._rate <= t[-1]:
            grid = self._start + np.arange(self._next, self._next + count + 2 * margin + 1) / self._rate
            yield self._filtered(arrays, grid, count)
            self._next += count
        old = int(np.searchsorted(t, self._start + self._next / self._rate)) - NEIGHBOURS
        self._samples = [tuple(array[max(old, 0) :] for array in arrays)]

    @property
    def _margin(self) -> int:
        """Samples on either side of a block that it is filtered with."""
        cutoff = self._processing.cutoff
        assert self._rate is not None
        return int(np.ceil(_SETTLES / cutoff * self._rate)) if cutoff else 2

    def _filtered(self, arrays: tuple[Array, ...], grid: Array, count: int) -> Measurement:
        """The block in the middle of a grid of times."""
        first, last = np.searchsorted(arrays[0], grid[[0, -1]])
        near = slice(max(int(first) - NEIGHBOURS, 0), int(last) + NEIGHBOURS)
        t, q, torque, *speeds = (array[near] for array in arrays)
        even = on_grid(Recording(t, q, torque, speeds[0] if speeds else None), grid)
        step, cutoff, middle = 1.0 / float(self._rate or 1.0), self._processing.cutoff, self._margin
        smooth = lowpass(even.q, step, cutoff, "live")
        qd = slopes(smooth, step) if even.qd is None else lowpass(even.qd, step, cutoff, "live")
        whole = Measurement(Motion(grid, smooth, qd, slopes(qd, step)), even.torque)
        return whole.between(middle, middle + count)
