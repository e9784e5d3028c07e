"""Whether all recordings under an arm's name are of one robot.

Friction, payload and a drive's scale change in the life of an arm, its bodies do not. The inertial parameters of
each night are freed of all that a payload or a drive's scale does to them; what is left is compared by the analysis
of variance: one night against all others, and the nights since one day against those before.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.linalg import null_space
from scipy.special import chdtrc

from ...common.arrays import Array
from ...estimation.fit.estimate import Estimate
from .comparing import CHANCE


class Bodies(NamedTuple):
    """What no payload and no drive's scale changes: ``values``, shape (r,), and their ``covariance``, r x r."""

    values: Array
    covariance: Array


@dataclass(frozen=True, eq=False)
class Exchange:
    """Recordings under an arm's name that are of another robot.

    Attributes:
        arm: that name.
        day: of the one recording, or of the first of them.
        alone: whether it is that one recording.
        chi2: by which it differs, over what the others differ by among themselves.
        degrees: of freedom.
        left: what makes ``bodies`` of inertial parameters, r x c.
        bodies: of these recordings.
        like: name of an arm of the fleet that they may be of, empty without.
    """

    arm: str
    day: str
    alone: bool
    chi2: float
    degrees: int
    left: Array
    bodies: Bodies
    like: str = ""


def exchange_of(arm: str, days: Sequence[str], nights: Sequence[Estimate], explained: Array) -> Exchange | None:
    """The recordings that are most clearly of another robot; None where all may be of one.

    Args:
        arm: its name.
        days: of the recordings, in the order of time.
        nights: inertial parameters of each, c of them.
        explained: changes of these that a payload or a drive's scale makes, shape (c, k).
    """
    if len(nights) < 2:
        return None
    scale = nights[0].sigma
    left = null_space((explained / scale[:, None]).T).T / scale
    if not len(left):
        return None
    freed = [_freed(night, left) for night in nights]
    sizes = [(_apart(freed, others), others) for others in _splits(len(nights))]
    size, others = max(sizes, key=lambda split: split[0])
    if chdtrc(len(left), size) * len(sizes) > CHANCE:
        return None
    bodies = _pooled([freed[k] for k in others])
    return Exchange(arm, days[others[0]], len(others) == 1, size, len(left), left, bodies)


def named(exchange: Exchange, arms: Sequence[tuple[str, Estimate]]) -> Exchange:
    """An exchange with the arm that its recordings may be of; ``arms``: inertial parameters by name."""
    for arm, pooled in arms:
        without = _freed(pooled, exchange.left)
        if (
            arm != exchange.arm
            and chdtrc(
                exchange.degrees,
                _chi2(exchange.bodies.values - without.values, exchange.bodies.covariance + without.covariance),
            )
            > CHANCE
        ):
            return replace(exchange, like=arm)
    return exchange


def _freed(estimate: Estimate, left: Array) -> Bodies:
    return Bodies(left @ estimate.values, left @ estimate.covariance @ left.T)


def _splits(count: int) -> Iterator[list[int]]:
    """Nights that may be of another robot: each alone, and all since each."""
    yield from ([k] for k in range(count if count > 2 else 1, 0, -1) if k < count)
    if count > 2:
        yield [0]
    yield from (list(range(k, count)) for k in range(1, count - 1))


def _apart(nights: Sequence[Bodies], others: Sequence[int]) -> float:
    """Chi2 between two groups of nights, over that of the nights within their groups where it is above 1."""
    rest = [k for k in range(len(nights)) if k not in others]
    groups = [[nights[k] for k in group] for group in (others, rest)]
    first, second = (_pooled(group) for group in groups)
    within = sum(
        _chi2(night.values - mean.values, night.covariance)
        for group, mean in zip(groups, (first, second), strict=True)
        for night in group
    )
    degrees = (len(nights) - 2) * len(first.values)
    excess = max(1.0, within / degrees) if degrees else 1.0
    return _chi2(first.values - second.values, first.covariance + second.covariance) / excess


def _chi2(change: Array, covariance: Array) -> float:
    return float(change @ np.linalg.solve(covariance, change))


def _pooled(nights: Sequence[Bodies]) -> Bodies:
    information = [np.linalg.inv(night.covariance) for night in nights]
    covariance = np.linalg.inv(np.sum(information, axis=0))
    weighted_sum = np.sum(
        [inverse @ night.values for inverse, night in zip(information, nights, strict=True)], axis=0
    )
    return Bodies(covariance @ weighted_sum, covariance)
