"""Errors of predicted motion against the time after the start."""

import numpy as np

from ...rollout import Rollout
from ..blocks import Drawing
from .canvas import BLUE, GREY, ORANGE, Figure, log_scale, panels, plain

_STYLES = ((BLUE, "-"), (ORANGE, "--"), (GREY, ":"), ("black", "-."))


def rollout_figure(rollout: Rollout, name: str, unit: tuple[str, float]) -> Drawing:
    """Median and 90 % of the starts by each prediction, in a unit of some size; ``name``: of the drawing."""
    caption = (
        f"Distance of predicted from measured motion on {rollout.source}, root mean square over the joints: median "
        "of the starts, shaded up to 90 %."
    )
    return Drawing(name, caption, caption, lambda: _curves(rollout, unit))


def _curves(rollout: Rollout, unit: tuple[str, float]) -> Figure:
    figure, axes = panels((5.8, 3.2))
    axis = axes[0, 0]
    resting = bool(rollout.resting.all())
    for (by, _), (color, line) in zip(rollout.errors.items(), _STYLES, strict=False):
        spreads = [rollout.spread(by, float(seconds), resting) for seconds in rollout.times]
        low, high = np.array([spread for spread in spreads if spread is not None]).T / unit[1]
        axis.plot(rollout.times, low, color=color, linestyle=line, label=by)
        axis.fill_between(rollout.times, low, high, color=color, alpha=0.2, linewidth=0)
    log_scale(axis)
    axis.set_xlabel("time after the start [s]")
    axis.set_ylabel(f"error [{unit[0]}]")
    axis.legend(fontsize=9, frameon=False)
    plain(axis)
    return figure
