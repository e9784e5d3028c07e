"""Quantity by quantity: whether mass, centre of mass and inertia were measured well enough to be used."""

from typing import Literal, NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model.inertia import PayloadSpread
from ..fit.robust import few_blocks

MASS_SIGMA = 0.05
"""Relative standard deviation of the mass above which nothing should be used."""
COM_SIGMA, COM_FLOOR = 0.3, 0.02
"""Standard deviation of the centre of mass, of the payload's own size, above which it should not be used; one known
to the second [m] is good whatever the payload's size."""
INERTIA_SIGMA = 0.30
"""Relative standard deviation of a moment of inertia at the centre of mass above which it should not be used."""
Use = Literal["use", "not measured well enough", "not visible", "weighed", "assumed"]
"""``weighed``: not by torques, by a scale."""
_COUNTED = " (few blocks of time allowed for)"
_VAGUE: Use = "not measured well enough"


class Judged(NamedTuple):
    """Whether one quantity may be used, and why; empty where it may without more."""

    use: Use
    why: str = ""


class Agreement(NamedTuple):
    """Another way to the mass [kg] and the centre of mass [m], nan where it gives none.

    ``counts``: whether a large difference speaks against the numbers.
    """

    name: str
    mass: float
    com: Array
    counts: bool = True


def allowing(spread: PayloadSpread, degrees_of_freedom: float) -> PayloadSpread:
    """Half a 95 % interval over 1.96, by which quantities are judged: more than 1 sigma if blocks are few."""
    factor = few_blocks(degrees_of_freedom)
    return PayloadSpread(factor * spread.mass, factor * spread.com, factor * spread.inertia_com)


def com_allowed(ten: Array) -> tuple[float, float]:
    """Size of a payload [m], and the largest good standard deviation of its centre of mass [m].

    Args:
        ten: its parameters, nan where they are not known, shape (10,). The size is the radius of gyration about the
            frame's origin; 0 where they do not tell it.
    """
    size = 0.0
    if np.isfinite(ten).all() and ten[9] > 0.0:
        size = float(np.sqrt(max(ten[[0, 3, 5]].sum(), 0.0) / 2.0 / ten[9]))
    return size, max(COM_FLOOR, COM_SIGMA * size)


def vague_moments(moments: Array, sigma: Array) -> list[tuple[str, float]]:
    """Moments of inertia that are known to less than 30 %, with the relative standard deviation of each."""
    relative = sigma / np.maximum(moments, 1e-300)
    return [(f"{a}{a}", float(s)) for a, s in zip("XYZ", relative, strict=True) if not s <= INERTIA_SIGMA]


def judge_mass(mass: float, spread: PayloadSpread, from_scale: bool) -> Judged:
    """Judge the mass."""
    if from_scale:
        return Judged("weighed", "the torques of these joints do not contain it")
    relative = spread.mass / max(abs(mass), 1e-300)
    if relative <= MASS_SIGMA:
        return Judged("use")
    why = f"1 sigma{_COUNTED} is {percent(relative)} of it, {100 * MASS_SIGMA:.0f} % at most are allowed"
    return Judged(_VAGUE, f"{why}: let joint 2 or 3 move, widen the range, record longer, or weigh the payload")


def judge_com(ten: Array, spread: PayloadSpread) -> Judged:
    """Judge the centre of mass: to 20 mm, or 0.3 of the payload's own size where that is more."""
    hidden = [axis for axis, sigma in zip("xyz", spread.com, strict=True) if not np.isfinite(sigma)]
    if hidden:
        return Judged("not visible", f"these joints do not show {', '.join(hidden)}")
    worst, allowed = int(np.argmax(spread.com)), com_allowed(ten)[1]
    if spread.com[worst] <= allowed:
        return Judged("use")
    why = (
        f"1 sigma{_COUNTED} along {'xyz'[worst]} is {1e3 * spread.com[worst]:.0f} mm, {1e3 * allowed:.0f} mm at "
        "most"
    )
    return Judged(_VAGUE, f"{why} are allowed: turn the wrist farther, or weigh the payload")


def judge_inertia(moments: Array, spread: PayloadSpread) -> Judged:
    """Judge the inertia at the centre of mass: each moment to 30 %."""
    hidden = [f"{a}{a}" for a, sigma in zip("XYZ", spread.moments, strict=True) if not np.isfinite(sigma)]
    if hidden:
        return Judged("not visible", f"these joints do not show {', '.join(hidden)}")
    vague = [f"{name} {percent(relative)}" for name, relative in vague_moments(moments, spread.moments)]
    if not vague:
        return Judged("use")
    why = f"1 sigma{_COUNTED} of {', '.join(vague)}, {100 * INERTIA_SIGMA:.0f} % at most are allowed"
    return Judged(_VAGUE, f"{why}: move the wrist faster, or give its size by --inertia")


def percent(part: float) -> str:
    """Write a fraction, however large."""
    return f"{100 * part:.0f} %" if part < 10.0 else "more than tenfold its size"
