"""Figures of torques, and files of figures. matplotlib is imported in this room only."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..estimation import Observation
from ..model.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def save_figure(figure: Figure, path: str | Path) -> None:
    """Write a figure as PNG, SVG or PDF by the path's ending; the same figure gives the same bytes."""
    import matplotlib

    metadata: dict[str, dict[str, Any]] = {
        ".png": {"Software": None},
        ".svg": {"Date": None},
        ".pdf": {"CreationDate": None},
    }
    with matplotlib.rc_context({"svg.hashsalt": "dynident"}):
        figure.savefig(path, dpi=130, metadata=metadata.get(Path(path).suffix.lower()))


def save_torques(
    path: str | Path, observation: Observation, curves: Sequence[tuple[str, Array]], title: str
) -> None:
    """``torque_figure`` as a file."""
    save_figure(torque_figure(observation, curves, title), path)


def torque_figure(observation: Observation, curves: Sequence[tuple[str, Array]], title: str) -> Figure:
    """Measured and predicted torques of every joint, one below the other.

    Args:
        observation: measured torques Y and the columns W.
        curves: (label, parameters chi of ``observation.columns``) of each prediction W chi.
        title: above the figure.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    n = len(observation.Y)
    figure = Figure(figsize=(8.0, 1.6 * n + 0.8), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(n, 1, sharex=True, squeeze=False)[:, 0]
    styles = ("-", "--", ":", "-.")
    for j, axis in enumerate(axes):
        t = observation.t[j]
        axis.plot(t, observation.Y[j], ".", color="0.6", markersize=3, label="measured")
        for k, (label, chi) in enumerate(curves):
            axis.plot(t, observation.W[j] @ chi, styles[k % 4], linewidth=1.1, label=label)
        axis.set_ylabel(f"joint {j + 1} [N·m]")
        axis.grid(visible=True, alpha=0.3)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(curves) + 1)
    axes[-1].set_xlabel("time [s]")
    figure.suptitle(title)
    return figure
