"""Figures of an arm and its motion: from three sides, between its limits, and predicted standard deviations."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ....common.arrays import Array
from ....model import Motion, Robot
from ....model.frames import frames_at, step
from ....trajectories import DesignProblem
from ....trajectories.design.score import Learnt, load_torques
from ..blocks import Drawing
from .canvas import Figure, log_scale, names_below, panels, save_figure
from .signals import Column, over_time

_FEW = 4  # parameters a figure names as the least known
_UNITS = {"position": ("m", "rad"), "speed": ("m/s", "rad/s"), "torque": ("N", "N·m")}
"""Units of sliding and of turning joints."""
_VIEWS = (("from the side", 0, 2), ("from the front", 1, 2), ("from above", 0, 1))


def motion_figure(problem: DesignProblem, motion: Motion, title: str) -> Drawing:
    """Positions, speeds and torques of every joint between their limits: a row a joint, a column a quantity."""

    def draw() -> Figure:
        bounds, torques = problem.bounds, load_torques(problem, motion)
        turning = sorted({joint.revolute for joint in problem.robot.joints}, reverse=True)

        def column(name: str, curves: Mapping[str, Array], low: Array, high: Array) -> Column:
            unit = " or ".join(_UNITS[name][kind] for kind in turning)
            return f"{name} [{unit}]", curves, np.stack([low, high])

        columns = [
            column("position", {"position": motion.q}, bounds.low, bounds.high),
            column("speed", {"speed": motion.qd}, -bounds.speed, bounds.speed),
            *([column("torque", torques, -bounds.torque, bounds.torque)] if torques else []),
        ]
        return over_time(title, motion.t, columns)

    return Drawing("motion", "Positions, speeds and torques of every joint between their limits, over time.", draw)


def sigma_figure(learnt: Learnt, title: str, reference: Mapping[str, float], labels: Mapping[str, str]) -> Drawing:
    """Predicted standard deviation of every parameter: relative where a reference value is known, else in SI units.

    ``labels`` are shown in the place of parameters' names ("ZZ1R").
    """

    def draw() -> Figure:
        relative = learnt.relative_sigma(reference)
        percent = {labels.get(name, name): 100.0 * x for name, x in relative.items()}
        absolute = {labels.get(name, name): x for name, x in learnt.sigma.items() if name not in relative}
        parts = [pair for pair in (("relative to its value [%]", percent), ("in SI units", absolute)) if pair[1]]
        longest = 0.07 * max(len(name) for _, values in parts for name in values)
        size = max(0.17 * max(len(values) for _, values in parts) + 1.2, 6.0), 2.8 * len(parts) + 0.5
        figure, axes = panels(size, len(parts), 1, (0.9, 0.1, 0.4, 0.2 + longest), (0.0, 0.3 + longest))
        for axis, (unit, values) in zip(axes[:, 0], parts, strict=True):
            heights = np.array(list(values.values()))
            axis.bar(np.arange(len(heights)), heights, color="0.75", edgecolor="black", linewidth=0.6)
            axis.set_ylim(0.5 * heights.min(), 6.0 * heights.max())
            log_scale(axis)
            for k in np.argsort(-heights, kind="stable")[:_FEW]:  # the least known with their number
                position: tuple[float, float] = (k, heights[k])
                axis.annotate(f"{heights[k]:.2g}", position, ha="center", va="bottom", fontsize=7, rotation=90)
            names_below(axis, list(values), 7)
            axis.set_xlim(-0.8, len(heights) - 0.2)
            axis.grid(visible=True, axis="y", alpha=0.3)
            axis.set_ylabel(f"predicted sigma\n{unit}", fontsize=9)
        figure.suptitle(title)
        return figure

    caption = "Standard deviation that identification would leave to each parameter, predicted."
    return Drawing("predicted_sigma", caption, draw)


def save_drawing(path: str | Path, robot: Robot, q: Sequence[float], title: str) -> None:
    """Draw the arm at a pose [rad or m] from three sides with its joint axes, as PNG, SVG or PDF.

    Each view has an axis of the base to the right, another one upwards, in mm. From frame to frame the arm is drawn
    along x, then along the joint's axis.
    """
    figure, (axes,) = panels((15.0, 5.6), 1, 3, (0.8, 0.1, 0.7, 0.5), (0.85, 0.0))
    frames = frames_at(robot, q)
    bends = [np.zeros(3), frames[0].p]
    for before, frame, joint, position in zip(frames, frames[1:], robot.joints, q, strict=False):
        bends += [(before @ step(joint, position)[0]).p, frame.p]
    corners = 1e3 * np.array([*bends, frames[-1].p])
    size = max(float(np.ptp(corners, axis=0).max()), 1.0)
    for axis, (name, a, b) in zip(axes, _VIEWS, strict=True):
        axis.plot(corners[:, a], corners[:, b], color="0.4", linewidth=3.0, solid_capstyle="round", zorder=1)
        for number, frame in enumerate(frames[1:-1], start=1):
            start, end = 1e3 * frame.p, 1e3 * frame.p + 0.12 * size * frame.R[:, 2]
            arrow = {"arrowstyle": "->", "color": "C0"}
            axis.annotate("", xy=(end[a], end[b]), xytext=(start[a], start[b]), arrowprops=arrow)
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
