"""How long residuals remember: their integrated autocorrelation time."""

from collections.abc import Sequence

import numpy as np

from ...common.arrays import Array

_WINDOW = 5.0  # lags summed, in autocorrelation times


def autocorrelation_time(series: Sequence[tuple[Array, Array]], step: float) -> float:
    """Integrated autocorrelation time tau = step (1/2 + rho_1 + ... + rho_M) [s], at least step / 2.

    The window is Sokal's, consistent with itself: the smallest M with M step >= 5 tau (Sokal, Monte Carlo methods
    in statistical mechanics, 1997, section 3). White noise has step / 2; noise that forgets as exp(-t / T), T.
    Rows that were left out form no pairs; each rho_k divides by the number of pairs that are there.

    Args:
        series: times [s] on a grid of ``step`` and residuals, (r,) each; recordings of one process.
        step: time between neighbouring rows [s].
    """
    grids = [_on_grid(t, values, step) for t, values in series if len(t)]
    power = _mean_product(grids, 0)
    if power == 0.0:
        return 0.5 * step
    tau, lag = 0.5, 0
    while lag < _WINDOW * tau and lag + 1 < max(values.size for values, _ in grids) // 2:
        lag += 1
        tau += _mean_product(grids, lag) / power
    return step * max(tau, 0.5)


def inflation(series: Sequence[tuple[Array, Array]]) -> float:
    """By how much the memory of errors raises the variance of their mean, 1 + 2 (rho_1 + ...), at least 1.

    Args:
        series: as of ``autocorrelation_time``, on the closest rows' grid.
    """
    there = [(t, values) for t, values in series if len(t) > 1]
    if not there:
        return 1.0
    step = min(float(np.diff(t).min()) for t, _ in there)
    return max(1.0, 2.0 * autocorrelation_time(there, step) / step)


def autocorrelation(t: Array, values: Array, step: float, lags: int) -> Array:
    """Autocorrelation rho_0 = 1, rho_1 ... rho_lags of one series; rows that were left out form no pairs.

    Args:
        t: times on a grid of ``step`` [s], shape (r,).
        values: residuals, shape (r,).
        step: time between neighbouring rows [s].
        lags: the last one.

    Returns:
        Shape (lags + 1,); zeros after the first for a series without power.
    """
    grids = [_on_grid(t, values, step)] if len(t) else []
    power = _mean_product(grids, 0)
    if power == 0.0:
        return np.append(1.0, np.zeros(lags))
    return np.array([_mean_product(grids, lag) / power for lag in range(lags + 1)])


def _on_grid(t: Array, values: Array, step: float) -> tuple[Array, Array]:
    """Values with zeros where rows are missing, and ones where they are not."""
    place = np.rint((t - t[0]) / step).astype(int)
    dense, there = np.zeros((2, place[-1] + 1))
    dense[place], there[place] = values, 1.0
    return dense, there


def _mean_product(grids: Sequence[tuple[Array, Array]], lag: int) -> float:
    """Mean of e(t) e(t + lag) over all pairs that are there; 0 without any."""
    total, pairs = 0.0, 0.0
    for values, there in grids:
        size = max(values.size - lag, 0)
        total += float(values[:size] @ values[lag:])
        pairs += float(there[:size] @ there[lag:])
    return total / pairs if pairs else 0.0
