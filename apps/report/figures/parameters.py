"""Figures of parameters: how well each was excited, and which are essential."""

from collections.abc import Mapping, Sequence

import numpy as np

from ....common.arrays import Array
from ....common.schema import present
from ....estimation.fit.least_squares import Excitation
from ....estimation.results.parts import EliminationDocument
from ..blocks import Drawing
from .canvas import BLUE, Axes, Figure, legend, lines_above, log_scale, names_below, panels, plain

_GOOD = 10.0  # ten times the noise: 10 % relative sigma
_LEAST, _MOST = 1e-2, 1e9
_PER_ROW = 40
_MOST_RATIO = 1.15
"""Above this ratio steps cancel what carries the arm; two of them are shown beyond where elimination ended."""
_MOST_SHOWN = 1e12
"""Larger numbers are left out."""


def excitation_figure(excitation: Excitation, labels: Mapping[str, str] | None = None) -> Drawing:
    """Each parameter's torque over the noise, whole and without what the others can imitate.

    Args:
        excitation: of every parameter.
        labels: name of a parameter -> how the figure calls it.
    """
    names = [(labels or {}).get(name, name) for name in excitation.names]
    weak = [name for name, value in zip(names, excitation.independent, strict=True) if value < _GOOD]
    caption = (
        "Norm of each parameter's torque over all equations, in units of the noise: whole (dash) and without what "
        "other parameters can imitate (dot). One over the dot is the relative standard deviation by (20), (21)."
    )
    known = f"Relative sigma above 10 %: {', '.join(weak)}." if weak else "All relative sigmas are below 10 %."
    return Drawing("excitation", caption, lambda: _draw_excitation(excitation, names), f"{caption} {known}")


def _draw_excitation(excitation: Excitation, names: Sequence[str]) -> Figure:
    rows = -(-len(names) // _PER_ROW)
    size = -(-len(names) // rows)
    longest = 0.075 * max(map(len, names))
    edges, gaps = (0.8, 0.1, 0.35, 0.2 + longest), (0.0, 0.3 + longest)
    figure, axes = panels((9.5, 2.3 * rows + 0.5), rows, 1, edges, gaps, sharey=True)
    for row, axis in enumerate(axes[:, 0]):
        part = slice(size * row, size * (row + 1))
        _excited(axis, names[part], excitation.signal[part], excitation.independent[part], size)
    log_scale(axes[0, 0])
    legend(figure, [axes[0, 0]], "upper center")
    return figure


def _excited(axis: Axes, names: Sequence[str], signal: Array, independent: Array, size: int) -> None:
    x = np.arange(len(names))
    whole, own = np.clip(signal, _LEAST, _MOST), np.clip(independent, _LEAST, _MOST)
    axis.vlines(x, own, whole, color="0.6", linewidth=1.0)
    axis.plot(x, whole, "_", color="black", markersize=8, label="its torque")
    axis.plot(x, own, "o", color=BLUE, markersize=4, label="the part no other parameter can imitate")
    axis.axhline(_GOOD, color="black", linestyle="--", linewidth=0.9)
    axis.annotate("relative sigma 10 %", (1.0, _GOOD), xycoords=("axes fraction", "data"), xytext=(0, 3),
                  textcoords="offset points", ha="right", fontsize=8)  # fmt: skip
    axis.set_xlim(-0.8, size - 0.2)
    axis.set_ylabel("torque over noise")
    plain(axis)
    names_below(axis, names, 8)


def essential_figure(elimination: EliminationDocument, title: str) -> Drawing:
    """Error ratio and largest relative sigma against the parameters eliminated, in their order.

    Legible without colour: filled markers are steps that were taken, open ones those that were not.
    """
    essential, count = elimination.essential, len(elimination.path) - 1
    text = (
        f"{essential} of {count} parameters are essential: {elimination.description}. With them the error's "
        f"standard deviation is {elimination.sigma_ratio:.4f} times that with all; the largest relative standard "
        f"deviation is {elimination.largest_relative_sigma_percent:.3g} %."
    )
    caption = (
        "Parameters are eliminated from left to right, each time the one with the largest relative standard "
        "deviation. Filled marks are steps that were taken."
    )
    return Drawing("essential_path", caption, lambda: _draw_path(elimination, title), text)


def _draw_path(elimination: EliminationDocument, title: str) -> Figure:
    count = len(elimination.path) - 1
    gone = count - elimination.essential
    ratios = np.array([step.sigma_ratio for step in elimination.path], dtype=float)
    percents = np.array([step.largest_relative_sigma_percent for step in elimination.path], dtype=float)
    shown = min(max(int(np.sum(ratios <= _MOST_RATIO)), gone + 2), count)
    names = ["none", *(str(step.eliminated) for step in elimination.path[1:shown])]
    edges = (1.0, 0.1, 0.4, 0.4 + 0.07 * max(map(len, names)))
    figure, axes = panels((max(6.0, 0.19 * shown + 1.5), 5.2), 2, 1, edges)
    above, below = axes[:, 0]
    _curve(above, ratios[:shown], gone)
    above.set_ylabel("error sigma, ratio\nto all parameters")
    _curve(below, percents[:shown], gone)
    below.set_ylabel("largest relative\nsigma [%]")
    limit = present(elimination.limit)
    if limit is not None and elimination.rule == "ratio":
        _limit(above, limit, f"limit {limit:g}")
    elif limit is not None:
        _limit(below, 100.0 * limit, f"limit {100.0 * limit:g} %")
    above.legend(loc="upper left")
    log_scale(below)
    above.set_xticks([])
    lines_above(above, shown)
    names_below(below, names, 7)
    below.set_xlabel("eliminated, in this order")
    figure.suptitle(f"{title}: {elimination.essential} of {count} parameters essential")
    return figure


def _limit(axis: Axes, value: float, label: str) -> None:
    axis.axhline(value, color="black", linestyle="--", linewidth=1.0)
    axis.annotate(
        label,
        (0.0, value),
        xycoords=("axes fraction", "data"),
        xytext=(4, 3),
        textcoords="offset points",
        ha="left",
    )


def _curve(axis: Axes, values: np.ndarray[tuple[int, ...], np.dtype[np.float64]], gone: int) -> None:
    """Line with filled markers up to ``gone`` and open ones after it."""
    steps = np.arange(len(values))
    # Data without noise reach any number: what no axis can show is left out.
    finite = np.where((values > 0.0) & (values < _MOST_SHOWN), values, np.nan)
    visible = finite[np.isfinite(finite)]
    if len(visible) and np.ptp(visible) == 0.0:
        axis.set_ylim(0.5 * visible[0], 2.0 * visible[0])
    axis.plot(steps, finite, color="0.5", linewidth=1.0)
    in_path = steps <= gone
    axis.plot(steps[in_path], finite[in_path], "o", color="black", markersize=4, label="taken")
    axis.plot(
        steps[~in_path],
        finite[~in_path],
        "o",
        color="black",
        markerfacecolor="white",
        markersize=4,
        label="not taken",
    )
    axis.axvline(gone + 0.5, color="black", linestyle=":", linewidth=1.2)
    axis.set_xlim(-1.0, len(values))
    axis.grid(visible=True, alpha=0.3)
