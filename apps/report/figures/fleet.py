"""Small multiples of a fleet: a line an arm, a panel a joint, the friction day by day."""

from collections.abc import Sequence
from datetime import datetime, timedelta
from functools import partial

from ...fleet import Fleet
from ...fleet.nights import CHANGED, Series
from ..blocks import Drawing
from .canvas import BLUE, GREY, ORANGE, Axes, Figure, panels

_LINES = 20
"""Arms in one drawing."""


def fleet_figures(fleet: Fleet, kind: str, name: str, words: str) -> list[Drawing]:
    """Drawings of one kind of quantity, so many arms each.

    Args:
        fleet: what its nights say.
        kind: how the quantities begin, "FS"; or the one quantity.
        name: of the drawings.
        words: what the quantity is.
    """
    arms = [arm.name for arm in fleet.arms]
    caption = (
        f"{words}: a line an arm, a panel a quantity, day by day, less the median of the nights before the last. "
        "The band is what varies anyway (2 sigma); orange is a change."
    )
    parts = enumerate((arms[k : k + _LINES] for k in range(0, len(arms), _LINES)), 1)
    return [Drawing(f"{name}_{k}", caption, partial(_multiples, fleet, part, kind)) for k, part in parts]


def _multiples(fleet: Fleet, arms: Sequence[str], kind: str) -> Figure:
    rows = {
        arm: [line for line in fleet.series if (line.arm, line.quantity[: len(kind)]) == (arm, kind)]
        for arm in arms
    }
    columns = max(len(row) for row in rows.values())
    size = (1.1 + 1.05 * columns, 0.55 + 0.48 * len(arms))
    figure, axes = panels(size, len(arms), columns, (1.0, 0.1, 0.3, 0.25), (0.1, 0.08), sharex=True, sharey="col")
    for line, (arm, row) in zip(axes, rows.items(), strict=True):
        for axis, series in zip(line, row, strict=False):
            _spark(axis, series)
        line[0].set_ylabel(arm, rotation=0, ha="right", va="center", fontsize=8)
    for axis, series in zip(axes[0], rows[arms[0]], strict=False):
        axis.set_title(series.quantity, fontsize=8)
    return figure


def _spark(axis: Axes, series: Series) -> None:
    """One quantity of one arm: points, a band, and the last night where it changed."""
    size = 100.0 if series.relative else 1.0
    values, band = size * series.changes, 2.0 * size * series.spread
    dates = [datetime.fromisoformat(day).replace(tzinfo=None) for day in series.days]
    days = [(date - datetime(2000, 1, 1)) / timedelta(days=1) for date in dates]
    axis.axhspan(-band, band, color="0.92", linewidth=0)
    axis.plot(days, values, color=GREY, linewidth=0.6)
    axis.plot(days, values, ".", color=BLUE, markersize=2)
    if series.z is not None and abs(series.z) > CHANGED:
        axis.plot(days[-1:], values[-1:], "s", color=ORANGE, markersize=2.5)
    axis.set_xticks([])
    axis.set_yticks([])
    axis.spines[:].set_visible(False)
