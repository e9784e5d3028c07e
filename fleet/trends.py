"""A fleet over time: what depends on temperature, what drifts, what changed, and which arm differs from its twins.

A series is one quantity of one arm, day by day: a friction over its own median, less the temperature's share, which
twins have in common; a drive's scale; the payload's mass less what the controller was told. What is left scatters
from day to day with memory, x_d = phi x_(d-1) + e_d, beside each night's own error. The size of the scatter and phi
are measured robustly over all arms of the type, quantity by quantity. A change is sought as a step on any of the
last days, by generalized least squares; the largest of these is compared with a bound that a fleet without changes
exceeds once in a stated time (Bonferroni over series and days).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular
from scipy.stats import norm

from ..common.arrays import Array
from ..model.names import parameter_kind
from .merging import Compared, side_by_side
from .nights import MASS, Arm, Night

FALSE_ALARMS = 1.0
"""Alarms a month (30 days) over the whole fleet where nothing changed, at most."""
LAST = 7
"""Days among which a change is sought, today the last of them."""
FEWEST = 8
"""Nights before a change that tell what is usual."""
_MAD = 1.4826  # standard deviations a median absolute deviation is of
_WITHIN = 0.9733  # variance of a normal variable cut at three standard deviations
_LONGEST = 0.9  # memory: of a longer one every step would be scatter
_MANY = 50  # differences whose median is sure enough
_RELATIVE = ("FS", "FV", "FSM", "FVM")


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
        temperature: less its mean [K], zeros where it is not known, shape (d,).
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
    deviation ``per_kelvin_sigma``.
    """

    sigma: float
    memory: float
    own: float
    per_kelvin: float
    per_kelvin_sigma: float


class Alarm(NamedTuple):
    """A change: ``arm``, ``quantity``, ``since`` (days), ``step`` and its ``sigma``, as a share where relative.

    ``sigmas``: step in its standard deviations; ``new``: whether there was none yesterday.
    """

    arm: str
    quantity: str
    since: float
    step: float
    sigma: float
    sigmas: float
    new: bool


class Drift(NamedTuple):
    """A steady change of a series: per 30 days, with its standard deviation."""

    arm: str
    quantity: str
    per_month: float
    sigma: float


@dataclass(frozen=True)
class Fleet:
    """What a fleet's nights say.

    Attributes:
        arms: of one type, by name.
        series: of each arm and quantity.
        scatter: of each quantity.
        alarms: today, the largest first.
        drifts: of each series with enough nights.
        twins: the arms' inertial parameters side by side; None of a single arm.
        bound: sigmas beyond which a step is an alarm.
        first: day of the first night, ISO.
    """

    arms: tuple[Arm, ...]
    series: tuple[Series, ...]
    scatter: dict[str, Scatter]
    alarms: tuple[Alarm, ...]
    drifts: tuple[Drift, ...]
    twins: Compared | None
    bound: float
    first: str


def fleet_of(arms: Sequence[Arm], false_alarms: float = FALSE_ALARMS) -> Fleet:
    """Trends, alarms and odd arms of a fleet; ``false_alarms``: a month over all of it, without any change."""
    arms = tuple(sorted(arms, key=lambda arm: arm.name))
    first = min(night.day for arm in arms for night in arm.nights)
    series = tuple(one for arm in arms for one in _series(arm, first))
    names = list(dict.fromkeys(one.quantity for one in series))
    scatter = {name: scatter_of([one for one in series if one.quantity == name]) for name in names}
    bound = bound_of(len(series), false_alarms)
    alarms = _alarms(series, scatter, bound)
    drifts = (drift_of(one, scatter[one.quantity]) for one in series)
    steady = tuple(drift for drift in drifts if drift is not None)
    return Fleet(arms, series, scatter, alarms, steady, _twins(arms), bound, first)


def _alarms(series: Sequence[Series], scatter: Mapping[str, Scatter], bound: float) -> tuple[Alarm, ...]:
    """Today's alarms, the largest first."""
    found = (alarm_of(one, scatter[one.quantity], bound) for one in series)
    return tuple(sorted((alarm for alarm in found if alarm is not None), key=lambda alarm: -abs(alarm.sigmas)))


def bound_of(series: int, false_alarms: float = FALSE_ALARMS) -> float:
    """Sigmas that steps of so many series exceed so often a month, by chance."""
    return float(norm.isf(0.5 * false_alarms / (30.0 * LAST * max(series, 1))))


def days_since(first: str, day: str) -> float:
    """Days from one ISO date or time to another."""
    start, end = (datetime.fromisoformat(text).replace(tzinfo=None) for text in (first, day))
    return (end - start).total_seconds() / 86400.0


def _series(arm: Arm, first: str) -> list[Series]:
    days = np.array([days_since(first, night.day) for night in arm.nights])
    temperature = _centred(arm.nights)
    made = []
    for name in arm.nights[0].numbers:
        numbers = np.array([night.numbers[name] for night in arm.nights])
        relative = " " not in name and name != MASS and parameter_kind(name) in _RELATIVE
        usual = float(np.median(numbers[:, 0])) if name != MASS else 0.0
        size = max(abs(usual), 1e-12) if relative else 1.0
        made.append(
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
    return made


def _centred(nights: Sequence[Night]) -> Array:
    """Temperatures less their mean; zeros where one is not known."""
    told = np.array([night.temperature for night in nights])
    return told - told.mean() if np.isfinite(told).all() else np.zeros(len(told))


def scatter_of(series: Sequence[Series]) -> Scatter:
    """How one quantity of all arms varies where nothing changed: medians, so that few changes do not count."""
    slope, slope_sigma = _per_kelvin(series)
    left = [one.values - slope * one.temperature for one in series]
    # Differences of neighbouring nights hold the variance 2 (1 - phi) times, own errors apart.
    whole, step = _whole(left), _spread(_apart(left, 1))
    told = float(np.median(np.concatenate([one.sigma for one in series]) ** 2))
    own = min(told, 0.5 * step**2)  # which holds a night's own error and more
    variance = max(whole**2 - own, 0.0)
    covariance = max(whole**2 - 0.5 * step**2, 0.0)  # of neighbouring nights
    memory = min(covariance / variance, _LONGEST) if variance > 0.05 * own else 0.0
    share = float(np.sqrt(own / told)) if told > 0.0 else 1.0
    return Scatter(float(np.sqrt(variance)), float(memory), share, slope, slope_sigma)


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
    for one in series:
        warm = np.diff(one.temperature)
        if warm @ warm > 0.0 and len(warm) >= FEWEST:
            slopes.append(float(warm @ np.diff(one.values) / (warm @ warm)))
    if not slopes:
        return 0.0, 0.0
    spread = _MAD * float(np.median(np.abs(np.array(slopes) - np.median(slopes))))
    return float(np.median(slopes)), 1.25 * spread / float(np.sqrt(len(slopes)))


def alarm_of(series: Series, scatter: Scatter, bound: float) -> Alarm | None:
    """The largest step of the last days, where it is an alarm today."""
    today = _largest_step(series, scatter, len(series.days))
    if today is None or abs(today.sigmas) <= bound:
        return None
    yesterday = _largest_step(series, scatter, len(series.days) - 1)
    return today._replace(new=yesterday is None or abs(yesterday.sigmas) <= bound)


def _largest_step(series: Series, scatter: Scatter, count: int) -> Alarm | None:
    """The step that the first so many nights show most clearly; None with too few of them."""
    days, values = series.days[:count], (series.values - scatter.per_kelvin * series.temperature)[:count]
    if count <= FEWEST:
        return None
    memory = scatter.memory ** np.abs(days[:, None] - days[None, :]) if scatter.memory > 0.0 else np.eye(count)
    covariance = scatter.sigma**2 * memory + np.diag((scatter.own * series.sigma[:count]) ** 2)
    root = np.linalg.cholesky(covariance)
    level, y = solve_triangular(root, np.ones(count), lower=True), solve_triangular(root, values, lower=True)
    best = None
    for start in range(max(FEWEST, int(np.searchsorted(days, days[-1] - LAST, side="right"))), count):
        step = solve_triangular(root, (np.arange(count) >= start).astype(float), lower=True)
        step = step - level * (level @ step) / (level @ level)
        information = float(step @ step)
        size, sigma = float(step @ y) / information, 1.0 / float(np.sqrt(information))
        if best is None or abs(size / sigma) > abs(best.sigmas):
            best = Alarm(series.arm, series.quantity, float(days[start]), size, sigma, size / sigma, False)
    return best


def drift_of(series: Series, scatter: Scatter) -> Drift | None:
    """The slope of a series over time, with its memory."""
    count = len(series.days)
    if count <= FEWEST or np.ptp(series.days) == 0.0:
        return None
    memory = (
        scatter.memory ** np.abs(series.days[:, None] - series.days[None, :]) if scatter.memory else np.eye(count)
    )
    root = np.linalg.cholesky(scatter.sigma**2 * memory + np.diag((scatter.own * series.sigma) ** 2))
    line = solve_triangular(root, np.column_stack([np.ones(count), series.days / 30.0]), lower=True)
    y = solve_triangular(root, series.values - scatter.per_kelvin * series.temperature, lower=True)
    inverse = np.linalg.inv(line.T @ line)
    return Drift(series.arm, series.quantity, float((inverse @ (line.T @ y))[1]), float(np.sqrt(inverse[1, 1])))


def _twins(arms: Sequence[Arm]) -> Compared | None:
    """The arms' parameters without friction, side by side; None of fewer than three."""
    if len(arms) < 3:
        return None
    names = [name for name in arms[0].pooled.names if parameter_kind(name) not in (*_RELATIVE, "OFF")]
    return side_by_side([arm.name for arm in arms], [arm.pooled.part(names) for arm in arms])
