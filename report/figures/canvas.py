"""An empty figure, and a figure as a file or as text: the only place that imports matplotlib."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GREY, BLUE, ORANGE = "0.62", "#0072b2", "#d55e00"
"""Colours that differ in lightness too; every curve has its own line or marker as well."""
_METADATA: dict[str, dict[str, Any]] = {
    ".png": {"Software": None},
    ".svg": {"Date": None},
    ".pdf": {"CreationDate": None},
}
"""What would differ from one day to the next."""


def matplotlib() -> Any:
    """The package with what figures are made of, imported when the first one is drawn."""
    import matplotlib.backends.backend_agg
    import matplotlib.figure
    import matplotlib.patches

    return matplotlib


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of that size [inches]."""
    package = matplotlib()
    figure: Figure = package.figure.Figure(figsize=(width, height), layout="constrained")
    package.backends.backend_agg.FigureCanvasAgg(figure)
    return figure


def plain(axis: Axes) -> None:
    """A light grid, and no frame at the top and the right."""
    axis.grid(visible=True, color="0.9", linewidth=0.6)
    axis.set_axisbelow(True)
    axis.spines[["top", "right"]].set_visible(False)


def mark_interval(axis: Axes, low: float, high: float) -> None:
    """A band of an interval, where there is one."""
    if np.isfinite([low, high]).all():
        axis.axvspan(low, high, facecolor="0.9", edgecolor="0.7", hatch="//", linewidth=0.0)


def save_figure(figure: Figure, path: str | Path, dpi: int = 130) -> None:
    """Write a figure as PNG, SVG or PDF by the path's ending; the same figure gives the same bytes."""
    with matplotlib().rc_context({"svg.hashsalt": "dynident"}):
        figure.savefig(path, dpi=dpi, metadata=_METADATA.get(Path(path).suffix.lower()))


def svg_text(figure: Figure, name: str) -> str:
    """A figure as an SVG document whose text stays text; ``name`` makes its identifiers its own."""
    stream = io.StringIO()
    with matplotlib().rc_context({"svg.hashsalt": name, "svg.fonttype": "none", "axes.unicode_minus": True}):
        figure.savefig(stream, format="svg", metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")))
    return stream.getvalue()
