"""Signals of a recording over time."""

from pathlib import Path

import numpy as np

from ....common.arrays import Array
from ....model import Recording
from ..blocks import Drawing
from .canvas import Figure, panels

_STRETCHES = 2000  # of a long signal that are drawn


def signals_figure(recording: Recording, unit: str, name: str) -> Drawing:
    """Positions and torques of every joint over time; ``unit`` of the torques, "N·m" or "A".

    ``name``: of the drawing. Of long recordings the extremes of short stretches are drawn.
    """
    source = Path(recording.source).name
    loads = "currents" if unit == "A" else "torques"
    caption = f"Positions and {loads} of {source} as they were understood, joint side."
    return Drawing(name, caption, caption, lambda: _curves(recording, unit, source))


def _curves(recording: Recording, unit: str, title: str) -> Figure:
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
    figure.suptitle(title)
    return figure


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
