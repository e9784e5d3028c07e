"""A stick figure of an arm, to lay beside the data sheet."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ....common.arrays import Array
from ....model import Robot
from ....model.frames import frames_at, step
from .canvas import panels, save_figure

_VIEWS = (("from the side", 0, 2), ("from the front", 1, 2), ("from above", 0, 1))


def outline(robot: Robot, q: Sequence[float]) -> Array:
    """Corners of the arm's stick figure in the base [m]: along x of each frame, then along its joint's axis.

    Shape (2 n + 3, 3): the base, two corners a joint, frame n's origin last but one, the payload's frame last.
    """
    frames = frames_at(robot, q)
    corners = [np.zeros(3), frames[0].p]
    for before, frame, joint, position in zip(frames, frames[1:], robot.joints, q, strict=False):
        corners += [(before @ step(joint, position)[0]).p, frame.p]
    return np.array([*corners, frames[-1].p])


def save_drawing(path: str | Path, robot: Robot, q: Sequence[float], title: str) -> None:
    """Draw the arm from three sides with its joint axes, as PNG, SVG or PDF.

    Args:
        path: file; its ending chooses the format.
        q: joint positions [rad or m].
    """
    figure, (axes,) = panels((15.0, 5.6), 1, 3, (0.8, 0.1, 0.7, 0.5), (0.85, 0.0))
    for axis, view in zip(axes, _VIEWS, strict=True):
        _draw(axis, robot, q, *view)
    figure.suptitle(title)
    save_figure(figure, path, dpi=110)


def _draw(axis: Any, robot: Robot, q: Sequence[float], name: str, a: int, b: int) -> None:
    """One view: the base's axis ``a`` to the right, ``b`` upwards, in mm."""
    corners, frames = 1e3 * outline(robot, q), frames_at(robot, q)
    size = max(float(np.ptp(corners, axis=0).max()), 1.0)
    axis.plot(corners[:, a], corners[:, b], color="0.4", linewidth=3.0, solid_capstyle="round", zorder=1)
    for number, frame in enumerate(frames[1:-1], start=1):
        start, end = 1e3 * frame.p, 1e3 * frame.p + 0.12 * size * frame.R[:, 2]
        arrow = {"arrowstyle": "->", "color": "C0"}
        axis.annotate("", xy=(end[a], end[b]), xytext=(start[a], start[b]), arrowprops=arrow)
        axis.plot(start[a], start[b], "o", color="C0", markersize=5)
        axis.text(start[a] + 0.03 * size * (1 + number % 3), start[b] + 0.02 * size, str(number), color="C0")
    tip = frames[-1]
    for direction, colour, letter in zip(tip.R.T, ("C3", "C2", "C1"), "xyz", strict=True):
        start, end = 1e3 * tip.p, 1e3 * tip.p + 0.09 * size * direction
        axis.plot([start[a], end[a]], [start[b], end[b]], color=colour, linewidth=1.6)
        if np.hypot(direction[a], direction[b]) > 0.3:
            axis.text(end[a], end[b], letter, color=colour)
    axis.set_aspect("equal", adjustable="datalim")
    axis.margins(0.15)
    axis.grid(visible=True, alpha=0.3)
    axis.set(title=name, xlabel=f"{'xyz'[a]} of the base [mm]", ylabel=f"{'xyz'[b]} of the base [mm]")
