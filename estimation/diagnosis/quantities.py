"""Quantity by quantity: whether mass, centre of mass and inertia were measured well enough to be used."""

from typing import Literal, NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model.inertia import PayloadSpread
from ..fit.covariance import few_blocks

MASS_SIGMA = 0.05
"""Relative standard deviation of the mass above which nothing should be used."""
COM_SIGMA, COM_FLOOR = 0.3, 0.02
"""Standard deviation of the centre of mass, of the payload's own size, above which it should not be used; one known
to the second [m] is good whatever the payload's size."""
INERTIA_SIGMA = 0.30
"""Relative standard deviation of a moment of inertia at the centre of mass above which it should not be used."""
Use = Literal["use", "not measured well enough", "not visible", "weighed", "assumed"]
"""``weighed``: not by torques, by a scale."""


class Judged(NamedTuple):
    """Use of one quantity, and why; empty where it may be used without more."""

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


def judge_mass(mass: float, spread: PayloadSpread, from_scale: bool) -> Judged:
    """Judge the mass."""
    relative = spread.mass / max(abs(mass), 1e-300)
    if from_scale:
        return Judged("weighed", "the torques of these joints do not contain it")
    if relative <= MASS_SIGMA:
        return Judged("use")
    advice = "let joint 2 or 3 move, widen the range, record longer, or weigh the payload"
    return _vague(f"is {_percent(relative)} of it", f"{100 * MASS_SIGMA:.0f} %", advice)


def judge_com(ten: Array, spread: PayloadSpread) -> Judged:
    """Judge the centre of mass: to 20 mm, or 0.3 of the payload's radius of gyration about the frame's origin.

    Args:
        ten: the payload's parameters, nan where they are not known, shape (10,).
        spread: standard deviations, infinite where the joints show nothing.
    """
    hidden = [axis for axis, sigma in zip("xyz", spread.com, strict=True) if not np.isfinite(sigma)]
    if hidden:
        return Judged("not visible", f"these joints do not show {', '.join(hidden)}")
    known = bool(np.isfinite(ten).all() and ten[9] > 0.0)
    size = float(np.sqrt(max(ten[[0, 3, 5]].sum(), 0.0) / 2.0 / ten[9])) if known else 0.0
    worst, allowed = int(np.argmax(spread.com)), max(COM_FLOOR, COM_SIGMA * size)
    if spread.com[worst] <= allowed:
        return Judged("use")
    sigma = f"along {'xyz'[worst]} is {1e3 * spread.com[worst]:.0f} mm"
    return _vague(sigma, f"{1e3 * allowed:.0f} mm", "turn the wrist farther, or weigh the payload")


def judge_inertia(moments: Array, spread: PayloadSpread) -> Judged:
    """Judge the inertia at the centre of mass: each moment to 30 %."""
    relative = dict(zip(("XX", "YY", "ZZ"), spread.moments / np.maximum(moments, 1e-300), strict=True))
    hidden = [name for name, s in zip(relative, spread.moments, strict=True) if not np.isfinite(s)]
    if hidden:
        return Judged("not visible", f"these joints do not show {', '.join(hidden)}")
    vague = [f"{name} {_percent(s)}" for name, s in relative.items() if not s <= INERTIA_SIGMA]
    if not vague:
        return Judged("use")
    advice = "move the wrist faster, or give its size by --inertia"
    return _vague(f"of {', '.join(vague)}", f"{100 * INERTIA_SIGMA:.0f} %", advice)


def _vague(sigma: str, allowed: str, advice: str) -> Judged:
    why = f"1 sigma (few blocks of time allowed for) {sigma}, {allowed} at most are allowed: {advice}"
    return Judged("not measured well enough", why)


def _percent(part: float) -> str:
    return f"{100 * part:.0f} %" if part < 10.0 else "more than tenfold its size"
