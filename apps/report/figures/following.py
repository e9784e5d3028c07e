"""What a controller missed before and after a payload was entered."""

import numpy as np

from ...logs.following import FollowingChange
from ..blocks import Drawing
from .canvas import BLUE, GREY, Figure, panels, plain


def following_figure(change: FollowingChange, unit: str, scale: float) -> Drawing:
    """Root mean square of each joint before and after, in a unit of which ``scale`` make one of SI."""
    caption = f"Root mean square of the {change.kind} before and after the number was entered, with 95 % intervals."
    return Drawing("following", caption, caption, lambda: _bars(change, unit, scale))


def _bars(change: FollowingChange, unit: str, scale: float) -> Figure:
    figure, axes = panels((6.4, 3.2), edges=(0.75, 0.15, 0.35, 0.5))
    axis, rows = axes[0, 0], (*change.joints, change.total)
    places = np.arange(len(rows))
    before, after = (scale * np.array([getattr(row, when) for row in rows]) for when in ("before", "after"))
    # The interval is that of the share by which it fell.
    ends = before * (1.0 - np.array([row.interval for row in rows])).T
    reach = np.nan_to_num(np.maximum([after - ends[1], ends[0] - after], 0.0))
    axis.bar(places - 0.2, before, 0.38, color=GREY, label="before")
    axis.bar(places + 0.2, after, 0.38, color=BLUE, hatch="//", label="after", yerr=reach, capsize=3)
    axis.set_xticks(places, [row.name for row in rows])
    axis.set_ylabel(f"root mean square [{unit}]")
    axis.legend(fontsize=9, frameon=False)
    plain(axis)
    return figure
