"""A fleet over time: what changed last night, which arm differs from its twins, and which is another robot.

A series is one quantity of one arm, night by night. Its last night is compared with the median of the nights
before, by their median absolute deviation and the night's own error. This robust z does not move by a few changed
nights before.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

import numpy as np

from ...common.arrays import Array
from ...model.names import parameter_kind
from .comparing import TINY, Compared, side_by_side
from .identity import Exchange, named
from .nights import MASS, Arm, bodies_of

FEWEST = 8
"""Nights before the last one that tell what is usual; of fewer a median absolute deviation says little."""
CHANGED = 5.0
"""z beyond which a change is told: a quiet series exceeds it once in 60 nights by 8 before, in 2,000 by 30."""
_MAD = 1.4826  # standard deviations a median absolute deviation is of
_RELATIVE = ("FS", "FV", "FSM", "FVM")  # kinds of parameters that are taken over their own median


@dataclass(frozen=True)
class Series:
    """One quantity of one arm, night by night.

    Attributes:
        arm: its name.
        quantity: its name.
        relative: whether it is a share of its usual value.
        usual: the median of the nights before the last one, in the quantity's unit.
        days: since the first night of the fleet, shape (d,).
        values: less the usual one, shape (d,); shares where relative.
        sigma: each night's own standard deviation, shape (d,).
    """

    arm: str
    quantity: str
    relative: bool
    usual: float
    days: Array
    values: Array
    sigma: Array

    @property
    def spread(self) -> float:
        """Standard deviation of the last night where nothing changed: of the nights before, and the night's own."""
        before = self.values[:-1]
        scatter = _MAD * float(np.median(np.abs(before))) if before.size else 0.0
        return max(float(np.hypot(scatter, self.sigma[-1])), TINY)

    @property
    def z(self) -> float | None:
        """The last night's value in such standard deviations; None with fewer than ``FEWEST`` nights before."""
        return float(self.values[-1]) / self.spread if len(self.values) > FEWEST else None


@dataclass(frozen=True)
class Fleet:
    """What a fleet's nights say.

    Attributes:
        arms: of one type, by name.
        series: of each arm and quantity.
        twins: the arms' inertial parameters side by side; None of fewer than three.
        exchanges: recordings that are of another robot than their arm's name says.
        first: day of the first night, ISO.
    """

    arms: tuple[Arm, ...]
    series: tuple[Series, ...]
    twins: Compared | None
    exchanges: tuple[Exchange, ...]
    first: str

    @property
    def changed(self) -> tuple[Series, ...]:
        """The series whose last night is beyond ``CHANGED``, the clearest first."""
        far = [(abs(line.z), line) for line in self.series if line.z is not None and abs(line.z) > CHANGED]
        return tuple(line for _, line in sorted(far, key=lambda pair: -pair[0]))


def fleet_of(arms: Sequence[Arm]) -> Fleet:
    """Last night's changes and odd arms of a fleet."""
    arms = tuple(sorted(arms, key=lambda arm: arm.name))
    first = min(night.day for arm in arms for night in arm.nights)
    series = tuple(line for arm in arms for line in series_of(arm, first))
    pooled = [bodies_of(arm.pooled) for arm in arms]
    names = [arm.name for arm in arms]
    twins = side_by_side(names, pooled) if len(arms) >= 3 else None
    bodies = list(zip(names, pooled, strict=True))
    exchanges = tuple(named(arm.exchange, bodies) for arm in arms if arm.exchange is not None)
    return Fleet(arms, series, twins, exchanges, first)


def series_of(arm: Arm, first: str) -> list[Series]:
    """All quantities of an arm; ``first``: day of the fleet's first night, ISO."""
    days = np.array([_days(first, night.day) for night in arm.nights])
    series = []
    for name in arm.nights[0].numbers:
        values, sigma = np.array([night.numbers[name] for night in arm.nights]).T
        relative = " " not in name and name != MASS and parameter_kind(name) in _RELATIVE
        usual = float(np.median(values[:-1] if len(values) > 1 else values))
        size = max(abs(usual), 1e-12) if relative else 1.0
        series.append(Series(arm.name, name, relative, usual, days, (values - usual) / size, sigma / size))
    return series


def _days(first: str, day: str) -> float:
    """Days from one ISO date or time to another."""
    start, end = (datetime.fromisoformat(text).replace(tzinfo=None) for text in (first, day))
    return (end - start).total_seconds() / 86400.0
