"""The payload as each joint sees it."""

from collections.abc import Sequence

import numpy as np

from ....estimation.payload.by_joints import ByJoints, JointShare, JointsMass
from ..blocks import Drawing
from .canvas import BLUE, Axes, Figure, mark_interval, panels, plain


def joints_figure(by_joints: ByJoints, mass: float, interval: tuple[float, float]) -> Drawing | None:
    """Mass by groups of joints, and the share of the payload that each joint shows; None where no joint sees it.

    Args:
        by_joints: the payload by joints.
        mass: recommended [kg].
        interval: its 95 % interval [kg]; nan where there is none.
    """
    if all(group.mass is None for group in by_joints.masses):
        return None
    text = "; ".join(
        f"{group.name} {group.mass:.4g} kg" if group.mass is not None else f"{group.name} does not see it"
        for group in by_joints.masses
    )
    caption = (
        "Left: the mass by the torques of some joints alone, with 95 % intervals; the dashed line and the band are "
        "the recommended mass. Right: the torque of each joint over what the payload seen by all others demands "
        "there, with two standard deviations; 1 where drive gain and friction are right."
    )
    return Drawing("by_joints", caption, f"{caption} {text}.", lambda: _drawn(by_joints, mass, interval))


def _drawn(by_joints: ByJoints, mass: float, interval: tuple[float, float]) -> Figure:
    size, edges = (9.0, 0.32 * len(by_joints.masses) + 1.2), (0.85, 0.1, 0.3, 0.3)
    figure, ((left, right),) = panels(size, 1, 2, edges, (0.85, 0.0), width_ratios=(3, 2))
    mark_interval(left, *interval)
    _masses(left, by_joints.masses, mass)
    _shares(right, by_joints.shares)
    for axis in (left, right):
        axis.set_ylim(len(by_joints.masses) - 0.5, -0.5)
        plain(axis)
    return figure


def _masses(axis: Axes, masses: Sequence[JointsMass], mass: float) -> None:
    axis.axvline(mass, color="black", linestyle="--", linewidth=1.0)
    reaches = []
    for row, group in enumerate(masses):
        if group.mass is None or group.interval95 is None:
            _words(axis, "not visible", mass, row)
            continue
        axis.plot(group.interval95, [row, row], color=BLUE, linewidth=2.0)
        axis.plot(group.mass, row, "s" if len(group.joints) > 1 else "o", color=BLUE, markersize=6)
        reaches.append(float(np.abs(np.array(group.interval95) - mass).max()))
    # One joint that hardly sees the mass must not squeeze the others to a line.
    reach = min(max(reaches), max(6.0 * float(np.median(reaches)), 0.1 * abs(mass)))
    axis.set_xlim(mass - 1.1 * reach, mass + 1.1 * reach)
    axis.set_yticks(range(len(masses)), [group.name for group in masses])
    axis.set_title("mass [kg]", fontsize=10)


def _shares(axis: Axes, shares: Sequence[JointShare]) -> None:
    axis.axvline(1.0, color="black", linestyle="--", linewidth=1.0)
    for row, entry in enumerate(shares):
        if entry.share is None:
            _words(axis, "not determined", 1.0, row)
            continue
        axis.plot(entry.share + 2.0 * entry.sigma * np.array([-1.0, 1.0]), [row, row], color=BLUE, linewidth=2.0)
        axis.plot(entry.share, row, "o", color=BLUE, markersize=6)
    axis.set_yticks(range(len(shares)), [f"joint {entry.joint}" for entry in shares])
    axis.set_title("share of the others' payload", fontsize=10)


def _words(axis: Axes, text: str, x: float, y: float) -> None:
    box = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
    axis.text(x, y, text, ha="center", va="center", fontsize=9, style="italic", bbox=box)
