"""What changed: a step on any of the last days, against a bound that quiet series rarely exceed.

A step is sought by generalized least squares beside the series' level, under the covariance of its scatter with
memory and of each night's own error, which whitens what is left after the temperature. The largest of the last
days' steps is an alarm beyond a bound. How often a quiet series newly exceeds a bound follows from the correlations
of these steps, today's with each other and with yesterday's, by importance sampling (Naiman and Priebe, Computing
scan statistic p values using importance sampling, 2001).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import brentq
from scipy.special import ndtr, ndtri

from ...common.arrays import Array
from ...common.schema import Document
from .series import FEWEST, LAST, Scatter, Series

FALSE_ALARMS = 1.0
"""Alarms a month (30 days) over the whole fleet where nothing changed, at most."""
_DRAWS = 4000  # of the bound: its rate is known to 1 or 2 %, the bound to some thousandths
_NARROW = 1e-9  # variance added to correlations, so that equal steps have a square root


class Alarm(Document, frozen=True):
    """A change ``since`` so many days after the first night; step and sigma are shares where ``relative``.

    ``sigmas``: step in its standard deviations; ``new``: whether there was none yesterday.
    """

    arm: str
    quantity: str
    since: float
    step: float
    sigma: float
    sigmas: float
    new: bool
    relative: bool


class Steps(NamedTuple):
    """Steps that are sought in a series, s of them: what estimates each from the values so far.

    ``starts``: the first night of each, s; ``weights``: sizes are weights @ values, shape (s, d);
    ``sigma``: of each size, shape (s,).
    """

    starts: tuple[int, ...]
    weights: Array
    sigma: Array


def steps_of(days: Array, nights: Array, scatter: Scatter) -> Steps | None:
    """Steps of the last days of a series; None with too few nights.

    Args:
        days: since the first night, shape (d,).
        nights: each night's own standard deviation, shape (d,).
        scatter: of the quantity.
    """
    count = len(days)
    if count <= FEWEST:
        return None
    first = max(FEWEST, int(np.searchsorted(days, days[-1] - LAST, side="right")))
    starts = tuple(range(first, count))
    if not starts:
        return None
    root = np.linalg.cholesky(scatter.covariance(days, nights))
    level = solve_triangular(root, np.ones(count), lower=True)
    after = (np.arange(count)[:, None] >= np.array(starts)).astype(float)
    steps = solve_triangular(root, after, lower=True)
    steps = steps - np.outer(level, level @ steps) / (level @ level)
    information = np.sum(steps**2, axis=0)
    weights = solve_triangular(root, steps, lower=True, trans="T").T / information[:, None]
    return Steps(starts, weights, 1.0 / np.sqrt(information))


def bound_of(days: Array, nights: Array, scatter: Scatter, rate: float) -> float:
    """Sigmas beyond which the largest step of a quiet series newly is so often a day, by chance.

    Args:
        days: since the first night, shape (d,).
        nights: each night's own standard deviation, shape (d,).
        scatter: of the quantity.
        rate: alarms a day, with none the day before.
    """
    highest = float(-ndtri(0.5 * rate / LAST))
    today = steps_of(days, nights, scatter)
    if today is None:
        return highest
    sought = [today.weights / today.sigma[:, None]]
    if (before := steps_of(days[:-1], nights[:-1], scatter)) is not None:
        sought.append(np.pad(before.weights / before.sigma[:, None], ((0, 0), (0, 1))))
    weights = np.vstack(sought)
    correlation = weights @ scatter.covariance(days, nights) @ weights.T
    lowest = float(-ndtri(0.5 * rate))
    sampled = _Crossing(correlation, len(today.starts))
    if sampled.rate(lowest) <= rate:  # one step alone, or as good as one
        return lowest
    return float(brentq(lambda bound: np.log(sampled.rate(bound) / rate), lowest, highest + 0.1, xtol=1e-4))


class _Crossing:
    """How often the largest of normal variables exceeds a bound today and none did yesterday."""

    def __init__(self, correlation: Array, today: int) -> None:
        """``correlation``: of today's variables, which come first, and of yesterday's."""
        draw = np.random.default_rng(0)
        root = np.linalg.cholesky(correlation + _NARROW * np.eye(len(correlation)))
        self._which = draw.integers(today, size=_DRAWS)
        self._share = draw.random(_DRAWS)
        free = draw.standard_normal((_DRAWS, len(correlation))) @ root.T
        self._along = correlation[self._which]
        self._free = free - self._along * free[np.arange(_DRAWS), self._which, None]
        self._today = today

    def rate(self, bound: float) -> float:
        """The chance a day: one variable is drawn beyond the bound, the others beside it; each case counts once."""
        beyond = -ndtri(self._share * ndtr(-bound))
        sizes = np.abs(self._free + self._along * beyond[:, None])
        here = np.maximum(np.sum(sizes[:, : self._today] > bound, axis=1), 1)
        new = ~np.any(sizes[:, self._today :] > bound, axis=1)
        return float(2.0 * self._today * ndtr(-bound) * np.mean(new / here))


def bounds_of(
    series: Sequence[Series], scatter: dict[str, Scatter], false_alarms: float = FALSE_ALARMS
) -> dict[str, float]:
    """Sigmas of each quantity that quiet series of the whole fleet newly exceed so often a month (30 days).

    Each quantity's bound is that of its series with the most nights.
    """
    rate = false_alarms / (30.0 * max(len(series), 1))
    longest: dict[str, Series] = {}
    for line in series:
        if line.quantity not in longest or len(line.days) > len(longest[line.quantity].days):
            longest[line.quantity] = line
    return {
        name: bound_of(line.days, scatter[name].errors_of(line), scatter[name], rate)
        for name, line in longest.items()
    }


def alarm_of(series: Series, scatter: Scatter, bound: float) -> Alarm | None:
    """The largest step of the last days, where it is an alarm today."""
    today = _largest_step(series, scatter, len(series.days))
    if today is None or abs(today[2]) <= bound:
        return None
    yesterday = _largest_step(series, scatter, len(series.days) - 1)
    new = yesterday is None or abs(yesterday[2]) <= bound
    start, sigma, sigmas = today
    since, step = float(series.days[start]), sigma * sigmas
    return Alarm(series.arm, series.quantity, since, step, sigma, sigmas, new, series.relative)


def _largest_step(series: Series, scatter: Scatter, count: int) -> tuple[int, float, float] | None:
    """First night, standard deviation and size in these of the step that the first so many nights show most."""
    steps = steps_of(series.days[:count], scatter.errors_of(series)[:count], scatter)
    if steps is None:
        return None
    values = scatter.rest_of(series)[:count]
    sigmas = steps.weights @ values / steps.sigma
    k = int(np.argmax(np.abs(sigmas)))
    return steps.starts[k], float(steps.sigma[k]), float(sigmas[k])
