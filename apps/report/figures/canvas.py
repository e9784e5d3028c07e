"""An empty figure, and a figure as a file or as text: the only place that imports matplotlib."""

import io
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

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


def panels(size: tuple[float, float], rows: int = 1, columns: int = 1, **options: Any) -> tuple[Figure, Any]:
    """A figure of width and height [inches] and its panels, shape (rows, columns); ``options``: of ``subplots``."""
    figure = _shown()(figsize=size, layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **options)


def legend(figure: Figure, axes: Iterable[Axes]) -> None:
    """One legend below several panels, each name once."""
    entries = [pair for axis in axes for pair in zip(*axis.get_legend_handles_labels(), strict=True)]
    if handles := {label: handle for handle, label in entries}:
        look: dict[str, Any] = {"ncols": min(len(handles), 4), "frameon": False, "loc": "outside lower center"}
        figure.legend(list(handles.values()), list(handles), fontsize=9, **look)


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


def named(axis: Axes, names: Sequence[str]) -> None:
    """Upright names below the whole numbers from 0 on."""
    axis.set_xticks(range(len(names)), names, rotation=90, fontsize=7)
    axis.tick_params(axis="x", length=0)
    axis.set_xlim(-0.8, len(names) - 0.2)
    plain(axis)


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
    """A figure as a file; names of robots and files are no formulas, whatever dollars they hold."""
    package, content = matplotlib(), io.BytesIO()
    for text in figure.findobj(package.text.Text):
        text.set_parse_math(False)
    with package.rc_context({**settings, "text.parse_math": False}):
        figure.draw_without_rendering()  # laid out once, for that takes longest
        figure.set_layout_engine("none")
        figure.savefig(content, **options)
    return content.getvalue()
