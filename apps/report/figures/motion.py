"""Figures of an arm and its motion: from three sides, between its limits, what it would teach, as predicted."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ....common.arrays import Array
from ....model import Motion, Robot
from ....model.frames import frames_at, step
from ....trajectories import DesignProblem, Score
from ....trajectories.design.score import load_torques
from ...rollout import Rollout
from ..blocks import Drawing
from .canvas import BLUE, GREY, ORANGE, Figure, legend, log_scale, names_below, panels, plain, save_figure

_LINES = ("-", "--", ":", "-.")
_FEW = 4  # parameters a figure names as the least known
_TALLEST = 14.0  # inches


_MOTION = "Positions, speeds and torques of every joint between their limits, over time."
_SIGMA = "Standard deviation that identification would leave to each parameter, predicted."
_STYLES = ((BLUE, "-"), (ORANGE, "--"), (GREY, ":"), ("black", "-."))
_VIEWS = (("from the side", 0, 2), ("from the front", 1, 2), ("from above", 0, 1))


def motion_figure(problem: DesignProblem, motion: Motion, title: str) -> Drawing:
    """Positions, speeds and torques of every joint between their limits: a row a joint, a column a quantity."""
    return Drawing("motion", _MOTION, lambda: _draw_motion(problem, motion, title))


def _draw_motion(problem: DesignProblem, motion: Motion, title: str) -> Figure:
    bounds, torques = problem.bounds, load_torques(problem, motion)
    columns: list[tuple[str, dict[str, Array], Array, Array]] = [
        ("position", {"position": motion.q}, bounds.low, bounds.high),
        ("speed", {"speed": motion.qd}, -bounds.speed, bounds.speed),
    ]
    if torques:
        columns.append(("torque", torques, -bounds.torque, bounds.torque))
    n = motion.n
    size, edges = (3.4 * len(columns), min(1.25 * n + 1.0, _TALLEST)), (0.65, 0.1, 0.6, 0.75)
    figure, axes = panels(size, n, len(columns), edges, (0.5, 0.15), sharex=True)
    for k, (name, curves, low, high) in enumerate(columns):
        for j in range(n):
            axis = axes[j, k]
            _between(axis, motion.t, {label: values[:, j] for label, values in curves.items()}, low[j], high[j])
            axis.set_ylabel(f"joint {j + 1}" if k == 0 else "", fontsize=9)
        axes[0, k].set_title(f"{name} [{_unit(problem, name)}]", fontsize=10)
        axes[-1, k].set_xlabel("time [s]")
    legend(figure, axes[0], "lower center", fontsize=9)
    figure.suptitle(title)
    return figure


def sigma_figure(
    score: Score, title: str, reference: Mapping[str, float] | None = None, labels: Mapping[str, str] | None = None
) -> Drawing:
    """Predicted standard deviation of every parameter: relative where a reference value is known, else in SI units.

    Args:
        reference: values that standard deviations are relative to.
        labels: how to call parameters ("ZZ1R"), by their names.
    """
    draw = partial(_draw_sigma, score, title, reference or {}, labels or {})
    return Drawing("predicted_sigma", _SIGMA, draw)


def _draw_sigma(score: Score, title: str, reference: Mapping[str, float], labels: Mapping[str, str]) -> Figure:
    relative = score.relative_sigma(dict(reference))
    parts = [
        ("relative to its value [%]", {name: 100.0 * value for name, value in relative.items()}),
        ("in SI units", {name: value for name, value in score.learnt.sigma.items() if name not in relative}),
    ]
    parts = [(unit, values) for unit, values in parts if values]
    widest = max(len(values) for _, values in parts)
    longest = 0.07 * max(len(labels.get(name, name)) for _, values in parts for name in values)
    size = max(0.17 * widest + 1.2, 6.0), 2.8 * len(parts) + 0.5
    figure, axes = panels(size, len(parts), 1, (0.9, 0.1, 0.4, 0.2 + longest), (0.0, 0.3 + longest))
    for axis, (unit, values) in zip(axes[:, 0], parts, strict=True):
        _bars(axis, {labels.get(name, name): value for name, value in values.items()})
        axis.set_ylabel(f"predicted sigma\n{unit}", fontsize=9)
    figure.suptitle(title)
    return figure


def _between(axis: Any, t: Array, curves: Mapping[str, Array], low: float, high: float) -> None:
    """Curves, and the limits as lines with hatching beyond."""
    for k, (label, values) in enumerate(curves.items()):
        axis.plot(t, values, _LINES[k % len(_LINES)], color="black", linewidth=0.9, label=label)
    if np.isfinite([low, high]).all():
        for k, limit in enumerate((low, high)):
            axis.axhline(limit, color="C3", linestyle=(0, (6, 2)), linewidth=1.1, label="limit" if k == 0 else None)
        room = 0.12 * (high - low)
        for edge, beyond in ((low, low - room), (high, high + room)):
            axis.axhspan(*sorted((edge, beyond)), facecolor="none", edgecolor="C3", hatch="////", linewidth=0.0)
        axis.set_ylim(low - room, high + room)
    axis.tick_params(labelsize=8)
    axis.grid(visible=True, alpha=0.3)


def _bars(axis: Any, values: Mapping[str, float]) -> None:
    """Bars on a logarithmic scale; the least known are named with their number."""
    heights = np.array(list(values.values()))
    place = np.arange(len(heights))
    axis.bar(place, heights, color="0.75", edgecolor="black", linewidth=0.6)
    axis.set_ylim(0.5 * heights.min(), 6.0 * heights.max())
    log_scale(axis)
    for k in np.argsort(-heights, kind="stable")[:_FEW]:
        axis.annotate(
            f"{heights[k]:.2g}", (place[k], heights[k]), ha="center", va="bottom", fontsize=7, rotation=90
        )
    names_below(axis, list(values), 7)
    axis.set_xlim(-0.8, len(heights) - 0.2)
    axis.grid(visible=True, axis="y", alpha=0.3)


def _unit(problem: DesignProblem, name: str) -> str:
    turning = {joint.revolute for joint in problem.robot.joints}
    units = {
        "position": {True: "rad", False: "m"},
        "speed": {True: "rad/s", False: "m/s"},
        "torque": {True: "N·m", False: "N"},
    }[name]
    return " or ".join(units[kind] for kind in sorted(turning, reverse=True))


def rollout_figure(rollout: Rollout, name: str, unit: tuple[str, float]) -> Drawing:
    """Median and 90 % of the starts by each prediction, in a unit of some size; ``name``: of the drawing."""
    caption = (
        f"Distance of predicted from measured motion on {rollout.source}, root mean square over the joints: median "
        "of the starts, shaded up to 90 %."
    )
    return Drawing(name, caption, lambda: _draw_rollout(rollout, unit))


def _draw_rollout(rollout: Rollout, unit: tuple[str, float]) -> Figure:
    figure, axes = panels((5.8, 3.2))
    axis = axes[0, 0]
    resting = bool(rollout.resting.all())
    for (by, _), (color, line) in zip(rollout.errors.items(), _STYLES, strict=False):
        spreads = [rollout.spread(by, float(seconds), resting) for seconds in rollout.times]
        low, high = np.array([spread for spread in spreads if spread is not None]).T / unit[1]
        axis.plot(rollout.times, low, color=color, linestyle=line, label=by)
        axis.fill_between(rollout.times, low, high, color=color, alpha=0.2, linewidth=0)
    log_scale(axis)
    axis.set_xlabel("time after the start [s]")
    axis.set_ylabel(f"error [{unit[0]}]")
    axis.legend(fontsize=9, frameon=False)
    plain(axis)
    return figure


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
        _draw_view(axis, robot, q, *view)
    figure.suptitle(title)
    save_figure(figure, path, dpi=110)


def _draw_view(axis: Any, robot: Robot, q: Sequence[float], name: str, a: int, b: int) -> None:
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
