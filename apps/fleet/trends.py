"""A fleet over time: what drifts, what changed, and which arm differs from its twins."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from ...common.schema import Document
from .alarms import FALSE_ALARMS, Alarm, alarm_of, bounds_of
from .comparing import Compared, side_by_side
from .identity import Exchange, named
from .nights import Arm, bodies_of
from .series import FEWEST, Scatter, Series, scatter_of, series_of


class Drift(Document, frozen=True):
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
        bounds: sigmas of each quantity beyond which a step is an alarm.
        alarms: today, the largest first.
        drifts: of each series with enough nights.
        twins: the arms' inertial parameters side by side; None of a single arm.
        exchanges: recordings that are of another robot than their arm's name says.
        first: day of the first night, ISO.
    """

    arms: tuple[Arm, ...]
    series: tuple[Series, ...]
    scatter: dict[str, Scatter]
    bounds: dict[str, float]
    alarms: tuple[Alarm, ...]
    drifts: tuple[Drift, ...]
    twins: Compared | None
    exchanges: tuple[Exchange, ...]
    first: str


def fleet_of(arms: Sequence[Arm], false_alarms: float = FALSE_ALARMS) -> Fleet:
    """Trends, alarms and odd arms of a fleet; ``false_alarms``: a month over all of it, without any change."""
    arms = tuple(sorted(arms, key=lambda arm: arm.name))
    first = min(night.day for arm in arms for night in arm.nights)
    series = tuple(line for arm in arms for line in series_of(arm, first))
    scatter = _scatters(series)
    bounds = bounds_of(series, scatter, false_alarms)
    drifts = (drift_of(line, scatter[line.quantity]) for line in series)
    steady = tuple(drift for drift in drifts if drift is not None)
    alarms = _alarms(series, scatter, bounds)
    return Fleet(arms, series, scatter, bounds, alarms, steady, _twins(arms), _exchanges(arms), first)


def _scatters(series: Sequence[Series]) -> dict[str, Scatter]:
    """Scatter of each quantity, over all arms."""
    names = dict.fromkeys(line.quantity for line in series)
    return {name: scatter_of([line for line in series if line.quantity == name]) for name in names}


def _alarms(
    series: Sequence[Series], scatter: Mapping[str, Scatter], bounds: Mapping[str, float]
) -> tuple[Alarm, ...]:
    """Steps that chance does not make, the clearest first."""
    alarms = (alarm_of(line, scatter[line.quantity], bounds[line.quantity]) for line in series)
    return tuple(sorted((alarm for alarm in alarms if alarm is not None), key=lambda alarm: -abs(alarm.sigmas)))


def _exchanges(arms: Sequence[Arm]) -> tuple[Exchange, ...]:
    """Arms that are another one from some day on, and which of the fleet that is."""
    pooled = [(arm.name, bodies_of(arm.pooled)) for arm in arms]
    return tuple(named(arm.exchange, pooled) for arm in arms if arm.exchange is not None)


def drift_of(series: Series, scatter: Scatter) -> Drift | None:
    """The slope of a series over time, with its memory."""
    count = len(series.days)
    if count <= FEWEST or np.ptp(series.days) == 0.0:
        return None
    root = np.linalg.cholesky(scatter.covariance(series.days, scatter.errors_of(series)))
    line = solve_triangular(root, np.column_stack([np.ones(count), series.days / 30.0]), lower=True)
    y = solve_triangular(root, scatter.rest_of(series), lower=True)
    inverse = np.linalg.inv(line.T @ line)
    return Drift(series.arm, series.quantity, float((inverse @ (line.T @ y))[1]), float(np.sqrt(inverse[1, 1])))


def _twins(arms: Sequence[Arm]) -> Compared | None:
    """The arms' parameters without friction, side by side; None of fewer than three."""
    if len(arms) < 3:
        return None
    return side_by_side([arm.name for arm in arms], [bodies_of(arm.pooled) for arm in arms])
