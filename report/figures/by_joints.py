"""The payload as each joint sees it."""

from __future__ import annotations

import numpy as np

from ...estimation import ByJoints
from .canvas import BLUE, Drawing, new_figure, plain


def joints_figure(found: ByJoints, mass: float, interval: tuple[float, float]) -> Drawing | None:
    """Mass by groups of joints, and the share of the payload that each joint shows; None where no joint sees it.

    Args:
        found: the payload by joints.
        mass: recommended [kg].
        interval: its 95 % interval [kg]; nan where there is none.
    """
    seen = [one for one in found.masses if one.mass is not None]
    if not seen:
        return None
    names = [one.name for one in found.masses]
    figure = new_figure(9.0, 0.32 * len(names) + 1.2)
    left, right = figure.subplots(1, 2, width_ratios=(3, 2))
    if np.isfinite(interval).all():
        left.axvspan(*interval, facecolor="0.9", edgecolor="0.7", hatch="//", linewidth=0.0)
    left.axvline(mass, color="black", linestyle="--", linewidth=1.0)
    widths = []
    for row, one in enumerate(found.masses):
        if one.mass is None or one.interval95 is None:
            left.annotate("not visible", (mass, row), ha="center", va="center", fontsize=9, style="italic")
            continue
        left.plot(one.interval95, [row, row], color=BLUE, linewidth=2.0)
        left.plot(one.mass, row, "s" if len(one.joints) > 1 else "o", color=BLUE, markersize=6)
        widths.append(abs(np.array(one.interval95) - mass).max())
    # One joint that hardly sees the mass must not squeeze the others to a line.
    reach = min(max(widths), max(6.0 * float(np.median(widths)), 0.1 * abs(mass)))
    left.set_xlim(mass - 1.1 * reach, mass + 1.1 * reach)
    left.set_yticks(range(len(names)), names)
    left.set_ylim(len(names) - 0.5, -0.5)
    left.set_title("mass [kg]", fontsize=10)
    plain(left)
    for one in found.shares:
        if one.share is not None:
            row = one.joint - 1
            right.plot([one.share - 1.96 * one.sigma, one.share + 1.96 * one.sigma], [row, row], color=BLUE, lw=2.0)
            right.plot(one.share, row, "o", color=BLUE, markersize=6)
        else:
            right.annotate("not determined", (1.0, one.joint - 1), ha="center", va="center", fontsize=9, style="italic")
    right.axvline(1.0, color="black", linestyle="--", linewidth=1.0)
    right.set_yticks(range(len(found.shares)), [f"joint {one.joint}" for one in found.shares])
    right.set_ylim(len(names) - 0.5, -0.5)
    right.set_title("share of the others' payload", fontsize=10)
    plain(right)
    text = "; ".join(
        f"{one.name} {one.mass:.4g} kg" if one.mass is not None else f"{one.name} does not see it"
        for one in found.masses
    )
    caption = (
        "Left: the mass by the torques of some joints alone, with 95 % intervals; the dashed line and the band are "
        "the recommended mass. Right: the torque of each joint over what the payload seen by all others demands "
        "there; 1 where drive gain and friction are right."
    )
    return Drawing("by_joints", figure, caption, f"{caption} {text}.")
