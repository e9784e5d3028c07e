"""Panels, curves and files of figures, and the drawing of an arm; matplotlib is loaded where one is drawn."""

import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ...common.arrays import Array
from ...common.files import write_bytes
from ...model import Robot
from ...model.frames import frames_at, step

if TYPE_CHECKING:
    from matplotlib import axes as _axes
    from matplotlib import figure as _figure

Axes: TypeAlias = "_axes.Axes"
Figure: TypeAlias = "_figure.Figure"
GREY, BLUE, ORANGE = "0.62", "#0072b2", "#d55e00"
"""Colours that differ in lightness too; every curve has its own line or marker as well."""
LAG = "autocorrelation"
_DATED = {".png": "Software", ".svg": "Date", ".pdf": "CreationDate"}
"""Entries of files that would differ from one day to the next: they are left out."""
_NARROW = 30.0  # a logarithmic scale that spans less than this has three numbers a decade
_STRETCHES = 2000  # of a long signal that are drawn
_TALLEST = 14.0  # inches
VIEWS = {"from the side": (0, 2), "from the front": (1, 2), "from above": (0, 1)}
"""Axes to the right and upwards."""


def panels(
    size: tuple[float, float], rows: int = 1, columns: int = 1, framed: bool = False, **options: Any
) -> tuple[Figure, Any]:
    """A figure of width and height [inches] and its panels, shape (rows, columns); ``options``: of ``subplots``."""
    import matplotlib.figure  # when the first one is drawn

    figure: Any = matplotlib.figure.Figure(figsize=size, layout="constrained")
    # A notebook shows it, whatever backend it has chosen.
    figure._repr_svg_ = lambda: figure_bytes(figure, name="figure").decode()
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    for axis in () if framed else axes.flat:
        axis.grid(visible=True, color="0.9", linewidth=0.6)
        axis.set_axisbelow(True)
        axis.spines[["top", "right"]].set_visible(False)
    return figure, axes


def legend(figure: Figure, axes: Iterable[Axes]) -> None:
    """One legend below several panels, each name once."""
    entries = [pair for axis in axes for pair in zip(*axis.get_legend_handles_labels(), strict=True)]
    if handles := {label: handle for handle, label in entries}:
        look: dict[str, Any] = {"ncols": min(len(handles), 4), "frameon": False, "loc": "outside lower center"}
        figure.legend(list(handles.values()), list(handles), fontsize=9, **look)


def log_scale(axis: Axes) -> None:
    """A logarithmic scale with plain numbers, for what is drawn already."""
    from matplotlib import ticker

    axis.set_yscale("log")
    low, high = axis.get_ylim()
    axis.yaxis.set_major_locator(ticker.LogLocator(subs=(1.0, 2.0, 5.0) if high < _NARROW * low else (1.0,)))
    axis.yaxis.set_major_formatter(ticker.FormatStrFormatter("%g"))
    axis.yaxis.set_minor_locator(ticker.NullLocator())


def named_panels(rows: Sequence[Sequence[str]], **options: Any) -> tuple[Figure, list[Axes]]:
    """Panels one below the other, each with upright names below the whole numbers from 0 on."""
    size = (max(0.18 * max(map(len, rows)) + 1.2, 6.0), 2.5 * len(rows) + 0.5)
    figure, axes = panels(size, len(rows), **options)
    for axis, names in zip(axes[:, 0], rows, strict=True):
        axis.set_xticks(range(len(names)), names, rotation=90, fontsize=7)
        axis.tick_params(axis="x", length=0)
        axis.set_xlim(-0.8, len(names) - 0.2)
    return figure, list(axes[:, 0])


def interval_rows(
    axis: Axes, names: Sequence[str], known: Array, agreed: Sequence[float], missing: str = ""
) -> None:
    """A row a name: its value, low and high (N, 3), or a word; ``agreed``: those of all together."""
    middle, *band = agreed
    if np.isfinite(band).all():
        axis.axvspan(*band, facecolor="0.9", edgecolor="0.7", hatch="//", linewidth=0.0)
    if np.isfinite(middle):
        axis.axvline(middle, color="black", linestyle="--", linewidth=1.0)
    rows, box = np.arange(len(names)), {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
    axis.hlines(rows, known[:, 1], known[:, 2], color=BLUE, linewidth=2.0)
    axis.plot(known[:, 0], rows, "o", color=BLUE, markersize=6)
    for row in np.flatnonzero(np.isnan(known[:, 0])).tolist():
        axis.text(middle, row, missing, bbox=box, ha="center", va="center", fontsize=9, style="italic")
    axis.set_yticks(rows, names)
    axis.set_ylim(len(names) - 0.4, -0.6)


def by_joint(
    n: int, headings: Sequence[str], draw: Callable[[Sequence[Axes], int], None], title: str = "", **options: Any
) -> Figure:
    """A row a joint, a column a quantity; ``draw`` fills the panels of a joint, counted from 0."""
    figure, axes = panels((10.2, min(1.25 * n + 1.0, _TALLEST)), n, len(headings), sharex="col", **options)
    for j, row in enumerate(axes):
        draw(row, j)
        row[0].set_ylabel(f"joint {j + 1}", fontsize=9)
    for heading, column in zip(headings, axes.T, strict=True):
        for axis in column:
            axis.tick_params(labelsize=8)
        column[0].set_title(heading, fontsize=9)
        column[-1].set_xlabel("lag [s]" if heading == LAG else "time [s]")
    legend(figure, axes[0])
    figure.suptitle(title)
    return figure


def signals(t: Array, columns: Mapping[str, tuple[Mapping[str, Array], Sequence[Array]]], title: str) -> Figure:
    """Curves (N, n) by name under each heading, a row a joint, between their hatched limits if they are finite."""

    def draw(row: Sequence[Axes], j: int) -> None:
        for axis, (curves, limits) in zip(row, columns.values(), strict=True):
            for line, (label, values) in zip(cycle(("-", "--", ":", "-.")), curves.items(), strict=False):
                x, y, size = t, values[:, j], len(t) // _STRETCHES
                if size >= 4:  # smallest and largest value of each of some thousand stretches, in the order of time
                    parts = y[: len(t) // size * size].reshape(-1, size)
                    within = np.sort(np.stack([parts.argmin(axis=1), parts.argmax(axis=1)], axis=1), axis=1)
                    chosen = (within + size * np.arange(len(parts))[:, None]).ravel()
                    x, y = t[chosen], y[chosen]
                axis.plot(x, y, line, color="black", linewidth=0.9, label=label)
            low, high = (x[j] for x in limits) if limits else (np.nan, np.nan)
            if np.isfinite([low, high]).all():
                hatched: dict[str, Any] = {"facecolor": "none", "hatch": "////", "linewidth": 0.0}
                room = 0.12 * (high - low)
                for limit, beyond, label in ((low, low - room, "limit"), (high, high + room, "")):
                    axis.axhline(limit, color="C3", linestyle=(0, (6, 2)), linewidth=1.1, label=label)
                    axis.axhspan(*sorted((limit, beyond)), edgecolor="C3", **hatched)
                axis.set_ylim(low - room, high + room)

    n = next(values.shape[1] for curves, _ in columns.values() for values in curves.values())
    return by_joint(n, list(columns), draw, title)


def save_drawing(path: str | Path, robot: Robot, q: Sequence[float], title: str) -> None:
    """Draw the arm at a pose [rad or m] from three sides with its joint axes [mm], as PNG, SVG or PDF."""
    (figure, (axes,)), frames = panels((15.0, 5.6), 1, 3, framed=True), frames_at(robot, q)
    bends = [np.zeros(3), frames[0].p]
    for before, frame, joint, position in zip(frames, frames[1:], robot.joints, q, strict=False):
        bends += [(before @ step(joint, position)[0]).p, frame.p]
    corners = 1e3 * np.array([*bends, frames[-1].p])
    size = max(float(np.ptp(corners, axis=0).max()), 1.0)
    for axis, (name, (a, b)) in zip(axes, VIEWS.items(), strict=True):
        axis.plot(corners[:, a], corners[:, b], color="0.4", linewidth=3.0, solid_capstyle="round", zorder=1)
        for number, frame in enumerate(frames[1:-1], start=1):
            start, end = 1e3 * frame.p, 1e3 * frame.p + 0.12 * size * frame.R[:, 2]
            arrow = {"arrowstyle": "->", "color": "C0"}
            axis.annotate("", (end[a], end[b]), (start[a], start[b]), arrowprops=arrow)
            axis.plot(start[a], start[b], "o", color="C0", markersize=5)
            beside = 0.03 * size * (1 + number % 3)
            axis.text(start[a] + beside, start[b] + 0.02 * size, str(number), color="C0")
        for direction, colour, letter in zip(frames[-1].R.T, ("C3", "C2", "C1"), "xyz", strict=True):
            start, end = 1e3 * frames[-1].p, 1e3 * frames[-1].p + 0.09 * size * direction
            axis.plot([start[a], end[a]], [start[b], end[b]], color=colour, linewidth=1.6)
            if np.hypot(direction[a], direction[b]) > 0.3:
                axis.text(end[a], end[b], letter, color=colour)
        axis.set_aspect("equal", adjustable="datalim")
        axis.margins(0.15)
        axis.grid(visible=True, alpha=0.3)
        axis.set(title=name, xlabel=f"{'xyz'[a]} of the base [mm]", ylabel=f"{'xyz'[b]} of the base [mm]")
    figure.suptitle(title)
    save_figure(figure, path, dpi=110)


def save_figure(figure: Figure, path: str | Path, dpi: int = 130) -> None:
    """Write a figure as PNG, SVG or PDF by the path's ending; the same figure gives the same bytes."""
    write_bytes(path, figure_bytes(figure, Path(path).suffix.lower(), dpi=dpi))


def figure_bytes(figure: Figure, ending: str = ".svg", name: str = "", dpi: int = 130) -> bytes:
    """A figure as a file; with a ``name`` of a page, whose text stays text, its identifiers its own."""
    import matplotlib.text

    content = io.BytesIO()
    settings: dict[Any, Any] = {"svg.hashsalt": name or "dynident", "text.parse_math": False}
    left_out = [_DATED[ending]] if ending in _DATED else []
    if name:
        settings |= {"svg.fonttype": "none", "axes.unicode_minus": True}
        left_out = ["Date", "Creator", "Format", "Type"]
    for text in figure.findobj(matplotlib.text.Text):  # names of robots and files are no formulas
        text.set_parse_math(False)
    with matplotlib.rc_context(settings):
        figure.draw_without_rendering()  # laid out once, for that takes longest
        figure.set_layout_engine("none")
        figure.savefig(content, format=ending[1:], dpi=dpi, metadata=dict.fromkeys(left_out))
    return content.getvalue()
