"""Figures of torques, and files of figures. matplotlib is imported in this room only."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..common.arrays import Array
from ..estimation.equations import Observation
from ..model import Recording

_STRETCHES = 2000  # of a long signal that are drawn

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


def save_signals(path: str | Path, recording: Recording, unit: str) -> None:
    """Positions and torques of every joint over time, as PNG, SVG or PDF.

    Args:
        path: file; its ending chooses the format.
        recording: what to draw; of long ones the extremes of short stretches.
        unit: of its torques, "N·m" or "A".
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    n = recording.q.shape[1]
    figure = Figure(figsize=(11.0, 1.5 * n + 0.8), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(n, 2, sharex=True, squeeze=False)
    for j in range(n):
        for axis, values, label in zip(
            axes[j],
            (recording.q, recording.torque),
            (f"q{j + 1} [rad or m]", f"joint {j + 1} [{unit}]"),
            strict=True,
        ):
            axis.plot(*_thinned(recording.t, values[:, j]), linewidth=0.8)
            axis.set_ylabel(label)
            axis.grid(visible=True, alpha=0.3)
    for axis in axes[-1]:
        axis.set_xlabel("time [s]")
    figure.suptitle(Path(recording.source).name)
    save_figure(figure, path)


def _thinned(t: Array, values: Array) -> tuple[Array, Array]:
    """Smallest and largest value of each of some thousand stretches, in the order of time."""
    size = len(t) // _STRETCHES
    if size < 4:
        return t, values
    count = len(t) // size
    parts = values[: count * size].reshape(count, size)
    places = np.sort(np.stack([parts.argmin(axis=1), parts.argmax(axis=1)], axis=1), axis=1)
    chosen = (places + size * np.arange(count)[:, None]).ravel()
    return t[chosen], values[chosen]
