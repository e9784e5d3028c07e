"""An empty figure, and a figure as a file or as text: the only place that imports matplotlib."""

import io
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ....common.arrays import Array
from ....common.files import write_bytes

if TYPE_CHECKING:
    from matplotlib import axes as _axes
    from matplotlib import figure as _figure

Axes: TypeAlias = "_axes.Axes"
Figure: TypeAlias = "_figure.Figure"
GREY, BLUE, ORANGE = "0.62", "#0072b2", "#d55e00"
"""Colours that differ in lightness too; every curve has its own line or marker as well."""
_DATED = {".png": "Software", ".svg": "Date", ".pdf": "CreationDate"}
"""Entries of files that would differ from one day to the next: they are left out."""
Scale: TypeAlias = Callable[[Array | float], Array]
"""From a row's values to places in a panel."""
_GRID: dict[str, Any] = {"color": "0.9", "linewidth": 0.6, "zorder": 0.5}
_NUMBERS = 4  # steps of a row's scale, at most
_INSET = 0.06  # part of a row's height that is left free above and below
_NARROW = 30.0  # a logarithmic scale that spans less than this has three numbers a decade


def matplotlib() -> Any:
    """The package with what figures are made of, imported when the first one is drawn."""
    import matplotlib.figure  # with it text, ticks and patches

    return matplotlib


@cache
def _shown() -> type[Figure]:
    from matplotlib.figure import Figure as Plain

    class Shown(Plain):
        """Figure that a notebook shows, whatever backend it has chosen."""

        def _repr_svg_(self) -> str:
            return svg_text(self, "figure")

    return Shown


def panels(
    size: tuple[float, float],
    rows: int = 1,
    columns: int = 1,
    edges: tuple[float, float, float, float] = (0.75, 0.15, 0.3, 0.5),
    gaps: tuple[float, float] = (0.55, 0.2),
    **options: Any,
) -> tuple[Figure, Any]:
    """A figure and its panels, shape (rows, columns), at fixed places: to search for places takes three drawings.

    ``size`` is width and height, ``edges`` room at the left, the right, above and below all panels, ``gaps`` those
    between columns and between rows [inches]; ``options`` are those of matplotlib's ``subplots``.
    """
    (width, height), (left, right, above, below) = size, edges
    wide = (width - left - right + gaps[0]) / columns - gaps[0]
    high = (height - above - below + gaps[1]) / rows - gaps[1]
    grid = {"left": left / width, "right": 1.0 - right / width, "wspace": gaps[0] / wide}
    grid |= {"top": 1.0 - above / height, "bottom": below / height, "hspace": gaps[1] / high}
    figure = _shown()(figsize=size)
    return figure, figure.subplots(rows, columns, squeeze=False, gridspec_kw=grid, **options)


def legend(figure: Figure, axes: Iterable[Axes], at: str, **options: Any) -> None:
    """One legend for several panels, each name once, at an edge of the figure: "upper center" or "lower center"."""
    entries = [pair for axis in axes for pair in zip(*axis.get_legend_handles_labels(), strict=True)]
    handles = {label: handle for handle, label in entries}
    look: dict[str, Any] = {"ncols": len(handles), "frameon": False, "borderaxespad": 0.2, "loc": at} | options
    if handles:
        figure.legend(list(handles.values()), list(handles), **look)


def log_scale(axis: Axes) -> None:
    """A logarithmic scale with plain numbers, for what is drawn already."""
    axis.set_yscale("log")
    (low, high), ticker = axis.get_ylim(), matplotlib().ticker
    axis.yaxis.set_major_locator(ticker.LogLocator(subs=(1.0, 2.0, 5.0) if high < _NARROW * low else (1.0,)))
    axis.yaxis.set_major_formatter(ticker.FormatStrFormatter("%g"))
    axis.yaxis.set_minor_locator(ticker.NullLocator())


def plain(axis: Axes) -> None:
    """A light grid, and no frame at the top and the right."""
    axis.grid(visible=True, color="0.9", linewidth=0.6)
    axis.set_axisbelow(True)
    axis.spines[["top", "right"]].set_visible(False)


def names_below(axis: Axes, names: Sequence[str], fontsize: float) -> None:
    """A name below each whole number from 0 on, without ticks: each tick is five things to make and to draw."""
    lines_above(axis, len(names))
    axis.xaxis.labelpad = 8.0 + 0.65 * fontsize * max(map(len, names), default=0)
    look: dict[str, Any] = {"rotation": 90, "ha": "center", "va": "top", "fontsize": fontsize}
    for position, name in enumerate(names):
        axis.annotate(name, (position, 0.0), (0, -4), axis.get_xaxis_transform(), "offset points", **look)


def lines_above(axis: Axes, count: int) -> None:
    """A light line at each whole number from 0 on, and no numbers."""
    axis.set_xticks([])
    axis.vlines(range(count), 0.0, 1.0, transform=axis.get_xaxis_transform(), **_GRID)


def bands(axis: Axes, ranges: Sequence[tuple[float, float]]) -> list[Scale]:
    """Rows one below the other in one panel, each with a scale of its own; a panel for each takes thrice as long.

    ``ranges`` are the lowest and highest value of each row, the topmost first; for each row what places its values
    in the panel is returned.
    """

    def scale(floor: int, low: float, high: float) -> Scale:
        room = 1.0 - 2.0 * _INSET
        return lambda values: np.asarray(floor + _INSET + room * (values - low) / (high - low))

    locator = matplotlib().ticker.MaxNLocator(_NUMBERS, steps=[1, 2, 5, 10])
    floors = range(len(ranges) - 1, -1, -1)
    scales = [scale(floor, *ends) for floor, ends in zip(floors, ranges, strict=True)]
    ticks = [[float(y) for y in locator.tick_values(*ends) if ends[0] <= y <= ends[1]] for ends in ranges]
    places = {float(scale(y)): y for scale, values in zip(scales, ticks, strict=True) for y in values}
    axis.set_ylim(0.0, float(len(ranges)))
    axis.set_xmargin(0.02)
    axis.set_yticks([])
    axis.yaxis.labelpad = 36.0
    plain(axis)
    across = axis.get_yaxis_transform()
    for position, y in places.items():
        text = f"{y:g}".replace("-", "\N{MINUS SIGN}")
        axis.annotate(text, (0.0, position), (-4, 0), across, "offset points", ha="right", va="center")
    axis.hlines(list(places), 0.0, 1.0, transform=across, **_GRID)
    axis.hlines(floors[:-1], 0.0, 1.0, color="0.3", linewidth=0.8, transform=across)
    return scales


def save_figure(figure: Figure, path: str | Path, dpi: int = 130) -> None:
    """Write a figure as PNG, SVG or PDF by the path's ending; the same figure gives the same bytes."""
    ending = Path(path).suffix.lower()
    metadata = {_DATED[ending]: None} if ending in _DATED else None
    content = _saved(figure, {"svg.hashsalt": "dynident"}, format=ending[1:], dpi=dpi, metadata=metadata)
    write_bytes(path, content)


def svg_text(figure: Figure, name: str) -> str:
    """A figure as an SVG document whose text stays text; ``name`` makes its identifiers its own."""
    settings = {"svg.hashsalt": name, "svg.fonttype": "none", "axes.unicode_minus": True}
    metadata = dict.fromkeys(("Date", "Creator", "Format", "Type"))
    return _saved(figure, settings, format="svg", metadata=metadata).decode()


def _saved(figure: Figure, settings: dict[str, Any], **options: Any) -> bytes:
    """A figure as a file; names of robots and files are no formulas, whatever dollars they hold.

    Ticks that are not there yet are left to be made when they are drawn: to ask for all takes a fifth of a page's
    time.
    """
    package, content = matplotlib(), io.BytesIO()
    artists: list[Any] = [figure]
    while artists:
        artist = artists.pop()
        if isinstance(artist, package.text.Text):
            artist.set_parse_math(False)
        if isinstance(artist, package.axis.Axis):
            ticks = (*vars(artist).get("majorTicks", ()), *vars(artist).get("minorTicks", ()))
            artists += [artist.label, *(label for tick in ticks for label in (tick.label1, tick.label2))]
        else:
            artists += artist.get_children()
    with package.rc_context({**settings, "text.parse_math": False}):
        figure.savefig(content, **options)
    return content.getvalue()
