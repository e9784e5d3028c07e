"""Figures of parameters by name: excitation and elimination."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ....common.arrays import Array
from ....common.schema import present
from ....estimation.fit.linear_problem import Excitation
from ....estimation.results.parts import EliminationDocument
from ..blocks import Drawing
from .canvas import BLUE, Axes, Figure, legend, log_scale, named, panels

GOOD = 10.0  # ten times the noise: 10 % relative sigma
_LEAST, _MOST = 1e-2, 1e9
_MOST_RATIO = 1.15
"""Above this ratio steps cancel what carries the arm; two of them are shown beyond where elimination ended."""
_MOST_SHOWN = 1e12  # larger numbers are left out


def named_panels(names: int, rows: int, **options: Any) -> tuple[Figure, list[Axes]]:
    """Panels one below the other, wide enough for so many names."""
    figure, axes = panels((max(0.18 * names + 1.2, 6.0), 2.5 * rows + 0.5), rows, **options)
    return figure, list(axes[:, 0])


def excitation_figure(excitation: Excitation, names: Sequence[str], known: str) -> Drawing:
    """Norm of each parameter's torque, whole and its own part; ``known``: which are well determined, in words."""
    caption = (
        "Norm of each parameter's torque over all equations, in units of the noise: whole (dash) and without what "
        "other parameters can imitate (dot). One over the dot is the relative standard deviation by (20), (21)."
    )

    def draw() -> Figure:
        figure, (axis,) = named_panels(len(names), 1)
        whole, own = (np.clip(x, _LEAST, _MOST) for x in (excitation.signal, excitation.independent))
        x = np.arange(len(names))
        axis.vlines(x, own, whole, color="0.6", linewidth=1.0)
        axis.plot(x, whole, "_", color="black", markersize=8, label="its torque")
        axis.plot(x, own, "o", color=BLUE, markersize=4, label="what no other parameter imitates")
        _limit(axis, GOOD, "relative sigma 10 %")
        axis.set_ylabel("torque over noise")
        log_scale(axis)
        named(axis, names)
        legend(figure, [axis])
        return figure

    return Drawing("excitation", caption, draw, f"{caption} {known}")


def elimination_figure(elimination: EliminationDocument, title: str, text: str) -> Drawing:
    """Error ratio and largest relative sigma against the parameters eliminated, in their order."""
    caption = (
        "Parameters are eliminated from left to right, each time the one with the largest relative standard "
        "deviation. Filled marks are steps that were taken."
    )
    essential, count, limit = elimination.essential, len(elimination.path) - 1, present(elimination.limit)

    def draw() -> Figure:
        gone = count - essential
        ratios = np.array([step.sigma_ratio for step in elimination.path], dtype=float)
        percents = np.array([step.largest_relative_sigma_percent for step in elimination.path], dtype=float)
        shown = min(max(int(np.sum(ratios <= _MOST_RATIO)), gone + 2), count)
        figure, (above, below) = named_panels(shown, 2, sharex=True)
        _steps(above, ratios[:shown], gone, "error sigma, ratio\nto all parameters")
        _steps(below, percents[:shown], gone, "largest relative\nsigma [%]")
        if limit is not None and elimination.rule == "ratio":
            _limit(above, limit, f"limit {limit:g}")
        elif limit is not None:
            _limit(below, 100.0 * limit, f"limit {100.0 * limit:g} %")
        above.legend(loc="upper left")
        log_scale(below)
        for axis in (above, below):
            named(axis, ["none", *(str(step.eliminated) for step in elimination.path[1:shown])])
        below.set_xlabel("eliminated, in this order")
        figure.suptitle(f"{title}: {essential} of {count} parameters essential")
        return figure

    return Drawing("essential_path", caption, draw, text)


def _limit(axis: Axes, value: float, label: str) -> None:
    axis.axhline(value, color="black", linestyle="--", linewidth=1.0)
    look: dict[str, Any] = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points", "fontsize": 8}
    axis.annotate(label, (1.0, value), xytext=(-4, 3), ha="right", **look)


def _steps(axis: Axes, values: Array, gone: int, label: str) -> None:
    """Line with filled markers up to ``gone`` and open ones after it: legible without colour."""
    # Data without noise reach any number: what no axis can show is left out.
    finite = np.where((values > 0.0) & (values < _MOST_SHOWN), values, np.nan)
    visible, steps = finite[np.isfinite(finite)], np.arange(len(values))
    if len(visible) and np.ptp(visible) == 0.0:
        axis.set_ylim(0.5 * visible[0], 2.0 * visible[0])
    axis.plot(steps, finite, color="0.5", linewidth=1.0)
    look: dict[str, Any] = {"color": "black", "markersize": 4}
    axis.plot(steps[: gone + 1], finite[: gone + 1], "o", label="taken", **look)
    axis.plot(steps[gone + 1 :], finite[gone + 1 :], "o", markerfacecolor="white", label="not taken", **look)
    axis.axvline(gone + 0.5, color="black", linestyle=":", linewidth=1.2)
    axis.set_ylabel(label)
