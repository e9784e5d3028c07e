"""Parameters of a fit: how well each was excited, and which are essential; numbers and figures."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ....common.arrays import Array
from ....common.schema import present
from ....estimation.fit.least_squares import Excitation
from ....estimation.results.parts import EliminationDocument
from ...numbers import percent
from ..blocks import Block, Details, Drawing, Notes, OnPage, Section, Table, Text
from ..figures.canvas import BLUE, Axes, Figure, legend, lines_above, log_scale, names_below, panels, plain

_GOOD = 10.0  # ten times the noise: 10 % relative sigma
_LEAST, _MOST = 1e-2, 1e9
_PER_ROW = 40
_MOST_RATIO = 1.15
"""Above this ratio steps cancel what carries the arm; two of them are shown beyond where elimination ended."""
_MOST_SHOWN = 1e12
"""Larger numbers are left out."""


def excitation_section(make: Callable[[], Excitation | None], labels: Mapping[str, str]) -> Section:
    """A figure, and the numbers to be opened; ``labels`` are shown in the place of parameters' names."""

    def shown() -> list[Block]:
        excitation = make()
        if excitation is None:
            text = (
                "The robot's parameters were read from a file, without the equations they come from: what its "
                "motion excited stands in the report of that identification."
            )
            return [Text(text)]
        names, weak, rows = [labels.get(name, name) for name in excitation.names], list[str](), []
        numbers = zip(names, excitation.signal, excitation.independent, excitation.share, strict=True)
        for name, signal, own, ratio in numbers:
            relative = percent(1.0 / float(own) if own else float("inf"))
            rows.append((name, f"{signal:.3g}", f"{own:.3g}", percent(float(ratio)), relative))
            weak += [name] if own < _GOOD else []
        text = (
            "A parameter is well known where its torque is large against the noise and no combination of others "
            "imitates it. Sigmas here are the formula's, for white noise; a small value of a parameter makes them "
            "large too."
        )
        caption = (
            "Norm of each parameter's torque over all equations, in units of the noise: whole (dash) and without "
            "what other parameters can imitate (dot). One over the dot is the relative standard deviation by (20), "
            "(21)."
        )
        known = f"Relative sigma above 10 %: {', '.join(weak)}." if weak else "All relative sigmas are below 10 %."
        figure = Drawing("excitation", caption, lambda: _draw_excitation(excitation, names), f"{caption} {known}")
        headings = ("", "torque over noise", "its own part", "share", "relative sigma")
        return [Text(text), figure, Details("Numbers", [Table("Excitation", headings, rows)])]

    return Section("excitation", "Excitation of each parameter", [OnPage(shown)])


def _draw_excitation(excitation: Excitation, names: list[str]) -> Figure:
    rows = -(-len(names) // _PER_ROW)
    size, longest = -(-len(names) // rows), 0.075 * max(map(len, names))
    edges, gaps = (0.8, 0.1, 0.35, 0.2 + longest), (0.0, 0.3 + longest)
    figure, axes = panels((9.5, 2.3 * rows + 0.5), rows, 1, edges, gaps, sharey=True)
    whole, own = (np.clip(x, _LEAST, _MOST) for x in (excitation.signal, excitation.independent))
    for row, axis in enumerate(axes[:, 0]):
        part = slice(size * row, size * (row + 1))
        x = np.arange(len(names[part]))
        axis.vlines(x, own[part], whole[part], color="0.6", linewidth=1.0)
        axis.plot(x, whole[part], "_", color="black", markersize=8, label="its torque")
        axis.plot(x, own[part], "o", color=BLUE, markersize=4, label="the part no other parameter can imitate")
        _limit(axis, _GOOD, "relative sigma 10 %")
        axis.set_xlim(-0.8, size - 0.2)
        axis.set_ylabel("torque over noise")
        plain(axis)
        names_below(axis, names[part], 8)
    log_scale(axes[0, 0])
    legend(figure, [axes[0, 0]], "upper center")
    return figure


def essential_section(elimination: EliminationDocument | None, title: str) -> Section:
    """The path of the elimination as a figure, the parameters by name, and what speaks against them."""
    heading = "Essential parameters"
    if elimination is None:
        text = "Parameters are eliminated for method 4 only, robot and payload together; it was not used here."
        return Section("essential", heading, [OnPage(lambda: [Text(text)])])
    lines = [
        f"{elimination.essential} of {len(elimination.path) - 1} parameters essential "
        f"({elimination.description}): error's sigma {elimination.sigma_ratio:.4f} times, largest relative "
        f"sigma {elimination.largest_relative_sigma_percent:.3g} %.",
        f"Essential: {', '.join(str(parameter.name) for parameter in elimination.parameters)}.",
        *(f"  - {warning}" for warning in elimination.warnings),
    ]
    return Section("essential", heading, [Notes(lines), essential_figure(elimination, title)])


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

    def draw() -> Figure:
        gone, limit = count - essential, present(elimination.limit)
        ratios = np.array([step.sigma_ratio for step in elimination.path], dtype=float)
        percents = np.array([step.largest_relative_sigma_percent for step in elimination.path], dtype=float)
        shown = min(max(int(np.sum(ratios <= _MOST_RATIO)), gone + 2), count)
        names = ["none", *(str(step.eliminated) for step in elimination.path[1:shown])]
        edges = (1.0, 0.1, 0.4, 0.4 + 0.07 * max(map(len, names)))
        figure, axes = panels((max(6.0, 0.19 * shown + 1.5), 5.2), 2, 1, edges)
        above, below = axes[:, 0]
        _steps(above, ratios[:shown], gone, "error sigma, ratio\nto all parameters")
        _steps(below, percents[:shown], gone, "largest relative\nsigma [%]")
        if limit is not None and elimination.rule == "ratio":
            _limit(above, limit, f"limit {limit:g}")
        elif limit is not None:
            _limit(below, 100.0 * limit, f"limit {100.0 * limit:g} %")
        above.legend(loc="upper left")
        log_scale(below)
        lines_above(above, shown)
        names_below(below, names, 7)
        below.set_xlabel("eliminated, in this order")
        figure.suptitle(f"{title}: {essential} of {count} parameters essential")
        return figure

    return Drawing("essential_path", caption, draw, text)


def _limit(axis: Axes, value: float, label: str) -> None:
    axis.axhline(value, color="black", linestyle="--", linewidth=1.0)
    look: dict[str, Any] = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points", "fontsize": 8}
    axis.annotate(label, (1.0, value), xytext=(-4, 3), ha="right", **look)


def _steps(axis: Axes, values: Array, gone: int, label: str) -> None:
    """Line with filled markers up to ``gone`` and open ones after it."""
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
    axis.set_xlim(-1.0, len(values))
    axis.set_ylabel(label)
    axis.grid(visible=True, alpha=0.3)
