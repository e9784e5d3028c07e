"""Signals of a recording over time."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...common.arrays import Array
from ...model import Recording
from .canvas import panels, save_figure

_STRETCHES = 2000  # of a long signal that are drawn


def save_signals(path: str | Path, recording: Recording, unit: str) -> None:
    """Positions and torques of every joint over time, as PNG, SVG or PDF.

    Args:
        path: file; its ending chooses the format.
        recording: what to draw; of long ones the extremes of short stretches.
        unit: of its torques, "N·m" or "A".
    """
    n = recording.q.shape[1]
    figure, axes = panels((11.0, 1.5 * n + 0.8), n, 2, (0.8, 0.1, 0.4, 0.5), (0.8, 0.2), sharex=True)
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
