"""Quantity by quantity: whether mass, centre of mass and inertia were measured well enough to be used."""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model.payload_spread import PayloadSpread
from ..diagnosis.verdict.inertia import INERTIA_SIGMA
from ..diagnosis.verdict.mass import COM_FLOOR, COM_SIGMA, MASS_SIGMA
from ..fit.robust import few_blocks

Use = Literal["use", "not measured well enough", "not visible", "weighed", "assumed"]
"""``weighed``: not by torques, by a scale."""
USABLE: tuple[Use, ...] = ("use", "weighed", "assumed")
"""What may be typed in."""
_COUNTED = " (few blocks of time allowed for)"


def allowing(spread: PayloadSpread, degrees_of_freedom: float) -> PayloadSpread:
    """What quantities are judged by: half a 95 % interval over 1.96, more than 1 sigma if blocks are few."""
    factor = few_blocks(degrees_of_freedom)
    return PayloadSpread(factor * spread.mass, factor * spread.com, factor * spread.inertia_com)


class Agreement(NamedTuple):
    """Another way to the mass [kg] and the centre of mass [m], nan where it gives none."""

    name: str
    mass: float
    com: Array


@dataclass(frozen=True)
class Judged:
    """One quantity.

    Attributes:
        use: whether it may be used.
        why: in words; empty where it may without more.
    """

    use: Use
    why: str = ""


def judge_mass(mass: float, spread: PayloadSpread, from_scale: bool) -> Judged:
    """The mass."""
    if from_scale:
        return Judged("weighed", "the torques of these joints do not contain it")
    share = spread.mass / max(abs(mass), 1e-300)
    if share <= MASS_SIGMA:
        return Judged("use")
    return Judged(
        "not measured well enough",
        f"1 sigma{_COUNTED} is {_percent(share)} of it, {100 * MASS_SIGMA:.0f} % at most are allowed: let joint "
        "2 or 3 move, widen the range, record longer, or weigh the payload",
    )


def judge_com(values: Array, spread: PayloadSpread) -> Judged:
    """The centre of mass: to 20 mm, or 0.3 of the payload's own size where that is more."""
    hidden = [axis for axis, sigma in zip("xyz", spread.com, strict=True) if not np.isfinite(sigma)]
    if hidden:
        return Judged("not visible", f"these joints do not show {', '.join(hidden)}")
    size = 0.0
    if np.isfinite(values).all() and values[9] > 0.0:
        size = float(np.sqrt(max(values[[0, 3, 5]].sum(), 0.0) / 2.0 / values[9]))
    worst = int(np.argmax(spread.com))
    allowed = max(COM_FLOOR, COM_SIGMA * size)
    if spread.com[worst] <= allowed:
        return Judged("use")
    return Judged(
        "not measured well enough",
        f"1 sigma{_COUNTED} along {'xyz'[worst]} is {1e3 * spread.com[worst]:.0f} mm, {1e3 * allowed:.0f} mm at "
        "most are allowed: turn the wrist farther, or weigh the payload",
    )


def judge_inertia(moments: Array, spread: PayloadSpread) -> Judged:
    """The inertia at the centre of mass: each moment to 30 %."""
    hidden = [f"{a}{a}" for a, sigma in zip("XYZ", spread.moments, strict=True) if not np.isfinite(sigma)]
    if hidden:
        return Judged("not visible", f"these joints do not show {', '.join(hidden)}")
    share = spread.moments / np.maximum(moments, 1e-300)
    vague = [f"{'XYZ'[k]}{'XYZ'[k]} {_percent(share[k])}" for k in range(3) if not share[k] <= INERTIA_SIGMA]
    if not vague:
        return Judged("use")
    return Judged(
        "not measured well enough",
        f"1 sigma{_COUNTED} of {', '.join(vague)}, {100 * INERTIA_SIGMA:.0f} % at most are allowed: move the wrist "
        "faster, or give its size by --inertia",
    )


def with_scale(values: Array, covariance: Array, places: tuple[int, ...], sigma: float, mass: float) -> Array:
    """Values and covariance once the scale counts too, k x (k + 1): values in the first column."""
    k = places.index(9)
    gain = covariance[:, k] / (covariance[k, k] + sigma**2)
    return np.column_stack([values + gain * (mass - values[k]), covariance - np.outer(gain, covariance[k])])


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share < 10.0 else "more than tenfold its size"
