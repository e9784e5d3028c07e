"""The payload as each joint sees it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.payload import ByJoints, JointShare, JointsMass
from .canvas import BLUE, Drawing, new_figure, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def joints_figure(found: ByJoints, mass: float, interval: tuple[float, float]) -> Drawing | None:
    """Mass by groups of joints, and the share of the payload that each joint shows; None where no joint sees it.

    Args:
        found: the payload by joints.
        mass: recommended [kg].
        interval: its 95 % interval [kg]; nan where there is none.
    """
    if all(one.mass is None for one in found.masses):
        return None
    figure = new_figure(9.0, 0.32 * len(found.masses) + 1.2)
    left, right = figure.subplots(1, 2, width_ratios=(3, 2))
    if np.isfinite(interval).all():
        left.axvspan(*interval, facecolor="0.9", edgecolor="0.7", hatch="//", linewidth=0.0)
    _masses(left, found.masses, mass)
    _shares(right, found.shares)
    for axis in (left, right):
        axis.set_ylim(len(found.masses) - 0.5, -0.5)
        plain(axis)
    text = "; ".join(
        f"{one.name} {one.mass:.4g} kg" if one.mass is not None else f"{one.name} does not see it"
        for one in found.masses
    )
    caption = (
        "Left: the mass by the torques of some joints alone, with 95 % intervals; the dashed line and the band are "
        "the recommended mass. Right: the torque of each joint over what the payload seen by all others demands "
        "there, with two standard deviations; 1 where drive gain and friction are right."
    )
    return Drawing("by_joints", figure, caption, f"{caption} {text}.")


def _masses(axis: Axes, masses: Sequence[JointsMass], mass: float) -> None:
    axis.axvline(mass, color="black", linestyle="--", linewidth=1.0)
    reaches = []
    for row, one in enumerate(masses):
        if one.mass is None or one.interval95 is None:
            _words(axis, "not visible", mass, row)
            continue
        axis.plot(one.interval95, [row, row], color=BLUE, linewidth=2.0)
        axis.plot(one.mass, row, "s" if len(one.joints) > 1 else "o", color=BLUE, markersize=6)
        reaches.append(float(np.abs(np.array(one.interval95) - mass).max()))
    # One joint that hardly sees the mass must not squeeze the others to a line.
    reach = min(max(reaches), max(6.0 * float(np.median(reaches)), 0.1 * abs(mass)))
    axis.set_xlim(mass - 1.1 * reach, mass + 1.1 * reach)
    axis.set_yticks(range(len(masses)), [one.name for one in masses])
    axis.set_title("mass [kg]", fontsize=10)


def _shares(axis: Axes, shares: Sequence[JointShare]) -> None:
    axis.axvline(1.0, color="black", linestyle="--", linewidth=1.0)
    for row, one in enumerate(shares):
        if one.share is None:
            _words(axis, "not determined", 1.0, row)
            continue
        axis.plot(one.share + 2.0 * one.sigma * np.array([-1.0, 1.0]), [row, row], color=BLUE, linewidth=2.0)
        axis.plot(one.share, row, "o", color=BLUE, markersize=6)
    axis.set_yticks(range(len(shares)), [f"joint {one.joint}" for one in shares])
    axis.set_title("share of the others' payload", fontsize=10)


def _words(axis: Axes, text: str, x: float, y: float) -> None:
    box = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
    axis.text(x, y, text, ha="center", va="center", fontsize=9, style="italic", bbox=box)
