"""Monotone cubic interpolation as of ``scipy.interpolate``, whose import takes longer than most commands work."""

import numpy as np

from .arrays import Array


class MonotoneCubic:
    """Interpolates values between rising times without overshoot (PCHIP: Fritsch & Butland, 1984)."""

    def __init__(self, t: Array, values: Array) -> None:
        """Take values (N, k) at rising times (N,), N of at least 2."""
        step, self._t, self._values = np.diff(t)[:, None], t, values
        rise = np.diff(values, axis=0) / step
        self._slopes = np.empty(values.shape)
        if len(t) == 2:
            self._slopes[:] = rise
            return
        before, after = 2.0 * step[1:] + step[:-1], step[1:] + 2.0 * step[:-1]
        with np.errstate(divide="ignore", invalid="ignore"):  # where the sense changes, the slope is zero anyway
            mean = (before + after) / (before / rise[:-1] + after / rise[1:])
        self._slopes[1:-1] = np.where(rise[:-1] * rise[1:] > 0.0, mean, 0.0)
        self._slopes[0] = _at_end(step[0], step[1], rise[0], rise[1])
        self._slopes[-1] = _at_end(step[-1], step[-2], rise[-1], rise[-2])

    def __call__(self, times: Array) -> Array:
        """Values at some times (M,), shape (M, k); nan before the first and after the last."""
        t, values, slopes = self._t, self._values, self._slopes
        k = np.clip(np.searchsorted(t, times, side="right") - 1, 0, len(t) - 2)
        step = (t[k + 1] - t[k])[:, None]
        share = (times - t[k])[:, None] / step
        rise = values[k + 1] - values[k]
        first, last = step * slopes[k], step * slopes[k + 1]
        bent = 3.0 * rise - 2.0 * first - last + share * (first + last - 2.0 * rise)
        result: Array = values[k] + share * (first + share * bent)
        result[(times < t[0]) | (times > t[-1])] = np.nan
        return result


def _at_end(step: Array, further: Array, rise: Array, beyond: Array) -> Array:
    """Slope at an end, from the two intervals beside it: never against the first, never three times as steep."""
    slope = ((2.0 * step + further) * rise - step * beyond) / (step + further)
    slope = np.where(slope * rise > 0.0, slope, 0.0)
    steep = (rise * beyond < 0.0) & (np.abs(slope) > 3.0 * np.abs(rise))
    return np.where(steep, 3.0 * rise, slope)
