"""Figures, drawn when they are looked at: of joints, of bodies, and as files; nothing else imports matplotlib."""

import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ...common.arrays import Array
from ...common.files import write_bytes
from ...estimation.fit.covariance import NORMAL95
from ...estimation.results.payload import PossibleEstimate, TorquePrediction, array
from ...model import Robot
from ...model.frames import frames_at, step
from .blocks import Drawing

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
_GAP = 2.5  # steps: a longer one is drawn as a gap
_CURVES = ((BLUE, "--", 1.3), (ORANGE, ":", 1.3), ("black", "-.", 1.0))
_PLATE = 31.5  # mm: half of the plate of ISO 9409-1-50, to compare sizes with
_VIEWS = {"from the side": (0, 2), "from the front": (1, 2), "from above": (0, 1)}
"""Axes to the right and upwards."""


def panels(
    size: tuple[float, float], rows: int = 1, columns: int = 1, framed: bool = False, **options: Any
) -> tuple[Figure, Any]:
    """A figure of width and height [inches] and its panels, shape (rows, columns); ``options``: of ``subplots``.

    Panels have a light grid and no frame at the top and the right, unless they are ``framed``.
    """
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


def signals(
    t: Array, columns: Iterable[tuple[Mapping[str, Array], Sequence[Array]]], row: Iterable[Axes], j: int
) -> None:
    """Curves (N, n) by name in each column, between its hatched limits where there are any that are finite."""
    for axis, (curves, limits) in zip(row, columns, strict=True):
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


def prediction_figures(prediction: TorquePrediction, name: str) -> tuple[Drawing, Drawing]:
    """The joint that the model explains worst, and every joint, a row each, called ``name``: torques, residuals."""
    n, relative, step = len(prediction.t), prediction.relative_per_joint, prediction.step
    worst = int(np.argmax(np.nan_to_num(relative, nan=-1.0)))
    percents = [f"{100.0 * ratio:.1f}" for ratio in relative]

    def parted(j: int, values: Array) -> tuple[Array, Array]:
        # Of long curves every so many points, with gaps where rows are missing.
        every = prediction.thinning(j)
        t, values = prediction.t[j][::every], values[::every]
        breaks = np.flatnonzero(np.diff(t) > _GAP * every * step) + 1
        return np.insert(t, breaks, np.nan), np.insert(values, breaks, np.nan)

    def drawn(row: Sequence[Axes], j: int) -> None:
        torque, residual, *autocorrelation = row
        torque.plot(*parted(j, prediction.measured[j]), "-", label="measured", color=GREY, linewidth=2.6)
        for (label, values), (colour, line, width) in zip(prediction.curves.items(), cycle(_CURVES), strict=False):
            torque.plot(*parted(j, values[j]), line, label=label, color=colour, linewidth=width)
        left = prediction.residual(j)
        largest = 1.15 * float(np.abs(left).max(initial=0.0)) or 1.0
        residual.set_ylim(-largest, largest)
        residual.axhline(0.0, color="0.4", linewidth=0.6)
        residual.plot(*parted(j, left), color="black", linewidth=0.8)
        for axis in autocorrelation:
            at: dict[str, Any] = {"xycoords": "axes fraction", "ha": "right", "va": "top", "fontsize": 8}
            residual.annotate(f"{percents[j]} %", (0.99, 0.95), **at)
            axis.plot(*prediction.autocorrelation(j), color="black", linewidth=1.0)
            axis.axhline(0.0, color="0.4", linewidth=0.6)
            for level in np.array([-NORMAL95, NORMAL95]) / np.sqrt(max(len(prediction.t[j]), 1)):
                axis.axhline(level, color="0.4", linestyle="--", linewidth=0.8)

    def draw() -> Figure:
        figure, ((above,), (below,)) = panels((5.8, 3.2), 2, sharex=True, height_ratios=(2, 1))
        drawn((above, below), worst)
        above.set_ylabel(f"joint {worst + 1} [N·m]")
        legend(figure, [above])
        below.set(xlabel="time [s]", ylabel="residual")
        return figure

    of_one = (
        f"Joint {worst + 1}, the one that the model explains worst: residual {percents[worst]} % of its torque, on "
        f"{words_of(prediction)}. Pauses and slow rows are left out."
    )
    of_all = (
        f"Every joint on {words_of(prediction)}: torque, residual, and the residual's autocorrelation; the dashed "
        "lines hold 95 % of it if the noise were white."
    )
    every = partial(by_joint, n, ("torque [N·m]", "residual [N·m]", LAG), drawn, width_ratios=(5, 3, 2))
    text = f"{of_all} Relative residuals of the joints in percent: {', '.join(percents)}."
    return Drawing("worst_joint", of_one, draw), Drawing(name, of_all, every, text)


def words_of(prediction: TorquePrediction) -> str:
    """Name the recording, and say whether it was used."""
    load = "with payload" if prediction.loaded else "without payload"
    used = "held out of identification" if prediction.held_out else "the data that were fitted, not held out"
    return f"{prediction.source}{'' if load in prediction.source else f' {load}'} ({used})"


def flange_figure(payload: PossibleEstimate, inertia: bool, flange: bool) -> Drawing:
    """Three views to one scale, the uncertainty enlarged; a body of its ``inertia``, a plate at the ``flange``."""
    com, ends = 1e3 * array(payload.com, 3), 1e3 * array(payload.com_interval95, 3, 2)
    origin = "the flange, drawn as a plate of 63 mm (ISO 9409-1-50)" if flange else "the frame's origin"
    caption = f"Centre of mass seen along y, along x and along z, from {origin}, to scale."
    body, known = None, bool(np.isfinite(ends).all())
    if known:
        caption += " Bars and ellipse: its 95 % intervals, enlarged below."
    if inertia:
        # Squared semi-axes of the homogeneous ellipsoid of the same inertia, as a matrix [mm^2].
        J = array(payload.inertia_com, 3, 3)
        body = 5e6 / payload.body.mass * (0.5 * np.trace(J) * np.eye(3) - J)
        caption += " Dashed: equivalent ellipsoid, homogeneous and of the identified mass and inertia."

    def draw() -> Figure:
        from matplotlib import patches

        points = [np.full(3, -1.25 * _PLATE), np.full(3, 1.25 * _PLATE), com - 12.0, com + 12.0]
        points += list(ends.T) if known else []
        if body is not None:
            reach = np.sqrt(np.maximum(np.diag(body), 0.0))
            points += [com - reach, com + reach]
        low, high = np.min(points, axis=0), np.max(points, axis=0)
        middle, half = 0.5 * (low + high), 0.53 * float((high - low).max())
        figure, axes = panels((6.6, 4.7 if known else 2.6), 1 + known, 3)
        for column, (i, k) in zip(axes.T, _VIEWS.values(), strict=True):
            above = column[0]
            if flange:
                look: dict[str, Any] = {"facecolor": "0.85", "edgecolor": "black", "hatch": "///"}
                side = patches.Rectangle((-_PLATE, -8.0), 2 * _PLATE, 8.0, **look)
                above.add_patch(side if k == 2 else patches.Circle((0.0, 0.0), _PLATE, **look))
            for tip, name in (((0.9 * _PLATE, 0.0), "xyz"[i]), ((0.0, 0.9 * _PLATE), "xyz"[k])):
                above.annotate("", tip, (0.0, 0.0), arrowprops={"arrowstyle": "-|>", "color": "black", "lw": 1.2})
                above.annotate(name, tip, xytext=(3, 3), textcoords="offset points", fontsize=9)
            if body is not None:
                squares, directions = np.linalg.eigh(body[np.ix_((i, k), (i, k))])
                angle = np.linspace(0.0, 2.0 * np.pi, 91)
                circle = np.sqrt(np.maximum(squares, 0.0))[:, None] * np.vstack([np.cos(angle), np.sin(angle)])
                outline = com[[i, k], None] + directions @ circle
                above.plot(*outline, "--", color="0.35", linewidth=1.2, label="equivalent ellipsoid")
            for axis in column:
                if known:
                    centre, width = ends.mean(axis=1), np.ptp(ends, axis=1)
                    look = {"facecolor": "none", "edgecolor": BLUE, "linewidth": 1.2, "hatch": "xxx"}
                    axis.add_patch(patches.Ellipse((centre[i], centre[k]), width[i], width[k], **look))
                    axis.plot(ends[i], [com[k]] * 2, color=BLUE, linewidth=1.6, label="95 % intervals")
                    axis.plot([com[i]] * 2, ends[k], color=BLUE, linewidth=1.6)
                mark: dict[str, Any] = {"color": ORANGE, "markeredgecolor": "black", "markersize": 5}
                axis.plot(com[i], com[k], "o", label="centre of mass", **mark)
                axis.set_aspect("equal", adjustable="box" if axis is above else "datalim")
                axis.set(xlabel=f"{'xyz'[i]} [mm]", ylabel=f"{'xyz'[k]} [mm]")
                axis.tick_params(labelsize=8)
                axis.locator_params(nbins=5)
                axis.margins(0.12)
            above.set(xlim=(middle[i] - half, middle[i] + half), ylim=(middle[k] - half, middle[k] + half))
        legend(figure, [axes[0, 0]])
        return figure

    where = ", ".join(f"{axis} {x:.1f} mm" for axis, x in zip("xyz", com, strict=True))
    return Drawing("flange", caption, draw, f"{caption} Centre of mass at {where}.")


def save_drawing(path: str | Path, robot: Robot, q: Sequence[float], title: str) -> None:
    """Draw the arm at a pose [rad or m] from three sides with its joint axes [mm], as PNG, SVG or PDF."""
    (figure, (axes,)), frames = panels((15.0, 5.6), 1, 3, framed=True), frames_at(robot, q)
    bends = [np.zeros(3), frames[0].p]
    for before, frame, joint, position in zip(frames, frames[1:], robot.joints, q, strict=False):
        bends += [(before @ step(joint, position)[0]).p, frame.p]
    corners = 1e3 * np.array([*bends, frames[-1].p])
    size = max(float(np.ptp(corners, axis=0).max()), 1.0)
    for axis, (name, (a, b)) in zip(axes, _VIEWS.items(), strict=True):
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
    """A figure as a file; with a ``name`` of a page, whose text stays text, its identifiers its own.

    Names of robots and files are no formulas, whatever dollars they hold.
    """
    import matplotlib.text

    content = io.BytesIO()
    settings: dict[Any, Any] = {"svg.hashsalt": name or "dynident", "text.parse_math": False}
    left_out = [_DATED[ending]] if ending in _DATED else []
    if name:
        settings |= {"svg.fonttype": "none", "axes.unicode_minus": True}
        left_out = ["Date", "Creator", "Format", "Type"]
    for text in figure.findobj(matplotlib.text.Text):
        text.set_parse_math(False)
    with matplotlib.rc_context(settings):
        figure.draw_without_rendering()  # laid out once, for that takes longest
        figure.set_layout_engine("none")
        figure.savefig(content, format=ending[1:], dpi=dpi, metadata=dict.fromkeys(left_out))
    return content.getvalue()
