"""An empty figure, a figure with its words, and files of figures."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ..plots import save_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GREY, BLUE, ORANGE = "0.62", "#0072b2", "#d55e00"
"""Colours that differ in lightness too; every curve has its own line or marker as well."""
ENDINGS = ("png", "svg", "pdf")
"""Kinds of files a figure is written as."""


@dataclass(frozen=True, eq=False)
class Drawing:
    """A figure and what is said about it.

    Attributes:
        name: of its file and of its place in the page.
        figure: the figure.
        caption: below it.
        text: what it shows, in words, for those who do not see it.
    """

    name: str
    figure: Figure
    caption: str
    text: str

    def __post_init__(self) -> None:
        """Arrange it once: every file of it then looks the same, and is written faster."""
        if self.figure.get_layout_engine() is not None:
            self.figure.draw_without_rendering()
            self.figure.set_layout_engine("none")


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of that size [inches]."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def plain(axis: Axes) -> None:
    """A light grid, and no frame at the top and the right."""
    axis.grid(visible=True, color="0.9", linewidth=0.6)
    axis.set_axisbelow(True)
    axis.spines[["top", "right"]].set_visible(False)


def save_drawings(folder: str | Path, drawings: Iterable[Drawing]) -> None:
    """Write each as PNG, SVG and PDF; the folder is made if missing."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for drawing in drawings:
        for ending in ENDINGS:
            save_figure(drawing.figure, folder / f"{drawing.name}.{ending}")
