"""Each quantity of each arm, day by day, and how it varies where nothing changed.

A series is one quantity of one arm: a friction over its own median, less the temperature's share, which twins have
in common; a drive's scale; the payload's mass less what the controller was told. What is left scatters from day to
day with memory, x_d = phi x_(d-1) + e_d, beside each night's own error. The size of the scatter and phi are
measured robustly over all arms of the type, quantity by quantity.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model.drives import parameter_kind
from .nights import MASS, Arm, Night

LAST = 7
"""Days among which a change is sought, today the last of them."""
FEWEST = 8
"""Nights before a change that tell what is usual."""
_MAD = 1.4826  # standard deviations a median absolute deviation is of
_WITHIN = 0.9733  # variance of a normal variable cut at three standard deviations
_LONGEST = 0.9  # memory: of a longer one every step would be scatter
_OWN = 0.1  # least share of own errors that others are put on
_MANY = 50  # differences whose median is sure enough
RELATIVE = ("FS", "FV", "FSM", "FVM")
"""Kinds of parameters that are taken over their own median."""


@dataclass(frozen=True)
class Series:
    """One quantity of one arm, day by day.

    Attributes:
        arm: its name.
        quantity: its name.
        relative: whether it is a share of its own median.
        usual: that median, in the quantity's unit.
        days: since the first night of the fleet, shape (d,).
        values: less the usual one, shape (d,); shares where relative.
        sigma: each night's own, shape (d,).
        temperature: less its mean [K], nan where it is not known, shape (d,).
    """

    arm: str
    quantity: str
    relative: bool
    usual: float
    days: Array
    values: Array
    sigma: Array
    temperature: Array


class Scatter(NamedTuple):
    """How a quantity varies from day to day without any change.

    ``sigma``: standard deviation beside each night's own error; ``memory``: phi; ``own``: share of the nights' own
    standard deviations that their spread allows; ``per_kelvin``: the temperature's share, with its standard
    deviation ``per_kelvin_sigma``; ``kelvins``: standard deviation of the temperature, which a night counts as its
    own error where its temperature is not known.
    """

    sigma: float
    memory: float
    own: float
    per_kelvin: float
    per_kelvin_sigma: float
    kelvins: float = 0.0

    def rest_of(self, series: Series) -> Array:
        """A series less the temperature's share, (d,); all of it where the temperature is not known."""
        return series.values - self.per_kelvin * np.nan_to_num(series.temperature)

    def errors_of(self, series: Series) -> Array:
        """Each night's own standard deviation, (d,), and that of a temperature that is not known."""
        unknown = np.isnan(series.temperature) * self.per_kelvin * self.kelvins
        return np.hypot(series.sigma, unknown / max(self.own, _OWN))

    def covariance(self, days: Array, nights: Array) -> Array:
        """Covariance of a series' values without any change, shape (d, d).

        Args:
            days: since the first night, shape (d,).
            nights: each night's own standard deviation, shape (d,).
        """
        memory = self.memory ** np.abs(days[:, None] - days[None, :]) if self.memory > 0.0 else np.eye(len(days))
        return self.sigma**2 * memory + np.diag((self.own * nights) ** 2)


def days_since(first: str, day: str) -> float:
    """Days from one ISO date or time to another."""
    start, end = (datetime.fromisoformat(text).replace(tzinfo=None) for text in (first, day))
    return (end - start).total_seconds() / 86400.0


def series_of(arm: Arm, first: str) -> list[Series]:
    """All quantities of an arm; ``first``: day of the fleet's first night, ISO."""
    days = np.array([days_since(first, night.day) for night in arm.nights])
    temperature = _centred(arm.nights)
    series = []
    for name in arm.nights[0].numbers:
        numbers = np.array([night.numbers[name] for night in arm.nights])
        relative = " " not in name and name != MASS and parameter_kind(name) in RELATIVE
        usual = float(np.median(numbers[:, 0])) if name != MASS else 0.0
        size = max(abs(usual), 1e-12) if relative else 1.0
        series.append(
            Series(
                arm.name,
                name,
                relative,
                usual,
                days,
                (numbers[:, 0] - usual) / size,
                numbers[:, 1] / size,
                temperature,
            )
        )
    return series


def _centred(nights: Sequence[Night]) -> Array:
    """Temperatures less the mean of those that are known."""
    temperatures = np.array([night.temperature for night in nights])
    return temperatures - (np.nanmean(temperatures) if np.isfinite(temperatures).any() else 0.0)


def scatter_of(series: Sequence[Series]) -> Scatter:
    """How one quantity of all arms varies where nothing changed: medians, so that few changes do not count."""
    slope, slope_sigma = _per_kelvin(series)
    warmth = np.concatenate([line.temperature for line in series])
    kelvins = float(np.nanstd(warmth)) if np.isfinite(warmth).any() else 0.0
    left = [line.values - slope * np.nan_to_num(line.temperature) for line in series]
    # Differences of neighbouring nights hold the variance 2 (1 - phi) times, own errors apart.
    whole, step = _whole(left), _spread(_apart(left, 1))
    own_variance = float(np.median(np.concatenate([line.sigma for line in series]) ** 2))
    own = min(own_variance, 0.5 * step**2)  # which holds a night's own error and more
    variance = max(whole**2 - own, 0.0)
    covariance = max(whole**2 - 0.5 * step**2, 0.0)  # of neighbouring nights
    memory = min(covariance / variance, _LONGEST) if variance > 0.05 * own else 0.0
    share = float(np.sqrt(own / own_variance)) if own_variance > 0.0 else 1.0
    return Scatter(float(np.sqrt(variance)), float(memory), share, slope, slope_sigma, kelvins)


def _whole(left: Sequence[Array]) -> float:
    """Standard deviation of single nights; by nights far apart, which remember nothing, where there are enough."""
    far = _apart(left, LAST)
    if far.size >= _MANY:
        return float(np.sqrt(0.5)) * _spread(far)
    return _spread(np.concatenate([values - np.median(values) for values in left]))


def _apart(left: Sequence[Array], nights: int) -> Array:
    """Differences over so many nights."""
    return np.concatenate([np.zeros(0), *(x[nights:] - x[:-nights] for x in left if len(x) > nights)])


def _spread(x: Array) -> float:
    """Standard deviation of what scatters about zero: of all within three median ones, made good for the rest."""
    within = x[np.abs(x) <= 3.0 * _MAD * np.median(np.abs(x))] if x.size else x
    return float(np.sqrt(np.mean(within**2) / _WITHIN)) if within.size else 0.0


def _per_kelvin(series: Sequence[Series]) -> tuple[float, float]:
    """The temperature's share, by the median of the arms' own slopes between neighbouring nights."""
    slopes = []
    for line in series:
        warm = np.nan_to_num(np.diff(line.temperature))
        if warm @ warm > 0.0 and len(warm) >= FEWEST:
            slopes.append(float(warm @ np.diff(line.values) / (warm @ warm)))
    if not slopes:
        return 0.0, 0.0
    spread = _MAD * float(np.median(np.abs(np.array(slopes) - np.median(slopes))))
    return float(np.median(slopes)), 1.25 * spread / float(np.sqrt(len(slopes)))
