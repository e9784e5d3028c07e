"""Parallel decimation: Y and every column of W pass one low-pass filter, and every k-th sample is kept."""

from functools import cache

import numpy as np

from ...common.arrays import Array

_HALF = 10  # decimated samples that the filter reaches to either side
_CUTOFF = 0.8  # of the new Nyquist frequency
_GROUP = 8  # decimated samples computed by one matrix product: few zeros in it, few products


@cache
def _taps(factor: int) -> Array:
    """Coefficients of the low-pass filter, 20 * factor + 1, symmetric, sum 1 (Hamming window)."""
    lags = np.arange(-_HALF * factor, _HALF * factor + 1) if factor > 1 else np.zeros(1)
    taps = np.sinc(_CUTOFF / factor * lags) * np.hamming(len(lags))
    return np.asarray(taps / taps.sum())


@cache
def _band(factor: int) -> Array:
    """Matrix that turns a stretch of samples into _GROUP decimated ones: one product instead of many filters."""
    taps = _taps(factor)
    band = np.zeros(((_GROUP - 1) * factor + len(taps), _GROUP))
    for k in range(_GROUP):
        band[k * factor : k * factor + len(taps), k] = taps
    return band


def noise_bandwidth(factor: int) -> float:
    """Fraction of the new frequency range that white noise still fills after decimation.

    r decimated rows hold as much independent noise as ``noise_bandwidth * r`` white ones: within the filter's pass
    band, where the columns of W live, the noise has the density of white noise, but its variance, which is what
    residuals show, is smaller by this factor.
    """
    return float(factor * np.sum(_taps(factor) ** 2))


class Decimator:
    """Low-pass and keep every k-th sample, block by block, without delay.

    The filter has finite length: a recording cut into blocks gives what it gives in one piece. Beyond the ends of a
    recording everything counts as zero, in Y as in W; the same linear operation on both keeps Y = W chi.
    """

    def __init__(self, rows: int, factor: int) -> None:
        """Prepare for ``rows`` signals; ``factor`` 1 passes them through."""
        self._factor = factor
        self._reach = _HALF * factor if factor > 1 else 0
        self._held = np.zeros((rows, self._reach))

    def push(self, signals: Array) -> Array:
        """Take the next samples, rows x N; give the decimated samples that are complete, rows x M."""
        if self._factor == 1:
            return signals
        waiting = np.concatenate([self._held, signals], axis=1)
        width = 2 * self._reach + 1
        count = max(0, (waiting.shape[1] - width) // self._factor + 1)
        self._held = waiting[:, count * self._factor :]
        result = np.empty((len(waiting), count))
        for start in range(0, count, _GROUP):
            outputs = min(_GROUP, count - start)
            used = waiting[:, start * self._factor : (start + outputs - 1) * self._factor + width]
            result[:, start : start + outputs] = used @ _band(self._factor)[: used.shape[1], :outputs]
        return result

    def finish(self) -> Array:
        """Give the samples that still waited for the end of the recording."""
        return self.push(np.zeros((len(self._held), self._reach)))


def decimated(signals: Array, factor: int) -> Array:
    """Decimate whole signals, rows x N, to rows x ceil(N / factor)."""
    decimator = Decimator(len(signals), factor)
    return np.concatenate([decimator.push(signals), decimator.finish()], axis=1) if factor > 1 else signals
